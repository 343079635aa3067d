// What the viewer draws with: the surface and the sample on the graphics card, and the passes of a frame.

import { candidateTable } from "./candidates.js";
import { clipFromWorld, pixelRays } from "./camera.js";
import { imageTexture } from "./images.js";
import { unpackSample } from "./sample.js";
import { provokingVertices, surfaceTextures, unpackSurface } from "./surface.js";
import { layers, program, table, targetOfLayers, use } from "./textures.js";

const ROW = 1024;
const LAYERS = 4;
// Cells along each side of the disc of directions: half a degree each.
const DISC_SIDE = 256;
// While something moves, shares of images and of corners are lowered by so much.
const LOWERED = 0.2;
const LOWERED_CORNERS = 0.25;
const SAMPLES = [[0.125, 0.375], [-0.375, 0.125], [0.375, -0.125], [-0.125, -0.375]];

const text = (id) => document.getElementById(id).textContent;

// The even environment's share of the light; scattered samples have no image of it.
const environmentShare = ({ scattered }, light) => (scattered ? 0 : light.environment / light.irradiance);

export class Picture {
  // Uploads everything; `told` is called with the share that is done. Throws where the card cannot hold it.
  static async make(gl, about, numbers, told) {
    const made = new Picture(gl, about);
    made.uploadSurface(unpackSurface(about.surface, numbers.surface));
    const groups = unpackSample(about.sample, numbers.sample);
    const { texture, shape } = await imageTexture(gl, about.sample, groups, told);
    Object.assign(made, { images: texture, shape });
    if (gl.getError() !== gl.NO_ERROR) throw new Error("the graphics card has too little memory for the sample");
    return made;
  }

  constructor(gl, about) {
    this.gl = gl;
    this.about = about;
    const { scattered, linear } = about.sample;
    const weights = (role) => program(gl, text("full-vert"), text("weights-frag"),
      { VIEWS: 0, LIGHTS: 1, PAIRS: 2, ROLE: role, LINEAR: linear ? 1 : 0 });
    this.listViews = weights(scattered ? "PAIRS" : "VIEWS");
    this.listLights = scattered ? this.listViews : weights("LIGHTS");
    this.shading = program(gl, text("full-vert"), text("shade-frag"));
    this.seeing = program(gl, text("seen-vert"), text("seen-frag"));
    const { views, lights } = about.sample;
    const near = (list) => {
      const { table: numbers, width, rows } = candidateTable(list);
      return table(gl, [gl.RGBA32F, gl.RGBA, gl.FLOAT], width, rows, numbers);
    };
    if (scattered) {
      const numbers = Float32Array.from([...views, ...lights].flatMap((direction) => [...direction, 0]));
      this.pairs = table(gl, [gl.RGBA32F, gl.RGBA, gl.FLOAT], views.length, 2, numbers);
    }
    this.viewCandidates = near(scattered ? [[0, 0, 1]] : views);
    this.lightCandidates = scattered ? this.viewCandidates : near(lights);
    this.seenSize = [0, 0];
  }

  uploadSurface(surface) {
    const { gl } = this;
    const { data, normals, rows } = surfaceTextures(surface, ROW);
    this.vertices = table(gl, [gl.RGBA32F, gl.RGBA, gl.FLOAT], 3 * ROW, rows, data);
    this.normals = table(gl, [gl.RGBA32F, gl.RGBA, gl.FLOAT], ROW, rows, normals);
    const height = Math.ceil(surface.triangles / ROW), padded = new Uint32Array(4 * ROW * height);
    for (let f = 0; f < surface.triangles; f++) padded.set(surface.corners.subarray(3 * f, 3 * f + 3), 4 * f);
    this.triangles = table(gl, [gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT], ROW, height, padded);
    const lists = (width, height) => [0, 1].map(() => {
      const made = layers(gl, gl.RGBA32UI, width, height, LAYERS, gl.NEAREST);
      return { ...made, width, height, target: targetOfLayers(gl, made, LAYERS) };
    });
    this.ofVertices = lists(ROW, rows);
    // A scattered sample's lists depend on view and light at once: too many cells.
    this.ofDirections = this.about.sample.scattered ? null : lists(DISC_SIDE, DISC_SIDE + 1);
    this.uploadTriangles(surface, data);
    this.nothing = gl.createVertexArray();
  }

  uploadTriangles(surface, data) {
    const { gl } = this;
    const { sources, owner, elements } = provokingVertices(surface);
    const positions = new Float32Array(3 * (surface.vertices + sources.length));
    for (let i = 0; i < surface.vertices + sources.length; i++) {
      const v = i < surface.vertices ? i : sources[i - surface.vertices];
      positions.set(data.subarray(12 * v, 12 * v + 3), 3 * i);
    }
    this.mesh = gl.createVertexArray();
    gl.bindVertexArray(this.mesh);
    const buffer = (kind, numbers) => {
      gl.bindBuffer(kind, gl.createBuffer());
      gl.bufferData(kind, numbers, gl.STATIC_DRAW);
    };
    buffer(gl.ARRAY_BUFFER, positions);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    buffer(gl.ARRAY_BUFFER, Uint32Array.from(owner));
    gl.enableVertexAttribArray(1);
    gl.vertexAttribIPointer(1, 1, gl.UNSIGNED_INT, 0, 0);
    buffer(gl.ELEMENT_ARRAY_BUFFER, elements);
    this.elements = elements.length;
  }

