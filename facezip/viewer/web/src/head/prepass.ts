// Once a frame: Σ_n β_n W_n of equation (8), at the low resolution of the weight maps; a layer for every four slots.

import * as THREE from "three";
import { type HeadDocument, layersOf, type TileEntry } from "./document";
import type { TileContent } from "./head";
import { Activations, MASKED } from "./masks";
import { drawInto, quad } from "./quad";

/** What regions of the face leave of the weights at a texel: everything where all gains are 1. */
const regionSource = (count: number) => (count ? `
uniform sampler2DArray masks;
uniform float gains[${count}];
float leftAt(ivec2 texel) {
  float left = 1.0;
  for (int k = 0; k < ${count}; k++) left *= 1.0 + texelFetch(masks, ivec3(texel, k), 0).r * (gains[k] - 1.0);
  return left;
}` : "float leftAt(ivec2 texel) { return 1.0; }");

const FRAGMENT = `
uniform sampler2DArray maps;
uniform sampler2D blend;
uniform int first, count, stacked, height;
uniform vec4 span, offset;
out vec4 combined;
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 sum = vec4(0.0);
  float total = 0.0;
  for (int n = 0; n < count; n++) {
    float beta = texelFetch(blend, ivec2(n, 0), 0).r;
    if (beta == 0.0) continue;
    int place = first + n;
    sum += beta * texelFetch(maps, ivec3(texel.x, place % stacked * height + texel.y, place / stacked), 0);
    total += beta;
  }
  combined = (span * sum + offset * total) * leftAt(texel);
}`;

export interface Prepass {
  /** Combined weights, to be sampled bilinearly with clamped borders. */
  readonly combined: THREE.DataArrayTexture;
  /** `gains` are those of the regions, all 1 where none are given. */
  render(weights: Float32Array, gains?: Float32Array): void;
  dispose(): void;
}

/** On the GPU if it draws floating-point numbers, else here, with the same result. */
export function prepassOf(renderer: THREE.WebGLRenderer, head: HeadDocument, tile: TileEntry, { weights, activations, regions }: Omit<TileContent, "images">): Prepass {
  const maps = head.uniform ? new Float32Array(weights) : new Uint8Array(weights);
  const masks = regions ? new Uint8Array(regions) : new Uint8Array();
  const type = floatType(renderer);
  const limit = renderer.capabilities.maxTextureSize;
  const [rows, columns] = tile.weight_size;
  if (Math.max(rows, columns) > limit) throw new Error(`this GPU takes textures of up to ${limit} texels, a weight map has ${columns} × ${rows}`);
  const mixed = activations && new Activations(activations, head.expressions.length);
  return type ? new GpuPrepass(renderer, head, tile, maps, mixed, masks, type) : new CpuPrepass(head, tile, maps, mixed, masks);
}

/** The widest floats that can be drawn into and filtered; null for none. */
export function floatType({ extensions }: THREE.WebGLRenderer): THREE.TextureDataType | null {
  if (extensions.has("EXT_color_buffer_float")) return extensions.has("OES_texture_float_linear") ? THREE.FloatType : THREE.HalfFloatType;
  return extensions.has("EXT_color_buffer_half_float") ? THREE.HalfFloatType : null;
}

class GpuPrepass implements Prepass {
  readonly combined: THREE.DataArrayTexture;
  private readonly blend: THREE.DataTexture;
  private readonly target: THREE.WebGLArrayRenderTarget;
  private readonly quads;
  private readonly gains: THREE.IUniform<Float32Array>;
  private readonly stored: THREE.Texture[];

  constructor(private readonly renderer: THREE.WebGLRenderer, head: HeadDocument, tile: TileEntry, maps: Float32Array | Uint8Array, private readonly mixed: Activations | null, masks: Uint8Array<ArrayBuffer>, type: THREE.TextureDataType) {
    const [[rows, columns], layers, fours] = [tile.weight_size, layersOf(head.slots), head.fours ?? 0];
    const count = fours || head.expressions.length;
    const { texture, stacked } = inStacks(renderer, maps, rows, columns, fours || layers * count);
    this.blend = mixed
      ? new THREE.DataTexture(mixed.sum, 4 * fours, layers, THREE.RGBAFormat, THREE.FloatType)
      : new THREE.DataTexture(new Float32Array(count), count, 1, THREE.RedFormat, THREE.FloatType);
    this.target = new THREE.WebGLArrayRenderTarget(columns, rows, layers, { type, depthBuffer: false, minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter });
    this.combined = this.target.texture as THREE.DataArrayTexture;
    const regions = head.regions?.length ?? 0;
    this.gains = { value: new Float32Array(regions).fill(1) };
    this.stored = [texture, masksOf(masks, rows, columns, regions)];
    this.quads = Array.from({ length: layers }, (_, layer) => quad(regionSource(regions) + (mixed ? MASKED : FRAGMENT), {
      maps: { value: texture }, masks: { value: this.stored[1] }, gains: this.gains, blend: { value: this.blend }, layer: { value: layer }, first: { value: layer * count }, count: { value: count },
      stacked: { value: stacked }, height: { value: rows },
      span: { value: fourOf(tile.weight_span, layer) }, offset: { value: fourOf(tile.weight_offset, layer) },
    }));
  }

