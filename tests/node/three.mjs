// What three.js makes of a GLB: its morph targets, by name, and what they move. Images are not decoded here.
import { readFileSync } from "node:fs";

globalThis.self = globalThis;
globalThis.createImageBitmap = async () => ({ width: 1, height: 1, close() {} });
console.warn = console.error = () => {};
const { GLTFLoader } = await import("three/examples/jsm/loaders/GLTFLoader.js");

const content = readFileSync(process.argv[2]);
const { scene } = await new GLTFLoader().parseAsync(content.buffer.slice(content.byteOffset, content.byteOffset + content.length), "");
let face;
scene.traverse((object) => { if (object.isMesh) face = object; });
const { position, normal } = face.geometry.morphAttributes;
// Attributes may lie interleaved.
const numbers = (attribute) =>
  Array.from({ length: attribute.count * attribute.itemSize }, (_, at) =>
    attribute.getComponent(Math.floor(at / attribute.itemSize), at % attribute.itemSize));
console.log(JSON.stringify({
  names: Object.keys(face.morphTargetDictionary),
  relative: face.geometry.morphTargetsRelative,
  scale: face.scale.toArray(),
  position: numbers(face.geometry.attributes.position),
  deltas: position.map(numbers),
  normals: normal?.length ?? 0,
  index: Array.from(face.geometry.index.array),
  uv: numbers(face.geometry.attributes.uv),
  textured: face.material.map !== null,
}));
