// The original textures, blended as no game could afford: (1 − Σ_n β_n) I_0 + Σ_n β_n I_n, each expression's at full size.

import * as THREE from "three";
import type { Assets } from "./head/document";
import { COMMON, numbersOf } from "./head/glsl";
import type { Head } from "./head/head";
import { floatType } from "./head/prepass";
import { drawInto, quad } from "./head/quad";

const KEPT_BYTES = 512e6;
// Images on their way at once.
const MOST_ASKED = 4;
const NEUTRAL = -1;

export class Originals {
  private readonly blends: Blend[][];
  // By the name of an image; the one that was used last is the last.
  private readonly kept = new Map<string, THREE.Texture>();
  private readonly asked = new Set<string>();

  private constructor(renderer: THREE.WebGLRenderer, private readonly head: Head, private readonly assets: Assets, private readonly arrived: () => void) {
    this.blends = head.document.tiles.map((_, t) => head.document.maps.map((_, m) => new Blend(renderer, head, t, m)));
  }

  /** Null where the GPU draws no floating-point numbers, which the sums need. */
  static of(renderer: THREE.WebGLRenderer, head: Head, assets: Assets, arrived: () => void): Originals | null {
    return floatType(renderer) ? new Originals(renderer, head, assets, arrived) : null;
  }

  texture(t: number, m: number): THREE.Texture {
    return this.blends[t][m].target.texture;
  }

  /** Blend these maps on every tile; false while a texture is still on its way, and `arrived` is called then. */
  render(weights: Float32Array, revision: number, maps: number[]): boolean {
    const blends = this.blends.flatMap((tile) => maps.map((m) => tile[m]));
    for (const blend of blends) blend.follow(weights, revision);
    for (const blend of blends) {
      // Always in one order, whatever arrives first: sums of half floats depend on it.
      let ahead = 0;
      for (const n of [...blend.pending.keys()]) {
        const texels = this.texels(blend, n);
        if (texels && ahead === 0) blend.add(n, texels);
        else if (++ahead === MOST_ASKED) break;
      }
    }
    return blends.every(({ pending }) => pending.size === 0);
  }

  private texels({ t, m }: Blend, n: number): THREE.Texture | null {
    const name = `tile_${t}.map_${m}.${n === NEUTRAL ? "original" : `original_${n}`}`;
    const found = this.kept.get(name);
    if (found) {
      this.kept.delete(name);
      this.kept.set(name, found);
      return found;
    }
    if (!this.asked.has(name) && this.asked.size < MOST_ASKED) void this.fetch(name, this.head.document.tiles[t].textures[m].size);
    return null;
  }

  private async fetch(name: string, size: [number, number]): Promise<void> {
    this.asked.add(name);
    const texture = new THREE.Texture(await this.assets.image(name, this.head.scale, size));
    Object.assign(texture, { flipY: false, generateMipmaps: false, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter, needsUpdate: true });
    this.asked.delete(name);
    this.kept.set(name, texture);
    const most = Math.max(2 * MOST_ASKED, Math.floor(KEPT_BYTES / (4 * texture.image.width * texture.image.height)));
    for (const [oldest, old] of this.kept) {
      if (this.kept.size <= most) break;
      old.dispose();
      this.kept.delete(oldest);
    }
    this.arrived();
  }
}

/** The sum of one map on one tile, to which textures are added in turn. */
class Blend {
  readonly target: THREE.WebGLRenderTarget;
  /** What is still to be added, and how much of it. */
  readonly pending = new Map<number, number>();
  private revision = -1;
  private readonly quad;
  private readonly uniforms = { texels: { value: null as THREE.Texture | null }, weight: { value: 0 } };

  constructor(private readonly renderer: THREE.WebGLRenderer, head: Head, readonly t: number, readonly m: number) {
    const map = head.document.maps[m];
    const [rows, columns] = head.document.tiles[t].textures[m].size.map((side) => Math.max(1, Math.round(side * head.scale)));
    this.target = new THREE.WebGLRenderTarget(columns, rows, {
      type: THREE.HalfFloatType, depthBuffer: false, generateMipmaps: true,
      minFilter: THREE.LinearMipmapLinearFilter, magFilter: THREE.LinearFilter, anisotropy: 4,
    });
    const stored = numbersOf(map, "texelFetch(texels, ivec2(gl_FragCoord.xy), 0)");
    this.quad = quad(`${COMMON}
uniform sampler2D texels;
uniform float weight;
out vec4 share;
void main() { share = vec4(weight * ${map.encoding === "normal" ? `slopesOf(${stored})` : stored}, 1.0); }`, this.uniforms, {
      blending: THREE.CustomBlending, blendSrc: THREE.OneFactor, blendDst: THREE.OneFactor, transparent: true,
    });
  }

  /** Begin again where the weights have changed. */
  follow(weights: Float32Array, revision: number): void {
    if (this.revision === revision) return;
    this.revision = revision;
    this.pending.clear();
    weights.forEach((weight, n) => { if (weight !== 0) this.pending.set(n, weight); });
    this.pending.set(NEUTRAL, 1 - weights.reduce((sum, weight) => sum + weight, 0));
    drawInto(this.renderer, this.target, 0, () => {
      this.renderer.setClearColor(0x000000, 0);
      this.renderer.clear();
    });
  }

  add(n: number, texels: THREE.Texture): void {
    const { renderer } = this;
    Object.assign(this.uniforms.texels, { value: texels });
    Object.assign(this.uniforms.weight, { value: this.pending.get(n) });
    this.pending.delete(n);
    const clearing = renderer.autoClear;
    renderer.autoClear = false;
    drawInto(renderer, this.target, 0, () => this.quad.render(renderer));
    renderer.autoClear = clearing;
  }
}
