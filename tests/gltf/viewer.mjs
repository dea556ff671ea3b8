// Shows a GLB file in three.js and headless Chromium and saves pictures of it.
// node viewer.mjs JOB.json, with "modules" (a node_modules folder with three and puppeteer-core),
// "chromium", "glb", "camera", "width", "height", "exposure", "pictures": {kind: file.png};
// kinds: lit, base_color, ids. Writes "report": what three.js has found.
import fs from "node:fs";
import http from "node:http";
import path from "node:path";
import { createRequire } from "node:module";

const job = JSON.parse(fs.readFileSync(process.argv[2]));
const require = createRequire(path.join(job.modules, "any.js"));
const puppeteer = require("puppeteer-core");

const page_html = `<!doctype html><script type="importmap">{"imports": {
  "three": "/modules/three/build/three.module.js",
  "three/addons/": "/modules/three/examples/jsm/"}}</script><script type="module">
import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { DRACOLoader } from "three/addons/loaders/DRACOLoader.js";
const job = await (await fetch("/job")).json();
const canvas = document.createElement("canvas");
const renderer = new THREE.WebGLRenderer({ canvas, antialias: false, preserveDrawingBuffer: true });
renderer.setSize(job.width, job.height, false);
const loader = new GLTFLoader();
loader.setDRACOLoader(new DRACOLoader().setDecoderPath("/modules/three/examples/jsm/libs/draco/gltf/"));
const gltf = await loader.loadAsync("/glb");
const scene = gltf.scene;
scene.updateMatrixWorld(true);
const camera = gltf.cameras.find((c) => c.name === job.camera) ?? gltf.cameras[0];
camera.aspect = job.width / job.height;
camera.updateProjectionMatrix();
const meshes = [];
scene.traverse((node) => { if (node.isMesh) meshes.push(node); });
const original = new Map(meshes.map((mesh) => [mesh, mesh.material]));
const kinds = {
  lit: () => {
    renderer.toneMapping = THREE.LinearToneMapping;
    renderer.toneMappingExposure = job.exposure;
    meshes.forEach((mesh) => { mesh.material = original.get(mesh); });
  },
  base_color: () => {
    renderer.toneMapping = THREE.NoToneMapping;
    meshes.forEach((mesh) => {
      const { map, color, side } = original.get(mesh);
      // Single texels, as in ground truth.
      if (map) Object.assign(map, { minFilter: THREE.LinearFilter, needsUpdate: true });
      mesh.material = new THREE.MeshBasicMaterial({ map, color, side });
    });
  },
  ids: () => {
    renderer.toneMapping = THREE.NoToneMapping;
    meshes.forEach((mesh, i) => {
      const color = new THREE.Color().setRGB(((i + 1) >> 8) / 255, ((i + 1) & 255) / 255, 0,
        THREE.SRGBColorSpace);
      mesh.material = new THREE.MeshBasicMaterial({ color, side: original.get(mesh).side });
    });
  },
};
const pictures = {};
for (const kind of Object.keys(job.pictures)) {
  kinds[kind]();
  renderer.render(scene, camera);
  pictures[kind] = canvas.toDataURL("image/png");
}
const prim = (node) => node.userData.prim ?? (node.parent ? prim(node.parent) : "");
const centre = (mesh) => new THREE.Box3().setFromObject(mesh).getCenter(new THREE.Vector3());
window.found = {
  pictures,
  revision: THREE.REVISION,
  meshes: meshes.map((mesh) => ({
    prim: prim(mesh), centre: centre(mesh).toArray(),
    pixel: centre(mesh).project(camera).toArray(),
  })),
  lights: scene.getObjectsByProperty("isLight", true).map((light) => ({
    type: light.type, intensity: light.intensity })),
  cameras: gltf.cameras.map((c) => ({ name: c.name, fov: c.fov })),
};
</script>`;

const types = { ".js": "text/javascript", ".wasm": "application/wasm" };
const server = http.createServer((request, response) => {
  const url = decodeURIComponent(request.url.split("?")[0]);
  if (url === "/") return response.setHeader("Content-Type", "text/html").end(page_html);
  if (url === "/job") return response.end(JSON.stringify(job));
  if (url === "/glb") return response.end(fs.readFileSync(job.glb));
  if (!url.startsWith("/modules/")) return response.writeHead(404).end();
  const file = path.join(job.modules, url.slice("/modules/".length));
  response.setHeader("Content-Type", types[path.extname(file)] ?? "application/octet-stream");
  return response.end(fs.readFileSync(file));
});
await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const browser = await puppeteer.launch({
  executablePath: job.chromium,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
});
try {
  const page = await browser.newPage();
  const errors = [];
  const failed = new Promise((_, reject) => page.on("pageerror", reject));
  page.on("console", (message) => errors.push(`${message.type()}: ${message.text()}`));
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  await Promise.race([failed, page.waitForFunction("window.found", { timeout: 120000 })]);
  const found = await page.evaluate("window.found");
  for (const [kind, file] of Object.entries(job.pictures)) {
    fs.writeFileSync(file, Buffer.from(found.pictures[kind].split(",")[1], "base64"));
  }
  delete found.pictures;
  fs.writeFileSync(job.report, JSON.stringify({ ...found, console: errors }));
} finally {
  await browser.close();
  server.close();
}
