#!/usr/bin/env node
// Checks GLB files with the Khronos glTF validator; exit code 1 where any has an error or a warning.
//
// Needs: Node.js 18 or later and `npm install gltf-validator` in the folder it is run from, or one above.
// Run:   node tools/check_glb.mjs bunny.atlas/surface.glb …

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";

const require = createRequire(join(process.cwd(), "anything.js"));
const validator = require("gltf-validator");

let sound = process.argv.length > 2;
if (!sound) console.error("usage: node tools/check_glb.mjs FILE.glb …");
for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)));
  const { numErrors, numWarnings, numInfos, messages } = report.issues;
  const { totalVertexCount, totalTriangleCount, materialCount } = report.info;
  console.log(
    `${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} notes; ` +
      `${totalVertexCount} vertices, ${totalTriangleCount} triangles, ${materialCount} materials`,
  );
  for (const { code, message, pointer } of messages) console.log(`  ${code} ${pointer ?? ""}: ${message}`);
  sound &&= numErrors + numWarnings === 0;
}
process.exit(sound ? 0 : 1);
