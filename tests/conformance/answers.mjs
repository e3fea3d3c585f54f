// What the reader of this folder says of packs: node answers.mjs VECTOR… prints a JSON list. Each VECTOR is a folder of
// a pack and an expected.json, whose blends are asked for. Arrays are base64 of little-endian float32 or uint32.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { readPack, Refusal } from "./reader.mjs";

const base64 = (array) => Buffer.from(array.buffer).toString("base64");

function answer(vector) {
  const expected = JSON.parse(readFileSync(join(vector, "expected.json"), "utf8"));
  try {
    const { blend, meshes, ...pack } = readPack(join(vector, "vector.facezip"));
    return {
      code: null,
      ...pack,
      blends: (expected.blends ?? []).map((asked) => blended(blend, asked)),
      meshes: meshes && meshed(meshes),
    };
  } catch (error) {
    if (!(error instanceof Refusal)) throw error;
    return { code: error.code, reason: error.message };
  }
}

function blended(blend, asked) {
  const { rows, columns, channels, values } = blend(asked.blend, asked.map, asked.tile);
  return { size: [rows, columns, channels], values: base64(values) };
}

function meshed({ neutral, expressions, uv, triangles, uvTriangles }) {
  return {
    neutral: base64(neutral),
    expressions: expressions.map(base64),
    uv: base64(uv),
    triangles: base64(triangles),
    uvTriangles: base64(uvTriangles),
  };
}

console.log(JSON.stringify(process.argv.slice(2).map(answer)));
