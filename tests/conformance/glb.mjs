// head.glb: the neutral mesh and its morph targets, as the section of that name in docs/pack-format.md has them.
import { need, Refusal } from "./refusal.mjs";

const BYTE = 5121;
const SHORT = 5122;
const FLOAT = 5126;
const ARRAYS = { [BYTE]: Uint8Array, [SHORT]: Int16Array, 5123: Uint16Array, 5125: Uint32Array, [FLOAT]: Float32Array };
const WIDTHS = { SCALAR: 1, VEC2: 2, VEC3: 3 };
const FURTHEST = 1e30;

/**
 * The meshes of a head.glb. `neutral` and each of `expressions` are (vertices × 3); `triangles` index them. `uv` (v up)
 * has a row for every corner that differs, and `uvTriangles` index it.
 */
export function readMeshes(bytes, expressions, geometry) {
  try {
    return meshesOf(openGlb(bytes), bytes.length, expressions, geometry);
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

function meshesOf({ document, binary }, length, expressions, geometry) {
  const { attributes, targets, indices } = onlyPrimitive(document, expressions);
  const step = stepOf(document);
  const corners = document.accessors[attributes.POSITION].count;
  need(12 * corners * (targets.length + 1) <= Math.max(2 ** 28, 200 * length), "head.glb unfolds to too much");
  const values = (index, type, ...kinds) => readAccessor(document, binary, index, type, corners, kinds);
  const optional = (name, kind) =>
    name in attributes ? values(attributes[name], "SCALAR", kind) : new Float64Array(corners);

  const [home, layout] = [values(attributes.POSITION, "VEC3", FLOAT), values(attributes.TEXCOORD_0, "VEC2", FLOAT)];
  const [seam, vUp] = [optional("_SEAM", BYTE), optional("_V_UP", FLOAT)];
  need(
    seam[0] === 0 && seam.every((repeats) => repeats <= 1),
    "head.glb: seams are marked by 0 and 1, the first vertex by 0",
  );
  const uv = Float32Array.from(
    { length: 2 * corners },
    (_, at) => (at % 2 && vUp[(at - 1) / 2]) || (at % 2 ? 1 - layout[at] : layout[at]),
  );
  need(
    uv.every((value) => Math.abs(value) < FURTHEST),
    "head.glb has texture coordinates that are no numbers",
  );
  const neutral = placesOf(home, null, seam, step);
  const moved = targets.map((target) => placesOf(home, values(target.POSITION, "VEC3", SHORT, FLOAT), seam, step));

  const faces = readAccessor(document, binary, indices, "SCALAR", 3 * geometry.triangles, [BYTE, 5123, 5125]);
  need(
    faces.every((corner) => corner < corners),
    "head.glb: a triangle has no such vertex",
  );
  let vertex = -1;
  const vertexOf = Array.from(seam, (repeats) => (vertex += 1 - repeats));
  need(vertex + 1 === geometry.vertices, "head.glb has another number of vertices");
  const triangles = Uint32Array.from(faces, (corner) => vertexOf[corner]);
  return { neutral, expressions: moved, uv, triangles, uvTriangles: Uint32Array.from(faces) };
}

function onlyPrimitive({ meshes, extensionsRequired }, expressions) {
  const [{ primitives, extras }] = meshes;
  const [{ mode = 4, targets }] = primitives;
  need(meshes.length === 1 && primitives.length === 1 && mode === 4, "head.glb has other meshes");
  need(extensionsRequired.join() === "KHR_mesh_quantization", "head.glb needs another extension");
  const names = extras.targetNames;
  need(
    names.length === expressions.length && expressions.every((name, n) => name === names[n]),
    "head.glb has other expressions",
  );
  need(
    targets.length === names.length && targets.every((target) => Object.keys(target).join() === "POSITION"),
    "head.glb has other targets",
  );
  return primitives[0];
}

function stepOf({ nodes }) {
  const [{ mesh, scale }] = nodes;
  const plain = nodes.length === 1 && mesh === 0 && Object.keys(nodes[0]).sort().join() === "mesh,name,scale";
  need(plain && scale.length === 3 && scale.every((each) => each === scale[0]), "head.glb has another transform");
  need(
    scale[0] >= 2 ** -126 && scale[0] <= 1 && Number.isInteger(Math.log2(scale[0])),
    "head.glb: its scale is no power of two",
  );
  return scale[0];
}

/** s · (POSITION + displacement) of the vertices; those that repeat one lie where it lies. */
function placesOf(home, moves, seam, step) {
  const places = Float32Array.from(home, (value, at) => step * (value + (moves ? moves[at] : 0)));
  need(
    places.every((value) => Math.abs(value) < FURTHEST),
    "head.glb has positions that are no numbers",
  );
  const torn = (value, at) => seam[Math.floor(at / 3)] === 1 && value !== places[at - 3];
  need(!places.some(torn), "head.glb: a vertex on a seam is torn apart");
  return places.filter((_, at) => seam[Math.floor(at / 3)] === 0);
}

/** The numbers of an accessor, sparse or not: of one of some kinds, as many as expected, none outside the file. */
function readAccessor({ accessors, bufferViews }, binary, index, type, expected, kinds) {
  const { bufferView, byteOffset, componentType, count, type: stated, sparse } = accessors[index];
  need(
    stated === type && count === expected && kinds.includes(componentType),
    "head.glb has an accessor of another kind",
  );
  const width = WIDTHS[type];
  const view = (...where) => readView(bufferViews, binary, ...where);
  const all =
    bufferView === undefined
      ? new Float64Array(count * width)
      : Float64Array.from(view(bufferView, byteOffset, componentType, count, width));
  if (sparse) {
    const rows = view(
      sparse.indices.bufferView,
      sparse.indices.byteOffset,
      sparse.indices.componentType,
      sparse.count,
      1,
    );
    const values = view(sparse.values.bufferView, sparse.values.byteOffset, componentType, sparse.count, width);
    need(
      rows.every((row, n) => row < count && (n === 0 || row > rows[n - 1])),
      "head.glb has sparse values out of order",
    );
    rows.forEach((row, n) => all.set(values.subarray(n * width, (n + 1) * width), row * width));
  }
  return all;
}

function readView(views, binary, index, offset = 0, kind, count, width) {
  const { byteOffset: start = 0, byteLength, byteStride } = views[index];
  const size = ARRAYS[kind].BYTES_PER_ELEMENT * width;
  const stride = byteStride ?? size;
  const whole = [start, byteLength, offset, count, stride - size].every(
    (number) => Number.isInteger(number) && number >= 0,
  );
  need(
    whole && offset + (count - 1) * stride + size <= byteLength && start + byteLength <= binary.length,
    "head.glb has an accessor outside its bytes",
  );
  const bytes = new Uint8Array(count * size);
  for (let row = 0; row < count; row++)
    bytes.set(binary.subarray(start + offset + row * stride).subarray(0, size), row * size);
  return new ARRAYS[kind](bytes.buffer);
}
