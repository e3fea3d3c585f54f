// A head: its mesh, the textures of each tile, and their blend. Free of the page that shows it.

import * as THREE from "three";
import type { Assets, HeadDocument } from "./document";
import { Face } from "./face";
import { mapSource, mapUniforms, weightSource } from "./glsl";
import { type Prepass, prepassOf } from "./prepass";
import { readImages, scaleFor, textureOf } from "./textures";

export class Head {
  private constructor(
    readonly document: HeadDocument,
    readonly face: Face | null,
    readonly tiles: Tile[],
    /** How much smaller textures are than in the pack, as 1, 1/2, 1/4 …. */
    readonly scale: number,
  ) {}

  static async open(renderer: THREE.WebGLRenderer, document: HeadDocument, assets: Assets): Promise<Head> {
    const { mesh, tiles } = document;
    const scale = scaleFor(renderer, document);
    const [face, ...made] = await Promise.all([mesh ? readFace(assets, tiles.length) : null, ...tiles.map(async (_, t) => new Tile(renderer, document, t, await readTile(document, assets, t, scale)))]);
    if (renderer.getContext().getError() === renderer.getContext().OUT_OF_MEMORY) throw new Error("its textures do not fit into this GPU's memory");
    const head = new Head(document, face, made, scale);
    head.blend(new Float32Array(document.expressions.length));
    return head;
  }

  /** Once a frame, before anything is shaded: vertices and combined weights of β. */
  blend(weights: Float32Array): void {
    this.face?.deform(weights);
    for (const { prepass } of this.tiles) prepass.render(weights);
  }
}

/** What a tile is made of, before a GPU has it. */
export interface TileContent {
  /** Weight maps, or the masks that they are sums of, one after the other. */
  weights: ArrayBuffer;
  /** Of masks: half floats. */
  activations: ArrayBuffer | null;
  /** Masks of the regions, one after the other. */
  regions: ArrayBuffer | null;
  /** Of each map. */
  images: ImageBitmap[][];
}

export async function readTile(document: HeadDocument, assets: Assets, t: number, scale: number): Promise<TileContent> {
  const [weights, activations, regions, ...images] = await Promise.all([
    assets.array(`tile_${t}.${document.fours ? "masks" : "weights"}`), document.fours ? assets.array("activations") : null,
    document.regions?.length ? assets.array(`tile_${t}.regions`) : null,
    ...document.maps.map((_, m) => readImages(document, assets, t, m, scale)),
  ]);
  return { weights, activations, regions, images };
}

export class Tile {
  readonly prepass: Prepass;
  readonly textures: THREE.DataArrayTexture[];

  constructor(renderer: THREE.WebGLRenderer, readonly document: HeadDocument, readonly number: number, content: TileContent) {
    this.prepass = prepassOf(renderer, document, document.tiles[number], content);
    this.textures = content.images.map((images, m) => textureOf(renderer, document.maps[m], images));
  }

  /** GLSL and uniforms of some maps under names of ours: `NAME_neutral(at)` and `NAME_blend(at)`, after `readWeights(at)`. */
  shader(maps: Record<string, number>): { source: string; uniforms: Record<string, THREE.IUniform> } {
    return shaderOf(this.document, this.number, maps, this);
  }
}

/** The same of a tile that is not on a GPU yet: uniforms of textures are null. */
export function shaderOf(document: HeadDocument, t: number, maps: Record<string, number>, tile: Tile | null = null): { source: string; uniforms: Record<string, THREE.IUniform> } {
  const entry = document.tiles[t];
  const source = [weightSource(document)];
  const uniforms: Record<string, THREE.IUniform> = {
    weightMaps: { value: tile && tile.prepass.combined }, mipmaps: { value: true }, place: { value: new THREE.Vector2(...entry.place) },
  };
  for (const [name, m] of Object.entries(maps)) {
    source.push(mapSource(name, document, document.maps[m], entry.textures[m]));
    Object.assign(uniforms, mapUniforms(name, entry.textures[m], tile && tile.textures[m]));
  }
  return { source: source.join("\n"), uniforms };
}

async function readFace(assets: Assets, tiles: number): Promise<Face> {
  const tileOf = tiles > 1 ? new Uint8Array(await assets.array("tiles_of_faces")) : null;
  return Face.read(await assets.array("head"), tileOf, tiles);
}
