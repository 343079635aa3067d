// The page of `mesotex view`: drag turns, shift-drag moves the light, the wheel zooms.

import { fittedCamera } from "./camera.js";
import { readDescription, readNumbers } from "./numbers.js";
import { Picture } from "./picture.js";
import { direction, turned } from "./vectors.js";

// Degrees per pixel of a drag.
const PACE = 0.4;
// A frame while something moves takes about so many milliseconds, or is drawn with fewer pixels.
const WANTED_FRAME = 60;
const STILL_AFTER = 200;

const element = (id) => document.getElementById(id);

class Viewer {
  constructor(canvas, about, picture) {
    Object.assign(this, { canvas, about, picture, detail: 1, movedAt: 0 });
    this.reset();
    new ResizeObserver(() => this.ask()).observe(canvas);
  }

  reset() {
    const { view, light } = this.about;
    this.state = { view: { ...view }, light: { ...light }, zoom: 1, environment: false, smoothTexels: true };
  }

  // Changes the state and draws.
  set(changes) {
    Object.assign(this.state, changes);
    this.movedAt = performance.now();
    this.ask();
  }

  ask() {
    if (!this.asked) this.asked = requestAnimationFrame(() => this.frame());
  }

  frame() {
    this.asked = 0;
    const begun = performance.now(), moves = begun - this.movedAt < STILL_AFTER;
    this.draw({ detail: moves ? this.detail : 1, samples: moves ? 1 : 4, moves });
    if (!moves) return;
    this.picture.wait();
    this.adapt(performance.now() - begun);
    setTimeout(() => this.ask(), 30);
  }

  // Fewer pixels where frames take too long, more where there is time.
  adapt(milliseconds) {
    const change = Math.sqrt(WANTED_FRAME / milliseconds);
    this.detail = Math.max(0.25, Math.min(1, this.detail * Math.max(0.5, Math.min(1.1, change))));
  }

  draw({ detail, samples, moves }) {
    const { canvas, about, state } = this;
    const ratio = Math.min(2, devicePixelRatio) * detail;
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const camera = fittedCamera(about, state.view, state.zoom, width / height);
    const towards = direction({ up: about.compass.up, zero: about.lightZero }, state.light);
    const environment = state.environment ? about.environment : 0;
    this.picture.draw(camera, { towards, irradiance: about.irradiance, environment },
      { samples, moves, smoothTexels: state.smoothTexels && !moves });
    this.tell();
  }

  tell() {
    const angles = ({ azimuth, elevation }) => `${azimuth.toFixed(0)}°, ${elevation.toFixed(0)}°`;
    element("angles").textContent =
      `view ${angles(this.state.view)} · light ${angles(this.state.light)} (azimuth, elevation)`;
  }

  listen() {
    const { canvas } = this;
    let last = null;
    canvas.addEventListener("pointerdown", (event) => {
      last = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointerup", () => {
      last = null;
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      const [x, y] = [PACE * (event.clientX - last[0]), PACE * (event.clientY - last[1])];
      last = [event.clientX, event.clientY];
      if (event.shiftKey) this.set({ light: turned(this.state.light, x, -y) });
      else this.set({ view: turned(this.state.view, -x, y) });
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.set({ zoom: Math.max(0.25, Math.min(40, this.state.zoom * Math.exp(-0.001 * event.deltaY))) });
    }, { passive: false });
    element("environment").addEventListener("change", (event) => this.set({ environment: event.target.checked }));
    element("smooth").addEventListener("change", (event) => this.set({ smoothTexels: event.target.checked }));
    element("reset").addEventListener("click", () => {
      this.reset();
      element("environment").checked = this.state.environment;
      element("smooth").checked = this.state.smoothTexels;
      this.set({});
    });
  }

  // What is drawn now: rows from below, red, green, blue, alpha.
  pixels({ samples = 4, moves = false } = {}) {
    const { gl } = this.picture;
    this.draw({ detail: 1, samples, moves });
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const data = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
    return { width, height, data };
  }

  // The median time of frames while view and light turn by turns, in milliseconds, each waited for.
  medianFrame(count) {
    const times = [];
    for (let i = 0; i < count; i++) {
      if (i % 2) this.state.view = turned(this.state.view, 5, 0);
      else this.state.light = turned(this.state.light, -5, 0);
      const begun = performance.now();
      this.draw({ detail: this.detail, samples: 1, moves: true });
      this.picture.wait();
      times.push(performance.now() - begun);
      this.adapt(times[i]);
    }
    return times.sort((a, b) => a - b)[Math.floor(count / 2)];
  }
}

function refuse(why) {
  element("message").textContent = why;
  element("message").hidden = false;
  element("controls").hidden = true;
  document.body.dataset.ready = "no";
}

async function start() {
  const canvas = element("canvas");
  const gl = canvas.getContext("webgl2", { antialias: false, alpha: false });
  if (!gl) {
    refuse("This page needs WebGL 2, which this browser does not offer. Try a current Firefox, Chromium or Safari with graphics " +
      "acceleration switched on; or draw frames with `mesotex render`.");
    return;
  }
  const about = readDescription("description");
  const progress = (share) => {
    element("message").hidden = share >= 1;
    element("message").textContent = `unpacking the sample: ${Math.round(100 * share)} %`;
  };
  progress(0);
  try {
    const numbers = { surface: await readNumbers("surface"), sample: await readNumbers("sample") };
    const picture = await Picture.make(gl, about, numbers, progress);
    const viewer = new Viewer(canvas, about, picture);
    viewer.listen();
    viewer.set({});
    window.viewer = viewer;
    document.body.dataset.ready = "yes";
  } catch (fault) {
    refuse(`The surface cannot be drawn here: ${fault.message}`);
  }
}

start();
