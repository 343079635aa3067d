#!/usr/bin/env node
// Draws a GLB file with three.js in headless Chromium, Lambertian, without tone mapping: linear floats.
//
// Needs: Node.js 18 or later, `npm install three playwright-core` in the folder it is run from, or one above, and
// Chromium (Debian: `apt-get install chromium`; CHROMIUM names another).
// Run:   node tools/draw_glb.mjs FILE.glb VIEW.json OUT.f32
//
// VIEW.json: width, height, supersampling, fov (vertical, degrees), position, ahead and up of the camera, near, far,
// light (unit vector towards it), irradiance, and control: null, or "v", "green", "gamma", "cutoff" or "side" for a fault on
// purpose. OUT.f32: rows from the top of red, green, blue (premultiplied) and coverage.

import { readFile, writeFile } from "node:fs/promises";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";

const require = createRequire(join(process.cwd(), "anything.js"));
const { chromium } = require("playwright-core");
const three = dirname(dirname(require.resolve("three")));

const [glb, view, out] = process.argv.slice(2);
if (!out) {
  console.error("usage: node tools/draw_glb.mjs FILE.glb VIEW.json OUT.f32");
  process.exit(2);
}

const page = `<!doctype html><script type="importmap">
{"imports": {"three": "/three/build/three.module.js", "three/addons/": "/three/examples/jsm/"}}
</script><script type="module">
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

function upsideDown(texture) {
  texture.wrapT = THREE.RepeatWrapping;
  texture.repeat.y = -1;
  texture.offset.y = 1;
}

function lambertian(material, control) {
  const { map, normalMap, normalScale, alphaTest, transparent, side, color } = material;
  const found = new THREE.MeshLambertMaterial({ map, normalMap, alphaTest, transparent, side, color });
  found.normalScale.copy(normalScale);
  if (control === "v") for (const texture of [map, normalMap]) if (texture) upsideDown(texture);
  if (control === "green") found.normalScale.y *= -1;
  if (control === "gamma") map.colorSpace = THREE.NoColorSpace;
  if (control === "cutoff") found.alphaTest = 0.95;
  if (control === "side") found.side = THREE.FrontSide;
  return found;
}

// The mean of each block of factor x factor pixels, premultiplied; rows from the top.
function reduced(pixels, width, height, factor) {
  const found = new Float32Array(width * height * 4);
  for (let y = 0; y < height * factor; y++) {
    const row = height - 1 - Math.floor(y / factor);
    for (let x = 0; x < width * factor; x++) {
      const to = (row * width + Math.floor(x / factor)) * 4, from = (y * width * factor + x) * 4;
      for (let c = 0; c < 4; c++) found[to + c] += pixels[from + c] / (factor * factor);
    }
  }
  return found;
}

window.draw = async (view) => {
  const { width, height, supersampling: factor } = view;
  const renderer = new THREE.WebGLRenderer({ antialias: false, preserveDrawingBuffer: true });
  renderer.toneMapping = THREE.NoToneMapping;
  const scene = new THREE.Scene();
  const { scene: model } = await new GLTFLoader().loadAsync("/model.glb");
  model.traverse((node) => { if (node.isMesh) node.material = lambertian(node.material, view.control); });
  scene.add(model);
  const light = new THREE.DirectionalLight(0xffffff, view.irradiance);
  light.position.fromArray(view.light).multiplyScalar(1000);
  scene.add(light);
  const camera = new THREE.PerspectiveCamera(view.fov, width / height, view.near, view.far);
  camera.position.fromArray(view.position);
  camera.up.fromArray(view.up);
  camera.lookAt(camera.position.clone().add(new THREE.Vector3().fromArray(view.ahead)));
  const target = new THREE.WebGLRenderTarget(width * factor, height * factor, {
    type: THREE.FloatType, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
  renderer.setClearColor(0x000000, 0);
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const pixels = new Float32Array(width * height * factor * factor * 4);
  renderer.readRenderTargetPixels(target, 0, 0, width * factor, height * factor, pixels);
  const bytes = new Uint8Array(reduced(pixels, width, height, factor).buffer);
  let text = "";
  for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
  return btoa(text);
};
window.ready = true;
</script>`;

const server = createServer(async ({ url }, response) => {
  try {
    const type = url === "/" ? "text/html" : url.endsWith(".js") ? "text/javascript" : "application/octet-stream";
    const path = url.startsWith("/three/") ? join(three, new URL(url, "http://x").pathname.slice(7)) : glb;
    const body = url === "/" ? page : await readFile(path);
    response.writeHead(200, { "content-type": type }).end(body);
  } catch {
    response.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run"],
});
try {
  const tab = await browser.newPage();
  tab.on("console", (message) => message.type() === "error" && console.error(message.text()));
  tab.on("pageerror", (error) => console.error(error.message));
  await tab.goto(`http://127.0.0.1:${server.address().port}/`);
  await tab.waitForFunction("window.ready");
  const text = await tab.evaluate((given) => window.draw(given), JSON.parse(await readFile(view, "utf8")));
  await writeFile(out, Buffer.from(text, "base64"));
} finally {
  await browser.close();
  server.close();
}
