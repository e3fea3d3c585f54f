// A tile of a head in a scene: its mesh, what the GPU has of it, and its materials.

import * as THREE from "three";
import type { HeadDocument } from "../head/document";
import { colourOf, flatMaterial } from "../head/flat";
import { shaderOf, Tile, type TileContent } from "../head/head";
import { rolesOf, skinMaterial } from "../head/skin";

/** The maps of a material by our names for them, and its uniforms. */
interface Look { maps: Record<string, number>; uniforms: Record<string, THREE.IUniform> }

export class Part {
  readonly skin: THREE.MeshPhysicalMaterial;
  private readonly looks: Look[] = [];
  private tile: Tile | null = null;

  /** `content` waits for a renderer. */
  constructor(private readonly document: HeadDocument, private readonly number: number, readonly mesh: THREE.Mesh, private readonly content: TileContent) {
    const roles = rolesOf(document);
    const lookups = Object.fromEntries(Object.entries(roles).map(([role, m]) => [role, { map: document.maps[m], call: `${role}_blend` }]));
    const { source, uniforms } = this.look(roles);
    const stated = mesh.material as THREE.Material;
    this.skin = skinMaterial(lookups, source, uniforms);
    this.skin.name = stated.name;
    stated.dispose();
    mesh.material = this.skin;
  }

  /** What a GPU has to take: the longest side of a texture. */
  get side(): number {
    return Math.max(...this.content.images.flat().map(({ width, height }) => Math.max(width, height)));
  }

  upload(renderer: THREE.WebGLRenderer): void {
    this.tile = new Tile(renderer, this.document, this.number, this.content);
    for (const { maps, uniforms } of this.looks) {
      for (const [name, { value }] of Object.entries(this.tile.shader(maps).uniforms)) uniforms[name].value = value;
    }
  }

  /** Combine the weights of expressions under the gains of regions. */
  blend(weights: Float32Array, regions: Float32Array): void {
    this.tile!.prepass.render(weights, regions);
  }

  /** What the changes of maps are multiplied by, one a map. */
  turn(gains: number[]): void {
    for (const { maps, uniforms } of this.looks) {
      for (const [name, m] of Object.entries(maps)) uniforms[`${name}_gain`].value = gains[m];
    }
  }

  /** A map without light; null is the skin. */
  show(m: number | null): void {
    this.hide();
    if (m === null) return;
    const { source, uniforms } = this.look({ shown: m });
    const shown = `vec3 colourAt(vec2 at) { vec3 value = shown_blend(at); return ${colourOf(this.document.maps[m], "value")}; }`;
    this.mesh.material = flatMaterial(`${source}\n${shown}`, uniforms);
  }

  dispose(): void {
    this.hide();
    this.skin.dispose();
    this.mesh.geometry.dispose();
    this.tile?.prepass.dispose();
    for (const texture of this.tile?.textures ?? []) texture.dispose();
    for (const image of this.content.images.flat()) image.close();
  }

  private look(maps: Record<string, number>) {
    const shader = shaderOf(this.document, this.number, maps, this.tile);
    this.looks.push({ maps, uniforms: shader.uniforms });
    return shader;
  }

  private hide(): void {
    if (this.mesh.material !== this.skin) (this.mesh.material as THREE.Material).dispose();
    this.mesh.material = this.skin;
    this.looks.length = 1;
  }
}
