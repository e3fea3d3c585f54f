// A reader of packs, written from docs/pack-format.md alone. No dependencies; Node 20.15 or later. Free to copy.
//
//   const pack = readPack("anna.facezip");
//   pack.expressions, pack.maps, pack.tiles
//   const { rows, columns, channels, values } = pack.blend({ smile: 0.5, blink: 1 }, "albedo", 1001);
//   const { neutral, triangles, uv, uvTriangles } = pack.meshes;
import { lstatSync, readFileSync, readdirSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { readMeshes } from "./glb.mjs";
import { imagesOf, parseManifest, sha256 } from "./manifest.mjs";
import { decodePng } from "./png.mjs";
import { need, Refusal } from "./refusal.mjs";

export { Refusal };
const MANIFEST = "manifest.json";
const MOST_BYTES = 2 * 2 ** 20;

/** A pack, checked in the order of "What a reader must refuse"; throws a `Refusal` with the `code` of that section. */
export function readPack(folder) {
  const manifest = parseManifest(readManifest(folder)); // 1 and 2
  checkListing(folder, manifest.files); // 3
  const contents = readFiles(folder, manifest.files); // 4
  return decode(manifest, contents, folder); // 5
}

function readManifest(folder) {
  const found = lstatSync(join(folder, MANIFEST), { throwIfNoEntry: false });
  need(found, "there is no manifest");
  need(found.isFile() && found.size <= MOST_BYTES, "the manifest is no plain file of at most 2 MiB");
  return readFileSync(join(folder, MANIFEST));
}

function checkListing(folder, files) {
  const there = readdirSync(folder).filter((name) => name !== MANIFEST);
  for (const name of there) need(Object.hasOwn(files, name), `${name} was added`, "damaged-pack");
  for (const [name, { bytes }] of Object.entries(files)) {
    need(there.includes(name), `${name} is missing`, "damaged-pack"); // before it is opened: it may be a path
    const found = lstatSync(join(folder, name));
    need(found.isFile() && found.size === bytes, `${name} is no plain file of the length stated`, "damaged-pack");
  }
}

function readFiles(folder, files) {
  const contents = Object.create(null);
  for (const [name, { sha256: digits }] of Object.entries(files)) {
    contents[name] = readFileSync(join(folder, name));
    need(sha256(contents[name]) === digits, `${name} has another checksum`, "damaged-pack");
  }
  return contents;
}

function decode(manifest, contents, folder) {
  const { expressions, maps, tiles, geometry } = manifest;
  const texels = Object.create(null);
  for (const { file, size, channels, bits } of tiles.flatMap((tile) => imagesOf(tile, maps, expressions.length)))
    texels[file] = { channels, top: 2 ** bits - 1, samples: decodePng(contents[file], size, channels, bits, file) };
  return {
    name: manifest.name || basename(resolve(folder)).replace(/(?<=.)\.[^.]*$/, ""),
    expressions,
    maps,
    tiles: tiles.map((tile) => tile.number),
    meshes: geometry && readMeshes(contents["head.glb"], expressions, geometry),
    blend: (blend, map, tile) => blendOf(manifest, texels, blend, map, tile),
  };
}

/** "From bytes to values": I(β) in the values that are stored, for normals n: rows × columns × channels in a Float32Array. */
function blendOf(manifest, texels, blend, mapName, number) {
  const { expressions, maps, tiles } = manifest;
  const m = maps.findIndex((each) => each.name === mapName);
  const tile = tiles.find((each) => each.number === number);
  const betas = Object.entries(blend).map(([name, beta]) => [expressions.indexOf(name), beta]);
  if (m < 0 || !tile || betas.some(([n]) => n < 0)) throw new RangeError("no such map, tile or expression");
  const {
    size: [rows, columns],
    neutral,
    differences,
    difference_span,
  } = tile.textures[m];
  const {
    encoding,
    range: [low, high],
    channels,
  } = maps[m];
  const slotWeights = tile.weight_span.map((_, slot) => weightsOf(manifest, texels, tile, betas, slot));
  const start = texels[neutral];
  const values = new Float32Array(rows * columns * (encoding === "normal" ? 3 : channels));
  for (let texel = 0; texel < rows * columns; texel++) {
    const weights = slotWeights.map((at) =>
      at((Math.floor(texel / columns) + 0.5) / rows, ((texel % columns) + 0.5) / columns),
    );
    const value = (c) => low + (start.samples[texel * start.channels + c] / start.top) * (high - low);
    const change = (c) => {
      const difference = (file, slot) =>
        (texels[file].samples[texel * start.channels + c] / 255 - 128 / 255) * difference_span[slot][c];
      return differences.reduce((sum, file, slot) => sum + difference(file, slot) * weights[slot], 0);
    };
    if (encoding === "normal") {
      values.set(normal(value(0), value(1), change(0), change(1)), 3 * texel);
    } else {
      for (let c = 0; c < channels; c++)
        values[texel * channels + c] = Math.min(Math.max(value(c) + change(c), low), high);
    }
  }
  return { rows, columns, channels: values.length / (rows * columns), values };
}

/** Slopes are blended, not directions; those of the neutral and of the blend are at most 10. */
function normal(x, y, changeP, changeQ) {
  const z = Math.max(Math.sqrt(Math.max(1 - x * x - y * y, 0)), 0.001);
  const clip = (slope) => Math.min(Math.max(slope, -10), 10);
  const [p, q] = [clip(clip(x / z) + changeP), clip(clip(y / z) + changeQ)];
  const length = Math.hypot(p, q, 1);
  return [p / length, q / length, 1 / length];
}

/** Σ_n β_n W_in of one slot, as a function of where in the tile: rows and columns from 0 to 1. */
function weightsOf({ expressions, uniform_weights }, texels, tile, betas, slot) {
  const {
    weight_size: [rows, columns],
    weight_columns,
    weight_span,
    weight_offset,
    weights,
  } = tile;
  if (weights.length === 0) {
    const sum = betas.reduce((total, [n, beta]) => total + beta * uniform_weights[n][slot], 0);
    return () => sum;
  }
  const { channels, samples, top } = texels[weights[Math.floor(slot / 4)]];
  const stored = (n, y, x) => {
    const row = Math.floor(n / weight_columns) * rows + y;
    const column = (n % weight_columns) * columns + x;
    return samples[(row * columns * weight_columns + column) * channels + (slot % 4)] / top;
  };
  const weight = (n, y, x) => stored(n, y, x) * weight_span[slot] + weight_offset[slot];
  const map = Float64Array.from({ length: rows * columns }, (_, at) =>
    betas.reduce((sum, [n, beta]) => sum + beta * weight(n, Math.floor(at / columns), at % columns), 0),
  );
  return (v, u) => bilinear(map, rows, columns, v * rows - 0.5, u * columns - 0.5);
}

function bilinear(map, rows, columns, y, x) {
  const clamp = (at, most) => Math.min(Math.max(at, 0), most);
  const at = (row, column) => map[clamp(row, rows - 1) * columns + clamp(column, columns - 1)];
  const [top, left] = [Math.floor(y), Math.floor(x)];
  const across = (row) => at(row, left) + (at(row, left + 1) - at(row, left)) * (x - left);
  return across(top) + (across(top + 1) - across(top)) * (y - top);
}
