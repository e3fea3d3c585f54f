// The original textures, blended as no game could afford: I_0 + Σ_n β_n (I_n − I_0), each expression's at full size.

import * as THREE from "three";
import { FullScreenQuad } from "three/addons/postprocessing/Pass.js";
import { colourTexture } from "./maps";
import { readImage, type Scene } from "./scene";

const KEPT_BYTES = 512e6;
const VERTEX = `
in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }`;
const FRAGMENT = `
precision highp float;
uniform sampler2D texels, neutral;
uniform float weight;
out vec4 share;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 start = texelFetch(neutral, at, 0).rgb;
  share = vec4(weight < 0.0 ? start : weight * (texelFetch(texels, at, 0).rgb - start), 1.0);
}`;

export class Originals {
  readonly target: THREE.WebGLRenderTarget;
  private neutral: THREE.Texture | null = null;
  private readonly kept = new Map<number, THREE.Texture | Promise<void>>();
  private readonly material: THREE.RawShaderMaterial;
  private readonly quad: FullScreenQuad;
  private readonly most: number;

  constructor(private readonly renderer: THREE.WebGLRenderer, scene: Scene, private readonly arrived: () => void) {
    const [rows, columns] = scene.size;
    this.most = Math.max(8, Math.floor(KEPT_BYTES / (4 * rows * columns)));
    this.target = new THREE.WebGLRenderTarget(columns, rows, {
      type: THREE.HalfFloatType, depthBuffer: false, generateMipmaps: true,
      minFilter: THREE.LinearMipmapLinearFilter, magFilter: THREE.LinearFilter, anisotropy: 4,
    });
    this.material = new THREE.RawShaderMaterial({
      glslVersion: THREE.GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, depthTest: false, depthWrite: false,
      blending: THREE.CustomBlending, blendSrc: THREE.OneFactor, blendDst: THREE.OneFactor, transparent: true,
      uniforms: { texels: { value: null }, neutral: { value: null }, weight: { value: -1 } },
    });
    this.quad = new FullScreenQuad(this.material);
  }

  async start(): Promise<void> {
    this.neutral = colourTexture(await readImage("original"));
  }

  /** Draw the blend; false while a texture that it needs is still on its way, and `arrived` is called then. */
  render(weights: Float32Array): boolean {
    const active = [...weights.keys()].filter((n) => weights[n] !== 0);
    const textures = active.map((n) => this.texture(n));
    if (!this.neutral || textures.some((texture) => texture === null)) return false;
    const { renderer } = this;
    const [before, clearing] = [renderer.getRenderTarget(), renderer.autoClear];
    renderer.setRenderTarget(this.target);
    renderer.setClearColor(0x000000, 0);
    renderer.clear();
    renderer.autoClear = false;
    this.add(this.neutral, -1);
    active.forEach((n, k) => this.add(textures[k] as THREE.Texture, weights[n]));
    renderer.autoClear = clearing;
    renderer.setRenderTarget(before);
    return true;
  }

  private add(texels: THREE.Texture, weight: number): void {
    Object.assign(this.material.uniforms.texels, { value: texels });
    Object.assign(this.material.uniforms.neutral, { value: this.neutral });
    Object.assign(this.material.uniforms.weight, { value: weight });
    this.quad.render(this.renderer);
  }

  private texture(n: number): THREE.Texture | null {
    const found = this.kept.get(n);
    if (found instanceof THREE.Texture) {
      this.kept.delete(n);
      this.kept.set(n, found);
      return found;
    }
    if (!found) this.kept.set(n, this.fetch(n));
    return null;
  }

  private async fetch(n: number): Promise<void> {
    const texture = colourTexture(await readImage(`original_${n}`));
    this.kept.set(n, texture);
    for (const [oldest, old] of this.kept) {
      if (this.kept.size <= this.most) break;
      if (old instanceof THREE.Texture) old.dispose();
      this.kept.delete(oldest);
    }
    this.arrived();
  }
}
