// Once a frame: Σ_n β_n W_n of equation (8), at the low resolution of the weight maps.

import * as THREE from "three";
import { FullScreenQuad } from "three/addons/postprocessing/Pass.js";
import type { Maps } from "./maps";
import type { Scene } from "./scene";

const VERTEX = `
in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }`;

const FRAGMENT = `
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D atlas, blend;
uniform ivec2 size;
uniform int count, columns;
uniform vec4 scale, offset;
out vec4 combined;
void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 sum = vec4(0.0);
  float total = 0.0;
  for (int n = 0; n < count; n++) {
    float beta = texelFetch(blend, ivec2(n, 0), 0).r;
    if (beta == 0.0) continue;
    sum += beta * texelFetch(atlas, ivec2(n % columns, n / columns) * size + texel, 0);
    total += beta;
  }
  combined = scale * sum + offset * total;
}`;

export class Prepass {
  /** Combined weights, one RGBA texture a layer, to be sampled bilinearly with clamped borders. */
  readonly combined: THREE.Texture[];
  private readonly blend: THREE.DataTexture;
  private readonly targets: THREE.WebGLRenderTarget[];
  private readonly quads: FullScreenQuad[];

  constructor(private readonly renderer: THREE.WebGLRenderer, scene: Scene, maps: Maps) {
    const [rows, columns] = scene.weight_size;
    const count = scene.expressions.length;
    const filterable = renderer.extensions.has("OES_texture_float_linear");
    this.blend = new THREE.DataTexture(new Float32Array(count), count, 1, THREE.RedFormat, THREE.FloatType);
    this.targets = maps.weights.map(() => new THREE.WebGLRenderTarget(columns, rows, {
      type: filterable ? THREE.FloatType : THREE.HalfFloatType, depthBuffer: false,
      minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter,
    }));
    this.combined = this.targets.map((target) => target.texture);
    this.quads = maps.weights.map((atlas, layer) => new FullScreenQuad(new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, depthTest: false, depthWrite: false,
      uniforms: {
        atlas: { value: atlas }, blend: { value: this.blend }, count: { value: count },
        size: { value: new THREE.Vector2(columns, rows) }, columns: { value: scene.weight_columns },
        scale: { value: fourOf(scene.weight_scale, layer) }, offset: { value: fourOf(scene.weight_offset, layer) },
      },
    })));
  }

  render(weights: Float32Array): void {
    (this.blend.image.data as Float32Array).set(weights);
    this.blend.needsUpdate = true;
    const before = this.renderer.getRenderTarget();
    this.targets.forEach((target, layer) => {
      this.renderer.setRenderTarget(target);
      this.quads[layer].render(this.renderer);
    });
    this.renderer.setRenderTarget(before);
  }
}

const fourOf = (values: number[], layer: number) =>
  new THREE.Vector4(...[0, 1, 2, 3].map((i) => values[4 * layer + i] ?? 0));
