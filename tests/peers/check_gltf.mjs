// Checks a GLB file with the Khronos validator: no error, no warning.
//
// usage: check_gltf.mjs FILE.glb     (FIBAR_PEERS names the folder that holds node_modules)

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

const file = process.argv[2];
if (!file) {
  console.error("usage: check_gltf.mjs FILE.glb");
  process.exit(2);
}
const require = createRequire(join(resolve(process.env.FIBAR_PEERS ?? "."), "package.json"));
const { issues, info } = await require("gltf-validator").validateBytes(new Uint8Array(readFileSync(file)));
console.log(
  `${info.totalTriangleCount} triangles, ${info.totalVertexCount} vertices, ${info.materialCount} materials: ` +
    `${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos, ${issues.numHints} hints`,
);
for (const { severity, code, message, pointer } of issues.messages) {
  console.error(`${file}${pointer ?? ""}: ${["error", "warning", "info", "hint"][severity]} ${code}: ${message}`);
}
process.exit(issues.numErrors + issues.numWarnings > 0 ? 1 : 0);
