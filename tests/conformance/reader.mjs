// A reader of packs, written from docs/pack-format.md alone. No dependencies; Node 20.15 or later. Free to copy.
//
//   const pack = readPack("anna.facezip");
//   pack.expressions, pack.maps, pack.tiles
//   const { rows, columns, channels, values } = pack.blend({ smile: 0.5, blink: 1 }, "albedo", 1001);
//   const { neutral, triangles, uv, uvTriangles } = pack.meshes;
import { lstatSync, readFileSync, readdirSync } from "node:fs";
import { basename, join, resolve } from "node:path";
import { readActivations } from "./activations.mjs";
import { readMeshes } from "./glb.mjs";
import { imagesOf, parseManifest, sha256, weightFiles } from "./manifest.mjs";
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
  const { expressions, maps, tiles, masks, geometry } = manifest;
  const texels = Object.create(null);
  for (const { file, size, channels, bits } of imagesOf(manifest))
    texels[file] = { channels, top: 2 ** bits - 1, samples: decodePng(contents[file], size, channels, bits, file) };
  const activations = masks && readActivations(contents[masks.activations], masks);
  return {
    name: manifest.name || basename(resolve(folder)).replace(/(?<=.)\.[^.]*$/, ""),
    expressions,
    maps,
    tiles: tiles.map((tile) => tile.number),
    meshes: geometry && readMeshes(contents["head.glb"], expressions, geometry),
    blend: (blend, map, tile) => blendOf({ ...manifest, activations }, texels, blend, map, tile),
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
function weightsOf(manifest, texels, tile, betas, slot) {
  const [rows, columns] = tile.weight_size;
  if (manifest.uniform_weights.length > 0) {
    const sum = betas.reduce((total, [n, beta]) => total + beta * manifest.uniform_weights[n][slot], 0);
    return () => sum;
  }
  const parts = manifest.masks ? maskParts(manifest, tile, betas, slot) : mapParts(tile, betas, slot);
  const files = weightFiles(manifest, tile);
  const value = ({ image, place, channel, factor, low }, y, x) => {
    const row = Math.floor(place / tile.weight_columns) * rows + y;
    const column = (place % tile.weight_columns) * columns + x;
    const { channels, samples, top } = texels[files[image]];
    return low + (factor * samples[(row * columns * tile.weight_columns + column) * channels + channel]) / top;
  };
  const map = Float64Array.from({ length: rows * columns }, (_, at) =>
    parts.reduce((sum, part) => sum + value(part, Math.floor(at / columns), at % columns), 0),
  );
  return (v, u) => bilinear(map, rows, columns, v * rows - 0.5, u * columns - 0.5);
}

/** Where the weight map of each expression stands, and what its samples count: β_n W_in. */
function mapParts({ weight_span, weight_offset }, betas, slot) {
  const [image, channel] = [Math.floor(slot / 4), slot % 4];
  const [span, offset] = [weight_span[slot], weight_offset[slot]];
  return betas.map(([place, beta]) => ({ image, place, channel, factor: beta * span, low: beta * offset }));
}

/** Where each mask stands, and what its samples count: Σ_n β_n a_nki. */
function maskParts({ masks, activations }, tile, betas, slot) {
  const slots = tile.weight_span.length;
  return masks.names.map((_, k) => {
    const at = (n) => activations[(n * masks.names.length + k) * slots + slot];
    const factor = betas.reduce((sum, [n, beta]) => sum + beta * at(n), 0);
    return { image: 0, place: Math.floor(k / 4), channel: k % 4, factor, low: 0 };
  });
}

function bilinear(map, rows, columns, y, x) {
  const clamp = (at, most) => Math.min(Math.max(at, 0), most);
  const at = (row, column) => map[clamp(row, rows - 1) * columns + clamp(column, columns - 1)];
  const [top, left] = [Math.floor(y), Math.floor(x)];
  const across = (row) => at(row, left) + (at(row, left + 1) - at(row, left)) * (x - left);
  return across(top) + (across(top + 1) - across(top)) * (y - top);
}
