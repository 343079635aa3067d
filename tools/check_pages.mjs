#!/usr/bin/env node
// Checks the pages of `mesotex view` and `mesotex report` in headless Chromium with software graphics.
//
// Needs: Node.js 18 or later, `npm install playwright-core` in the folder it is run from, or one above, and Chromium
// (Debian: `apt-get install chromium`; CHROMIUM names another). tools/check_pages.sh installs both.
// Run:   node tools/check_pages.mjs MESOTEX X.sample Y.map.ply VIEW.html REPORT.html [SCREENSHOTS]
//
// VIEW.html and REPORT.html are pages of the sample and the map. At three views and lights the viewer's picture is
// compared with the frame that MESOTEX draws with `--shading pixel`; SCREENSHOTS is a folder for pictures of both pages.

import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join, resolve } from "node:path";

const require = createRequire(join(process.cwd(), "anything.js"));
const { chromium } = require("playwright-core");

const [mesotex, sample, map, viewPage, reportPage, screenshots] = process.argv.slice(2);
if (!reportPage) {
  console.error("usage: node tools/check_pages.mjs MESOTEX X.sample Y.map.ply VIEW.html REPORT.html [SCREENSHOTS]");
  process.exit(2);
}
if (screenshots) mkdirSync(screenshots, { recursive: true });

// Pictures are compared at a size that software draws soon, frames are timed at a usual one.
const SIZE = { width: 400, height: 300 };
const USUAL_SIZE = { width: 640, height: 480 };
// Angles of the view, and of the light as the viewer counts it: from the front, not from the camera.
const PAIRS = [
  { view: { azimuth: 0, elevation: 15 }, light: { azimuth: 30, elevation: 45 } },
  { view: { azimuth: 70, elevation: 40 }, light: { azimuth: 20, elevation: 60 } },
  { view: { azimuth: -130, elevation: 5 }, light: { azimuth: 170, elevation: 20 } },
];
const SOFTWARE = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];

let failures = 0;
function check(what, holds, found = "") {
  console.log(`${holds ? "ok    " : "FAILED"} ${what}${found === "" ? "" : `: ${found}`}`);
  if (!holds) failures += 1;
}

const launch = (flags) => chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-quic", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run", ...flags],
});

// A tab without network that collects what goes wrong in it.
async function open(browser, page, viewport = USUAL_SIZE) {
  const context = await browser.newContext({ viewport, offline: true });
  const tab = await context.newPage();
  const faults = [];
  tab.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  tab.on("pageerror", (error) => faults.push(error.message));
  tab.on("request", (request) => /^https?:/.test(request.url()) && faults.push(`asks for ${request.url()}`));
  await tab.goto(`file://${resolve(page)}`);
  await tab.waitForSelector("body[data-ready]", { timeout: 120_000 });
  return { tab, faults };
}

// The frame that `mesotex render` draws, as a data address. A camera of a file is fitted as the viewer's is.
function rendered({ view, light }) {
  const folder = mkdtempSync(join(tmpdir(), "frames-"));
  const azimuth = ((((light.azimuth - view.azimuth + 180) % 360) + 360) % 360) - 180;
  const camera = join(folder, "camera.csv");
  writeFileSync(camera, `camera_azimuth,camera_elevation\n${view.azimuth},${view.elevation}\n`);
  execFileSync(mesotex, ["render", sample, map, "-o", folder, "--quiet", "--shading", "pixel", "--shadows", "none",
    "--size", `${SIZE.width}x${SIZE.height}`, "--camera-path", camera, "--light-azimuth", azimuth, "--light-elevation", light.elevation].map(String));
  return `data:image/png;base64,${readFileSync(join(folder, "frame.0001.png")).toString("base64")}`;
}

// The mean difference of colours, in shares of the whole range, where either picture shows the surface.
const difference = (tab, state, address) => tab.evaluate(async ([state, address]) => {
  const image = new Image();
  image.src = address;
  await image.decode();
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width: image.width, height: image.height });
  const pen = canvas.getContext("2d");
  pen.drawImage(image, 0, 0);
  const wanted = pen.getImageData(0, 0, image.width, image.height).data;
  window.viewer.set(state);
  const { width, height, data } = window.viewer.pixels();
  if (width !== image.width || height !== image.height) throw new Error(`${width} × ${height} pixels`);
  const ground = wanted.slice(0, 3);
  let sum = 0, covered = 0;
  for (let row = 0; row < height; row++) {
    for (let column = 0; column < width; column++) {
      const a = 4 * (row * width + column), b = 4 * ((height - 1 - row) * width + column);
      const seen = [0, 1, 2].some((c) => Math.abs(wanted[a + c] - ground[c]) > 1 || Math.abs(data[b + c] - ground[c]) > 1);
      if (!seen) continue;
      covered += 1;
      for (let c = 0; c < 3; c++) sum += Math.abs(wanted[a + c] - data[b + c]) / (3 * 255);
    }
  }
  return { mean: sum / covered, covered: covered / (width * height) };
}, [state, address]);

// The mean difference of a frame that moves from one that stands still, at one sample per pixel.
const differenceMoving = (tab, state) => tab.evaluate((state) => {
  window.viewer.set(state);
  const [still, moving] = [false, true].map((moves) => window.viewer.pixels({ samples: 1, moves }).data);
  let sum = 0, covered = 0;
  for (let i = 0; i < still.length; i += 4) {
    if ([0, 1, 2].every((c) => still[i + c] === still[c])) continue;
    covered += 1;
    for (let c = 0; c < 3; c++) sum += Math.abs(still[i + c] - moving[i + c]) / (3 * 255);
  }
  return sum / covered;
}, state);

