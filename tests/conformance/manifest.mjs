// The manifest: "Fields and their ranges" of docs/pack-format.md, one check a row.
import { createHash } from "node:crypto";
import { need } from "./refusal.mjs";

export const FORMAT = "facezip-pack/3";
const START = /^\{\n "sha256": "([0-9a-f]{64})",\n "format": "facezip-pack\//; // "Fields": byte for byte
const PRINTABLE = /^(?:[^\p{C}\p{Z}]| )*$/u;
const DEVICE = /^(?:con|prn|aux|nul|com[0-9]|lpt[0-9]) *(?:\.|$)/iu;

export const sha256 = (bytes) => createHash("sha256").update(bytes).digest("hex");

/** The manifest of these bytes, once its own checksum and each of its fields are checked. */
export function parseManifest(bytes) {
  const digits = START.exec(bytes.toString("latin1", 0, 256))?.[1];
  need(digits, "the manifest does not begin with its checksum and format", "damaged-pack");
  const blank = Buffer.from(bytes);
  blank.fill("0", bytes.indexOf(digits), bytes.indexOf(digits) + 64);
  need(sha256(blank) === digits, "the manifest has another checksum", "damaged-pack");
  const manifest = strictJson(bytes);
  need(manifest.format === FORMAT, `the format is ${manifest.format}`, "other-format");
  checkFields(manifest);
  checkTogether(manifest);
  return manifest;
}

/** JSON of finite numbers in which no key stands twice: where one does, fewer keys come out than went in. */
function strictJson(bytes) {
  try {
    const text = new TextDecoder("utf-8", { fatal: true, ignoreBOM: true }).decode(bytes);
    const value = JSON.parse(text);
    const written = [...text.matchAll(/"(?:[^"\\]|\\.)*"(\s*:)?/gs)].filter((found) => found[1]).length;
    need(keysIn(value) === written, "the manifest has a key twice");
    return value;
  } catch (error) {
    need(false, `the manifest is not as JSON should be: ${error.message}`);
  }
}

function keysIn(value) {
  need(typeof value !== "number" || Number.isFinite(value), "a number is not finite");
  need(typeof value !== "string" || value.isWellFormed(), "half of a surrogate pair");
  if (value === null || typeof value !== "object") return 0;
  return Object.values(value).reduce(
    (sum, each) => sum + keysIn(each),
    Array.isArray(value) ? 0 : Object.keys(value).length,
  );
}

const isObject = (x) => typeof x === "object" && x !== null && !Array.isArray(x);
const isString = (x) => typeof x === "string";
const isText = (low, high) => (x) => isString(x) && PRINTABLE.test(x) && [...x].length >= low && [...x].length <= high;
const isNumber = (low, high) => (x) => typeof x === "number" && x >= low && x <= high;
const isWhole = (low, high) => (x) => Number.isInteger(x) && x >= low && x <= high;
const isOneOf =
  (...words) =>
  (x) =>
    words.includes(x);
const isList = (low, high, each) => (x) => Array.isArray(x) && x.length >= low && x.length <= high && x.every(each);
const isPair = (each) => isList(2, 2, each);
const isRecord = (fields) => (x) => {
  need(isObject(x) && Object.keys(x).length === Object.keys(fields).length, `fields other than ${Object.keys(fields)}`);
  for (const [name, check] of Object.entries(fields))
    need(Object.hasOwn(x, name) && check(x[name]), `${name} is out of its range`);
  return true;
};

function isSafe(name) {
  return (
    isText(1, 128)(name) &&
    Buffer.byteLength(name) <= 200 &&
    !/[/\\:]|^[ .]|[ .]$/.test(name) &&
    !/^(?:neutral|mask)$/iu.test(name) &&
    !DEVICE.test(name)
  );
}

const isMap = isRecord({
  name: (x) => isString(x) && /^[a-z][a-z0-9_]{0,31}$/.test(x) && x !== "weights" && x !== "mask",
  encoding: isOneOf("srgb", "data", "normal"),
  range: (x) => isPair(isNumber(-1e6, 1e6))(x) && x[0] < x[1],
  channels: isWhole(1, 4),
});
const isTexture = isRecord({
  size: isPair(isWhole(1, 16384)),
  neutral: isString,
  differences: isList(1, 8, isString),
  neutral_bits: isOneOf(8, 16),
  difference_span: isList(1, 8, isList(1, 4, isNumber(0, 1e9))),
});
const isTile = isRecord({
  number: isWhole(1001, 1999),
  weight_size: isPair(isWhole(1, 16384)),
  weight_columns: isWhole(1, 4096),
  weight_span: isList(1, 8, isNumber(0, 1e9)),
  weight_offset: isList(1, 8, isNumber(-1e9, 1e9)),
  weights: isList(0, 2, isString),
  textures: isList(1, 16, isTexture),
});
const isFile = isRecord({ bytes: isWhole(1, 2 ** 40), sha256: (x) => isString(x) && /^[0-9a-f]{64}$/.test(x) });
const isGeometry = isRecord({
  files: isList(1, 1, isOneOf("head.glb")),
  vertices: isWhole(1, 2 ** 24),
  triangles: isWhole(1, 2 ** 24),
});

const isMasks = isRecord({
  names: isList(1, 4096, isSafe),
  files: isList(1, 100, isString),
  activations: isString,
  clamped: isOneOf(true, false),
});

/** Each field alone. */
function checkFields(manifest) {
  isRecord({
    ...("masks" in manifest ? { masks: isMasks } : {}),
    sha256: () => true,
    format: () => true,
    name: isText(0, 128),
    method: isText(1, 128),
    expressions: isList(1, 4096, isSafe),
    maps: isList(1, 16, isMap),
    tiles: isList(1, 100, isTile),
    uniform_weights: isList(0, 4096, isList(1, 8, isNumber(-1e9, 1e9))),
    geometry: (x) => x === null || isGeometry(x),
    made_with: isObject,
    files: (x) => isObject(x) && Object.values(x).every(isFile),
  })(manifest);
}

/** What fields say of each other. */
function checkTogether(manifest) {
  const { expressions, maps, tiles, uniform_weights, masks, geometry, files } = manifest;
  need(areDifferent(expressions.map(folded)), "two expressions have one name");
  need(areDifferent(maps.map((map) => map.name)), "two maps have one name");
  for (const { encoding, range, channels } of maps)
    need(
      encoding !== "normal" || (range.join() === "-1,1" && channels === 2),
      "normals have another range or other channels",
    );
  need(
    tiles.every((tile, n) => n === 0 || tile.number > tiles[n - 1].number),
    "the tiles do not ascend",
  );
  const uniform = tiles[0].weight_size.join() === "1,1";
  need(
    tiles.every((tile) => (tile.weight_size.join() === "1,1") === uniform),
    "some weights are uniform, others not",
  );
  const slots = tiles[0].weight_span.length;
  const images = uniform || masks ? 0 : Math.ceil(slots / 4);
  for (const tile of tiles) checkTile(tile, maps, countOf(manifest), slots, images);
  const rows = uniform ? expressions.length : 0;
  need(
    uniform_weights.length === rows && uniform_weights.every((row) => row.length === slots),
    "uniform weights of another size",
  );
  const ofMasks = masks ? [...masks.files, masks.activations] : [];
  const named = [...tiles.flatMap(filesOf), ...ofMasks, ...(geometry?.files ?? [])];
  need(areDifferent(named) && named.length === Object.keys(files).length, "files that nothing names, or that two name");
  need(
    named.every((name) => name !== "manifest.json" && Object.hasOwn(files, name)),
    "names without a file",
  );
  if (masks) checkMasks(manifest, uniform, slots);
  for (const image of imagesOf(manifest)) {
    const unfolded = (image.size[0] * image.size[1] * image.channels * image.bits) / 8;
    need(unfolded <= 2 ** 28 || unfolded <= 200 * files[image.file].bytes, `${image.file} unfolds to too much`);
  }
}

function checkTile(tile, maps, count, slots, images) {
  const { weight_size, weight_columns, weight_span, weight_offset, weights, textures } = tile;
  need(weight_span.length === slots && weight_offset.length === slots, "tiles of different slots");
  need(textures.length === maps.length, "another number of textures than maps");
  need(
    weight_size.every((side, axis) => side <= textures[0].size[axis]),
    "weight maps larger than the first map's textures",
  );
  need(weight_columns <= count && atlasOf(tile, count).every((side) => side <= 65536), "weight images of another form");
  need(weights.length === images, "another number of weight images");
  textures.forEach(({ differences, difference_span }, m) => {
    const spans = difference_span.every((each) => each.length === maps[m].channels);
    need(
      differences.length === slots && difference_span.length === slots && spans,
      "differences of other slots or channels",
    );
  });
}

function checkMasks({ expressions, tiles, masks, files }, uniform, slots) {
  need(!uniform && masks.files.length === tiles.length, "masks of uniform weights, or of other tiles");
  need(areDifferent(masks.names.map(folded)), "two masks have one name");
  for (const { weight_span, weight_offset } of tiles)
    need(
      weight_span.every((span) => span === 1) && weight_offset.every((offset) => offset === 0),
      "masks have another range",
    );
  const numbers = expressions.length * masks.names.length * slots;
  need(files[masks.activations].bytes === 2 * numbers, "another number of activations");
}

// JavaScript has no case folding of Unicode; this is as good for names.
const folded = (name) => name.normalize("NFC").toUpperCase().toLowerCase().normalize("NFC");
const areDifferent = (names) => new Set(names).size === names.length;
const filesOf = ({ weights, textures }) => [
  ...weights,
  ...textures.flatMap((each) => [each.neutral, ...each.differences]),
];

/** Rows and columns of a weight image: the maps of all expressions, row by row ("From bytes to values"). */
export const atlasOf = ({ weight_size: [rows, columns], weight_columns }, count) => [
  rows * Math.ceil(count / weight_columns),
  columns * weight_columns,
];

/** How many weight maps stand in a weight image, or places of four masks in a mask image. */
export const countOf = ({ expressions, masks }) => (masks ? Math.ceil(masks.names.length / 4) : expressions.length);

/** The weight images of a tile, or its mask image. */
export const weightFiles = ({ tiles, masks }, tile) => (masks ? [masks.files[tiles.indexOf(tile)]] : tile.weights);

/** Every image, with what it must be. Images of normals have three channels, those of weights and masks four. */
export function imagesOf(manifest) {
  const { tiles, maps } = manifest;
  return tiles.flatMap((tile) => {
    const size = atlasOf(tile, countOf(manifest));
    const weights = weightFiles(manifest, tile).map((file) => ({ file, size, channels: 4, bits: 8 }));
    return [...weights, ...tile.textures.flatMap((texture, m) => texturesOf(texture, maps[m]))];
  });
}

function texturesOf({ size, neutral, differences, neutral_bits }, map) {
  const channels = map.encoding === "normal" ? 3 : map.channels;
  return [
    { file: neutral, size, channels, bits: neutral_bits },
    ...differences.map((file) => ({ file, size, channels, bits: 8 })),
  ];
}