  // Draws a frame for a camera and a light {towards, irradiance, environment}; `samples` per pixel, 1 or 4. Moving ones
  // take fewer images per pixel, by cells of directions where the sample allows.
  draw(camera, light, { samples, smoothTexels, moves }) {
    const { gl } = this;
    const byDirection = moves && this.ofDirections !== null;
    if (byDirection) this.listDirections(light);
    else this.listVertices(camera, light, moves ? LOWERED : 0);
    gl.blendFunc(gl.CONSTANT_ALPHA, gl.ONE_MINUS_CONSTANT_ALPHA);
    for (let i = 0; i < samples; i++) {
      const offset = samples === 1 ? [0, 0] : SAMPLES[i];
      this.see(camera, offset);
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      if (i > 0) {
        gl.enable(gl.BLEND);
        gl.blendColor(0, 0, 0, 1 / (i + 1));
      }
      this.shade(camera, light, offset, { smoothTexels, byDirection, lowered: moves ? LOWERED_CORNERS : 0 });
      gl.disable(gl.BLEND);
    }
  }

  // Returns when everything asked for is drawn.
  wait() {
    const { gl } = this;
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  // Fills the lists of vertices whose view or light has changed.
  listVertices(camera, light, lowered) {
    const { scattered } = this.about.sample;
    const { hasBorder } = this.about.surface;
    const common = { eye: camera.eye, light: light.towards, hasBorder: hasBorder ? 1 : 0, side: 0, lowered };
    const environment = environmentShare(this.about.sample, light);
    const seen = JSON.stringify([camera.eye, lowered, scattered && light.towards]);
    const lit = JSON.stringify([light.towards, environment, lowered, (scattered || hasBorder) && camera.eye]);
    const [views, lights] = this.ofVertices;
    if (seen !== this.listedSeen) this.fillViews(views, common);
    if (lit !== this.listedLit) this.fillLights(lights, { ...common, environment });
    Object.assign(this, { listedSeen: seen, listedLit: lit });
  }

  // Fills the lists of cells of directions; they change with the environment only.
  listDirections(light) {
    const environment = environmentShare(this.about.sample, light);
    if (environment === this.listedEnvironment) return;
    const [views, lights] = this.ofDirections;
    this.fillViews(views, { side: DISC_SIDE, lowered: LOWERED });
    this.fillLights(lights, { side: DISC_SIDE, lowered: LOWERED, environment });
    this.listedEnvironment = environment;
  }

  fillViews(list, values) {
    const { scattered, views } = this.about.sample;
    const skip = scattered ? 4 * LAYERS : 0;
    this.fill(list, this.listViews, { ...values, count: views.length, environment: 0, skip }, this.viewCandidates);
  }

  fillLights(list, values) {
    const { lights } = this.about.sample;
    this.fill(list, this.listLights, { ...values, count: lights.length, environmentColumn: lights.length, skip: 0 }, this.lightCandidates);
  }

  fill({ target, width, height }, shader, values, candidates) {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, target);
    gl.viewport(0, 0, width, height);
    use(gl, shader, { ...values, tilesAcross: this.shape.tilesAcross },
      { vertices: this.vertices, normals: this.normals, pairs: this.pairs ?? this.viewCandidates, candidates });
    gl.bindVertexArray(this.nothing);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // Finds the triangle that each pixel sees.
  see(camera, [x, y]) {
    const { gl } = this;
    this.fitSeen(gl.drawingBufferWidth, gl.drawingBufferHeight);
    const [width, height] = this.seenSize;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.seenTarget);
    gl.viewport(0, 0, width, height);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    const matrix = clipFromWorld(camera);
    for (let k = 0; k < 4; k++) {
      matrix[4 * k] -= (2 * x / width) * matrix[4 * k + 3];
      matrix[4 * k + 1] -= (2 * y / height) * matrix[4 * k + 3];
    }
    use(gl, this.seeing, { clipFromWorld: matrix }, {});
    gl.enable(gl.DEPTH_TEST);
    if (!this.about.surface.hasBorder) gl.enable(gl.CULL_FACE);
    gl.bindVertexArray(this.mesh);
    gl.drawElements(gl.TRIANGLES, this.elements, gl.UNSIGNED_INT, 0);
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.CULL_FACE);
  }

  fitSeen(width, height) {
    if (this.seenSize[0] === width && this.seenSize[1] === height) return;
    const { gl } = this;
    if (this.seen) gl.deleteTexture(this.seen.texture);
    if (this.depth) gl.deleteRenderbuffer(this.depth);
    this.seen = table(gl, [gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT], width, height, null);
    this.depth = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, this.depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
    this.seenTarget ??= gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.seenTarget);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.seen.texture, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.depth);
    this.seenSize = [width, height];
  }

  shade(camera, light, [x, y], { smoothTexels, byDirection, lowered }) {
    const { gl } = this;
    const { sample, surface, background } = this.about;
    const [width, height] = this.seenSize;
    const [views, lights] = byDirection ? this.ofDirections : this.ofVertices;
    const rays = pixelRays(camera, width, height);
    const corner = rays.corner.map((value, k) => value + x * rays.right[k] + y * rays.up[k]);
    gl.viewport(0, 0, width, height);
    use(gl, this.shading, {
      grid: [sample.width, sample.height], mapGrid: surface.grid, tileable: sample.tileable ? 1 : 0,
      smoothTexels: smoothTexels ? 1 : 0, scattered: sample.scattered ? 1 : 0, irradiance: light.irradiance, background,
      lowered, byDirection: byDirection ? 1 : 0, hasBorder: surface.hasBorder ? 1 : 0, light: light.towards,
      eye: camera.eye, corner, right: rays.right, up: rays.up,
    }, {
      seen: this.seen, triangles: this.triangles, vertices: this.vertices, views, lights, images: this.images,
    });
    gl.bindVertexArray(this.nothing);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }
}
