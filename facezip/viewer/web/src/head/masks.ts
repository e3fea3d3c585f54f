// Weight maps that are sums of fixed masks: a blend is a few numbers a mask, whatever the number of expressions.

import * as THREE from "three";

/** What each expression adds to the activations of a blend, one after the other. */
export class Activations {
  /** Σ_n β_n a_n: of each layer of four slots, and in it of each mask, the four of a vector. */
  readonly sum: Float32Array<ArrayBuffer>;
  private readonly rows: Float32Array;

  /** `stored` are half floats. */
  constructor(stored: ArrayBuffer, expressions: number) {
    this.rows = Float32Array.from(new Uint16Array(stored), (half) => THREE.DataUtils.fromHalfFloat(half));
    this.sum = new Float32Array(this.rows.length / expressions);
  }

  blend(weights: Float32Array): void {
    const { rows, sum } = this;
    sum.fill(0);
    weights.forEach((weight, n) => {
      if (weight === 0) return;
      for (let i = 0, from = n * sum.length; i < sum.length; i++, from++) sum[i] += weight * rows[from];
    });
  }
}

/** W = Σ_k c_k M_k, four masks in each fetch. */
export const MASKED = `
uniform sampler2DArray maps;
uniform sampler2D blend;
uniform int layer, count, stacked, height;
out vec4 combined;
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 sum = vec4(0.0);
  for (int four = 0; four < count; four++) {
    vec4 mask = texelFetch(maps, ivec3(texel.x, four % stacked * height + texel.y, four / stacked), 0);
    for (int k = 0; k < 4; k++) sum += mask[k] * texelFetch(blend, ivec2(4 * four + k, layer), 0);
  }
  combined = sum * leftAt(texel);
}`;
