// SPDX-License-Identifier: GPL-3.0-or-later
// node read_usd.mjs FOLDER FILE.usda: what tinyusdz, of npm in FOLDER, has read: its own text of the stage, and the
// mesh that it would draw. It is built for browsers, so Node stands in for one.
import fs from "fs";
import path from "path";

const [folder, file] = process.argv.slice(2);
const library = path.resolve(folder, "node_modules/tinyusdz");
process.type = "renderer";
globalThis.window = {};
const { default: load } = await import(`${library}/tinyusdz.js`);
const usd = await load({ wasmBinary: fs.readFileSync(`${library}/tinyusdz.wasm`) });
const data = fs.readFileSync(file);
const layer = new usd.TinyUSDZLoaderNative();
if (!layer.loadAsLayerFromBinary(data, file)) throw new Error(layer.error());
const text = layer.layerToString();
const scene = new usd.TinyUSDZLoaderNative();
if (!scene.loadFromBinary(data, file)) throw new Error(scene.error());
const meshes = scene.numMeshes();
const mesh = scene.getMesh(0);
const points = Array.from(mesh.points); // before the memory that it looks into moves
console.log(JSON.stringify({ text, meshes, path: mesh.absPath, points }));