  render(weights: Float32Array, gains?: Float32Array): void {
    if (gains) this.gains.value.set(gains);
    if (this.mixed) this.mixed.blend(weights);
    else (this.blend.image.data as Float32Array).set(weights);
    this.blend.needsUpdate = true;
    this.quads.forEach((one, layer) => drawInto(this.renderer, this.target, layer, () => one.render(this.renderer)));
  }

  dispose(): void {
    for (const made of [this.target, this.blend, ...this.stored, ...this.quads.map(({ material }) => material)]) made.dispose();
  }
}

class CpuPrepass implements Prepass {
  readonly combined: THREE.DataArrayTexture;
  private readonly sums: Float32Array;
  private readonly halves: Uint16Array<ArrayBuffer>;

  constructor(private readonly head: HeadDocument, private readonly tile: TileEntry, private readonly maps: Float32Array | Uint8Array, private readonly mixed: Activations | null, private readonly masks: Uint8Array) {
    const [rows, columns] = tile.weight_size;
    this.halves = new Uint16Array(4 * rows * columns * layersOf(head.slots));
    this.sums = new Float32Array(this.halves.length);
    this.combined = new THREE.DataArrayTexture(this.halves, columns, rows, layersOf(head.slots));
    this.combined.type = THREE.HalfFloatType;
    this.combined.minFilter = this.combined.magFilter = THREE.LinearFilter;
  }

  render(weights: Float32Array, gains?: Float32Array): void {
    const { sums, tile, mixed } = this;
    const one = 4 * tile.weight_size[0] * tile.weight_size[1];
    const total = weights.reduce((sum, beta) => sum + beta, 0);
    sums.fill(0);
    if (mixed) this.addMasks(mixed, weights, one);
    else this.addMaps(weights, one);
    for (let i = 0; i < sums.length; i++) {
      const slot = 4 * Math.floor(i / one) + (i & 3);
      const sum = (tile.weight_span[slot] ?? 0) * sums[i] + (tile.weight_offset[slot] ?? 0) * total;
      this.halves[i] = THREE.DataUtils.toHalfFloat(sum * this.leftAt((i % one) >> 2, gains));
    }
    this.combined.needsUpdate = true;
  }

  private addMaps(weights: Float32Array, one: number): void {
    const { sums, maps, head } = this;
    const [count, step] = [head.expressions.length, head.uniform ? 1 : 1 / 255];
    for (let layer = 0; layer < layersOf(head.slots); layer++) {
      for (let n = 0; n < count; n++) {
        if (weights[n] === 0) continue;
        const from = (layer * count + n) * one;
        for (let i = 0, to = layer * one; i < one; i++, to++) sums[to] += weights[n] * step * maps[from + i];
      }
    }
  }

  private addMasks(mixed: Activations, weights: Float32Array, one: number): void {
    const { sums, maps } = this;
    mixed.blend(weights);
    mixed.sum.forEach((activation, at) => {
      const [slot, mask] = [at & 3, (at >> 2) % (4 * this.head.fours!)];
      const [from, to] = [(mask >> 2) * one + (mask & 3), Math.floor(at / (16 * this.head.fours!)) * one + slot];
      for (let i = 0; i < one; i += 4) sums[to + i] += (activation * maps[from + i]) / 255;
    });
  }

  private leftAt(texel: number, gains: Float32Array = new Float32Array()): number {
    const [rows, columns] = this.tile.weight_size;
    return gains.reduce((left, gain, k) => left * (1 + (this.masks[k * rows * columns + texel] / 255) * (gain - 1)), 1);
  }

  dispose(): void {
    this.combined.dispose();
  }
}

function masksOf(masks: Uint8Array<ArrayBuffer>, rows: number, columns: number, count: number): THREE.DataArrayTexture {
  const texture = new THREE.DataArrayTexture(masks, columns, rows, count);
  texture.format = THREE.RedFormat;
  texture.needsUpdate = count > 0;
  return texture;
}

// Weight maps one below the other, as they lie in memory, in layers as high as the GPU takes. They are read texel by texel alone: no
// filter ever reaches from one into the next.
function inStacks(renderer: THREE.WebGLRenderer, maps: Float32Array | Uint8Array, rows: number, columns: number, images: number) {
  const depth = Math.ceil(images / Math.floor(renderer.capabilities.maxTextureSize / rows));
  const gl = renderer.getContext() as WebGL2RenderingContext;
  const most: number = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS);
  if (depth > most) throw new Error(`this GPU takes textures of up to ${most} layers, the weight maps need ${depth}`);
  const stacked = Math.ceil(images / depth);
  const padded = new (maps.constructor as Float32ArrayConstructor)(4 * rows * columns * stacked * depth);
  padded.set(maps);
  const texture = new THREE.DataArrayTexture(padded, columns, rows * stacked, depth);
  texture.type = maps instanceof Float32Array ? THREE.FloatType : THREE.UnsignedByteType;
  texture.needsUpdate = true;
  return { texture, stacked };
}

const fourOf = (values: number[], layer: number) => new THREE.Vector4(...[0, 1, 2, 3].map((i) => values[4 * layer + i] ?? 0));
