// A head: its mesh, the textures of each tile, and their blend. Free of the page that shows it.

import * as THREE from "three";
import type { Assets, HeadDocument } from "./document";
import { Face } from "./face";
import { mapSource, mapUniforms, weightSource } from "./glsl";
import { type Prepass, prepassOf } from "./prepass";
import { readTexture, scaleFor } from "./textures";

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
    const [face, ...made] = await Promise.all([mesh ? readFace(assets, tiles.length) : null, ...tiles.map((_, t) => Tile.open(renderer, document, assets, t, scale))]);
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

export class Tile {
  private constructor(readonly document: HeadDocument, readonly number: number, readonly prepass: Prepass, readonly textures: THREE.DataArrayTexture[]) {}

  static async open(renderer: THREE.WebGLRenderer, document: HeadDocument, assets: Assets, t: number, scale: number): Promise<Tile> {
    const prepass = prepassOf(renderer, document, document.tiles[t], await assets.array(`tile_${t}.weights`));
    const textures = await Promise.all(document.maps.map((_, m) => readTexture(renderer, document, assets, t, m, scale)));
    return new Tile(document, t, prepass, textures);
  }

  get entry() {
    return this.document.tiles[this.number];
  }

  /** GLSL and uniforms of some maps under names of ours: `NAME_neutral(at)` and `NAME_blend(at)`, after `readWeights(at)`. */
  shader(maps: Record<string, number>): { source: string; uniforms: Record<string, THREE.IUniform> } {
    const { document, entry } = this;
    const source = [weightSource(document)];
    const uniforms: Record<string, THREE.IUniform> = { weightMaps: { value: this.prepass.combined }, mipmaps: { value: true }, place: { value: new THREE.Vector2(...entry.place) } };
    for (const [name, m] of Object.entries(maps)) {
      source.push(mapSource(name, document, document.maps[m], entry.textures[m]));
      Object.assign(uniforms, mapUniforms(name, entry.textures[m], this.textures[m]));
    }
    return { source: source.join("\n"), uniforms };
  }
}

async function readFace(assets: Assets, tiles: number): Promise<Face> {
  const tileOf = tiles > 1 ? new Uint8Array(await assets.array("tiles_of_faces")) : null;
  return Face.read(await assets.array("head"), tileOf, tiles);
}
