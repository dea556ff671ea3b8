// Prints what the Khronos validator says of GLB files, as a list of JSON reports.
import fs from "node:fs";
import path from "node:path";
import { createRequire } from "node:module";

const require = createRequire(path.join(process.env.ORUSD_NODE_MODULES, "any.js"));
const validator = require("gltf-validator");
const reports = [];
for (const file of process.argv.slice(2)) {
  reports.push(await validator.validateBytes(new Uint8Array(fs.readFileSync(file))));
}
console.log(JSON.stringify(reports));