// The mean of all pixels of the viewer, 0 to 1, and a copy of them in the page.
const remember = (tab) => tab.evaluate(() => {
  const { data } = window.viewer.pixels({ samples: 1 });
  const before = window.before;
  window.before = data;
  let sum = 0, change = 0;
  for (let i = 0; i < data.length; i++) {
    sum += data[i];
    if (before) change += Math.abs(data[i] - before[i]);
  }
  return { mean: sum / data.length / 255, change: change / data.length / 255 };
});

async function drag(tab, [x, y], [dx, dy]) {
  await tab.mouse.move(x, y);
  await tab.mouse.down();
  await tab.mouse.move(x + dx, y + dy, { steps: 3 });
  await tab.mouse.up();
}

async function checkView(browser) {
  const { tab, faults } = await open(browser, viewPage, SIZE);
  check("the viewer draws", (await tab.getAttribute("body", "data-ready")) === "yes", await tab.textContent("#message"));
  const stated = Number.parseFloat(await tab.textContent("#error")) / 100;
  check("the stated error is at most 5 %", stated <= 0.05, stated);
  if (screenshots) await tab.screenshot({ path: join(screenshots, "view.png") });
  for (const pair of PAIRS) {
    const { mean, covered } = await difference(tab, pair, rendered(pair));
    const angles = `view ${pair.view.azimuth}, ${pair.view.elevation}, light ${pair.light.azimuth}, ${pair.light.elevation}`;
    check(`colours as rendered, ${angles}`, covered > 0.1 && mean <= stated + 0.02, `${(100 * mean).toFixed(2)} %`);
  }
  // A control: the wrong light does not pass.
  const [first, , third] = PAIRS;
  const control = await difference(tab, { view: first.view, light: third.light }, rendered(first));
  check("another light is told apart", control.mean > stated + 0.02, `${(100 * control.mean).toFixed(2)} %`);

  const moving = await differenceMoving(tab, first);
  check("a frame that moves is near to one that stands still", moving <= 0.04, `${(100 * moving).toFixed(2)} %`);

  await tab.evaluate((state) => window.viewer.set(state), { ...first });
  await remember(tab);
  await tab.keyboard.down("Shift");
  await drag(tab, [200, 125], [120, 30]);
  await tab.keyboard.up("Shift");
  check("shift-drag moves the light and changes the shading", (await remember(tab)).change > 0.005);
  const moved = await tab.evaluate(() => window.viewer.state.light.azimuth);
  check("the light's angle follows", moved !== first.light.azimuth, moved);
  await drag(tab, [200, 125], [-90, 20]);
  check("drag turns the surface", (await remember(tab)).change > 0.005);
  // Away from the controls.
  await tab.mouse.move(350, 40);
  await tab.mouse.wheel(0, -400);
  await tab.waitForFunction(() => window.viewer.state.zoom !== 1);
  check("the wheel zooms", (await remember(tab)).change > 0.005);
  const { mean: dark } = await remember(tab);
  await tab.check("#environment");
  check("the environment brightens", (await remember(tab)).mean > dark + 0.005);
  const pair = await tab.textContent("#angles");
  check("angles are shown", /view -?\d+°, -?\d+° · light -?\d+°, -?\d+°/.test(pair), pair);
  await tab.setViewportSize(USUAL_SIZE);
  const median = await tab.evaluate(() => window.viewer.medianFrame(15));
  console.log(`       median frame while view and light turn, ${USUAL_SIZE.width} × ${USUAL_SIZE.height} pixels: ${median.toFixed(0)} ms`);
  check("no errors in the viewer's console", faults.length === 0, faults.join("; "));
}

async function checkReport(browser) {
  const { tab, faults } = await open(browser, reportPage);
  if (screenshots) await tab.screenshot({ path: join(screenshots, "report.png"), fullPage: true });
  for (const id of ["sample", "textons", "mesh", "map", "frames", "stages"]) {
    check(`the report has a chapter on ${id}`, (await tab.locator(`#${id}-section`).count()) === 1);
  }
  const player = tab.locator(".player").first();
  const picture = () => player.locator("img").getAttribute("src");
  const before = await picture();
  await player.locator("input").fill("3");
  check("the slider changes the picture", (await picture()) !== before);
  const image = () => tab.evaluate(() => document.getElementById("image").toDataURL());
  const [shown, label] = [await image(), await tab.textContent("#pair")];
  await tab.locator("#lights").hover({ position: { x: 200, y: 120 } });
  await tab.locator("#views").hover({ position: { x: 60, y: 90 } });
  check("hovering over the dome changes the image", (await image()) !== shown);
  check("hovering over the dome changes its angles", (await tab.textContent("#pair")) !== label);
  check("figures of quality have their good ranges", (await tab.locator("#quality tr").count()) > 4);
  check("stages have their options", (await tab.locator("#stages code").count()) > 5);
  check("no errors in the report's console", faults.length === 0, faults.join("; "));
}

async function checkFallback() {
  const browser = await launch(["--disable-3d-apis"]);
  const { tab } = await open(browser, viewPage);
  const message = await tab.textContent("#message");
  check("without WebGL 2 the page says so", message.includes("WebGL 2"), message.slice(0, 60));
  await browser.close();
}

const browser = await launch(SOFTWARE);
await checkView(browser);
await checkReport(browser);
await browser.close();
await checkFallback();
process.exit(failures === 0 ? 0 : 1);
