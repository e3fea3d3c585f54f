// What `facezip export --to three` wrote: facezip.json as the document of a head, and its files as that head's images and arrays.

import { asked, bitmapOf } from "../head/assets";
import { type Assets, type HeadDocument, layersOf, type TextureEntry, type TileEntry } from "../head/document";
import type { ExportDocument, ExportedMap, ExportedMasks, ExportedTexture, TileExport, TilesDocument } from "../published";
import { readPng, type Texels } from "./png";

export interface Exported {
  document: HeadDocument;
  assets: Assets;
  /** Of each tile what its material is called in head.glb. */
  materials: string[];
}

/** `base` is the address of the folder, with a slash at its end. */
export async function readExported(base: string): Promise<Exported> {
  const whole: ExportDocument | TilesDocument = await (await asked(new URL("facezip.json", base))).json();
  if (whole.target !== "three") throw new Error(`${base}facezip.json is of an export to ${whole.target}; export it with --to three`);
  const tiles: Record<string, TileExport> = "tiles" in whole ? whole.tiles : { "": whole };
  const places = Object.keys(tiles).map((number) => (number ? `${base}${number}/` : base));
  const parts = Object.values(tiles);
  return {
    document: documentOf(parts), assets: assetsOf(parts, places),
    materials: Object.keys(tiles).map((number) => (number ? `neutral_${number}` : "neutral")),
  };
}

function documentOf(tiles: TileExport[]): HeadDocument {
  const [{ order, gains, maps, textures, uniform_weights, masks }] = tiles;
  const first = maps[gains.maps[0]];
  return {
    expressions: order,
    maps: gains.maps.map((name) => ({ name, encoding: maps[name].encoding, range: maps[name].range, ...channelsOf(maps[name]) })),
    tiles: tiles.map((tile) => tileOf(tile)),
    slots: first.differences.length,
    difference_zero: textures[first.differences[0]].zero!,
    max_slope: Math.max(...Object.values(maps).map(({ max_slope }) => max_slope ?? 0)),
    uniform: uniform_weights.length > 0,
    regions: gains.regions,
    ...(masks && { fours: foursOf(masks, first.differences.length) }),
    mesh: {},
  };
}

const foursOf = ({ vectors }: ExportedMasks, slots: number) => vectors / layersOf(slots) / 4;

// Two channels come in images of three.
const channelsOf = ({ channels: { length } }: ExportedMap) => ({ channels: length, image_channels: length === 2 ? 3 : length });

function tileOf({ weight_size, uniform_weights, masks, gains, maps, textures }: TileExport): TileEntry {
  const slots = maps[gains.maps[0]].differences.length;
  const layers = Array.from({ length: layersOf(slots) }, (_, layer) => textures[`weights_${layer}`]);
  // Uniform weights are written as they are, and masks make them so.
  const plain = uniform_weights.length > 0 || masks !== undefined;
  return {
    place: [0, 0], weight_size,
    weight_span: plain ? new Array(slots).fill(1) : layers.flatMap(({ scale }) => scale!),
    weight_offset: plain ? new Array(slots).fill(0) : layers.flatMap(({ offset }) => offset!),
    textures: gains.maps.map((name) => textureOf(maps[name], textures)),
  };
}

function textureOf({ encoding, range: [low, high], size, neutral, differences }: ExportedMap, textures: Record<string, ExportedTexture>): TextureEntry {
  // Of texels, which the shader adds; normals' are of slopes.
  const unit = encoding === "normal" ? 1 : high - low;
  const spans = differences.map((name) => textures[name].scale!.map((scale) => scale / unit));
  return {
    size, neutral_bits: textures[neutral].low ? 16 : 8,
    difference_span: spans.map((span) => (span.length === 1 ? [span[0], span[0], span[0]] : [span[0], span[1], span[2] ?? 0])),
  };
}

function assetsOf(tiles: TileExport[], places: string[]): Assets {
  const png = async (t: number, file: string) => readPng(await (await asked(new URL(file, places[t]))).arrayBuffer());
  return {
    async array(name) {
      if (name === "activations") return Uint8Array.from(atob(tiles[0].masks!.activations), (byte) => byte.charCodeAt(0)).buffer;
      const [, t, kind] = /^tile_(\d+)\.(\w+)$/.exec(name)!;
      const { regions, masks, order, uniform_weights, weight_size, textures, maps, gains } = tiles[+t];
      if (kind === "regions") return stacked(await png(+t, regions!.file), regions!.columns, weight_size, gains.regions.length).buffer;
      if (kind === "masks") return stacked(await png(+t, masks!.file), masks!.columns, weight_size, foursOf(masks!, maps[gains.maps[0]].differences.length)).buffer;
      if (uniform_weights.length) return uniform(uniform_weights).buffer;
      const layers = Object.values(textures).filter(({ columns }) => columns !== undefined);
      const parts = await Promise.all(layers.map(async ({ file, columns }) => stacked(await png(+t, file), columns!, weight_size, order.length)));
      return new Blob(parts).arrayBuffer();
    },

    async image(name, scale, size) {
      const [, t, m, part] = /^tile_(\d+)\.map_(\d+)\.(\w+)$/.exec(name)!;
      const { maps, textures, gains } = tiles[+t];
      const { neutral, differences } = maps[gains.maps[+m]];
      const { file, low } = textures[part.startsWith("neutral") ? neutral : differences[+part.split("_")[1]]];
      const image = await asked(new URL(part === "neutral_low" ? low! : file, places[+t]));
      return bitmapOf(await image.blob(), scale, size);
    },
  };
}

/** The images of an atlas one after the other. */
function stacked({ bytes, width, channels }: Texels, columns: number, [rows, across]: [number, number], count: number): Uint8Array<ArrayBuffer> {
  const length = across * channels;
  const all = new Uint8Array(count * rows * length);
  for (let n = 0; n < count; n++) {
    for (let y = 0; y < rows; y++) {
      const from = (Math.floor(n / columns) * rows + y) * width * channels + (n % columns) * length;
      all.set(bytes.subarray(from, from + length), (n * rows + y) * length);
    }
  }
  return all;
}

/** Of each layer of four slots the weights of every expression. */
function uniform(weights: number[][]): Float32Array<ArrayBuffer> {
  const layers = Array.from({ length: layersOf(weights[0].length) }, (_, layer) => weights.flatMap((row) => [0, 1, 2, 3].map((slot) => row[4 * layer + slot] ?? 0)));
  return Float32Array.from(layers.flat());
}
