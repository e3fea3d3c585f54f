// head.glb: the neutral mesh and its morph targets, as the section of that name in docs/pack-format.md has them.
import { need, Refusal } from "./refusal.mjs";

const ARRAYS = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const WIDTHS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

/**
 * The meshes of a head.glb. `neutral` and `expression(n)` are (vertices × 3); `triangles` index them. `uv` (v up) has a
 * row for every corner that differs, and `uvTriangles` index it.
 */
export function readMeshes(bytes, expressions, geometry) {
  try {
    return meshesOf(openGlb(bytes), expressions, geometry);
  } catch (error) {
    // Whatever the JSON refers to that is not there.
    throw error instanceof Refusal ? error : new Refusal("bad-pack", `head.glb: ${error.message}`);
  }
}

function openGlb(bytes) {
  const jsonEnd = 20 + bytes.readUInt32LE(12);
  const words = [0, 4, 8, 16, jsonEnd, jsonEnd + 4].map((at) => bytes.readUInt32LE(at));
  const expected = [0x46546c67, 2, bytes.length, 0x4e4f534a, bytes.length - jsonEnd - 8, 0x004e4942];
  need(words.join() === expected.join(), "head.glb is no binary glTF 2.0 of two chunks");
  return { document: JSON.parse(bytes.toString("utf8", 20, jsonEnd)), binary: bytes.subarray(jsonEnd + 8) };
}

function meshesOf({ document, binary }, expressions, { vertices, triangles }) {
  const { meshes: [mesh], nodes } = document;
  const [{ attributes, targets, indices, mode = 4 }] = mesh.primitives;
  need(document.meshes.length === 1 && mesh.primitives.length === 1 && mode === 4, "head.glb has other meshes");
  need(targets.length === expressions.length && mesh.extras.targetNames.join("/") === expressions.join("/"), "head.glb has other expressions");
  const step = nodes.find((node) => node.mesh === 0).scale[0];
  need(nodes.find((node) => node.mesh === 0).scale.every((s) => s === step) && Number.isInteger(Math.log2(step)), "head.glb: the scale is no power of two");

  const accessor = (index, type, count) => readAccessor(document, binary, index, type, count);
  const position = accessor(attributes.POSITION, "VEC3");
  const corners = position.count;
  const moves = targets.map((target) => accessor(target.POSITION, "VEC3", corners));
  const texture = accessor(attributes.TEXCOORD_0, "VEC2", corners).dense();
  const optional = (name) => (name in attributes ? accessor(attributes[name], "SCALAR", corners).dense() : new Float32Array(corners));
  const [seam, vUp, faces] = [optional("_SEAM"), optional("_V_UP"), accessor(indices, "SCALAR").dense()];

  const firsts = Array.from(seam.keys()).filter((corner) => seam[corner] === 0); // the corners that repeat none
  let vertex = -1;
  const vertexOf = Array.from(seam, (repeats) => (vertex += repeats === 0 ? 1 : 0));
  need(vertexOf[0] === 0 && firsts.length === vertices && faces.length === 3 * triangles, "head.glb has another number of vertices or triangles");
  need(faces.every((corner) => corner < corners), "head.glb: a triangle has no such vertex");

  const home = position.dense();
  need([home, texture, vUp, ...moves.map((move) => move.values)].every((all) => all.every(Number.isFinite)), "head.glb has values that are not finite");
  const scaled = (at) => Float32Array.from(firsts.flatMap((corner) => [0, 1, 2].map((axis) => step * at(3 * corner + axis))));
  return {
    neutral: scaled((at) => home[at]),
    expression(n) {
      const moved = moves[n].dense();
      return scaled((at) => home[at] + moved[at]);
    },
    uv: Float32Array.from({ length: 2 * corners }, (_, at) => (at % 2 === 0 ? texture[at] : vUp[(at - 1) / 2] || 1 - texture[at])),
    triangles: Uint32Array.from(faces, (corner) => vertexOf[corner]),
    uvTriangles: Uint32Array.from(faces),
  };
}

/** An accessor, dense or sparse, whose numbers all lie in the file; it takes up room only when `dense()` asks. */
function readAccessor({ accessors, bufferViews }, binary, index, type, expected) {
  const { bufferView, byteOffset = 0, componentType, count, type: stated, sparse } = accessors[index];
  need(stated === type && count === (expected ?? count), "head.glb has an accessor of another type or length");
  const width = WIDTHS[type];
  const view = (at, offset, kind, rows, columns) => {
    const { byteOffset: start = 0, byteLength, byteStride } = bufferViews[at];
    const Kind = ARRAYS[kind];
    const stride = byteStride ?? Kind.BYTES_PER_ELEMENT * columns;
    need(offset >= 0 && offset + (rows - 1) * stride + Kind.BYTES_PER_ELEMENT * columns <= byteLength, "head.glb has an accessor outside its view");
    need(start >= 0 && start + byteLength <= binary.length, "head.glb has a view outside its bytes");
    const numbers = new Kind(rows * columns);
    const bytes = new Uint8Array(numbers.buffer);
    const size = Kind.BYTES_PER_ELEMENT * columns;
    for (let row = 0; row < rows; row++) bytes.set(binary.subarray(start + offset + row * stride).subarray(0, size), row * size);
    return numbers;
  };
  const base = bufferView === undefined ? null : view(bufferView, byteOffset, componentType, count, width);
  need(base || expected !== undefined, "head.glb has an accessor of nothing");
  const rows = sparse ? view(sparse.indices.bufferView, sparse.indices.byteOffset ?? 0, sparse.indices.componentType, sparse.count, 1) : [];
  const values = sparse ? view(sparse.values.bufferView, sparse.values.byteOffset ?? 0, componentType, sparse.count, width) : [];
  need(rows.every((row, n) => row < count && (n === 0 || row > rows[n - 1])), "head.glb has sparse values out of order");
  return {
    count,
    values: base ?? values,
    dense() {
      const all = base ? Float64Array.from(base) : new Float64Array(count * width);
      rows.forEach((row, n) => all.set(values.subarray(n * width, (n + 1) * width), row * width));
      return all;
    },
  };
}
