// Frame time of the paper's blend beside that of fetching every texture, in turn, on this machine's GPU.

import * as THREE from "three";
import { FullScreenQuad } from "three/addons/postprocessing/Pass.js";
import { blendSource } from "./skin";
import type { Stage } from "./stage";

const FRAMES = 4;
const ROUNDS = 7;
const LARGEST = 1024;
// As layers of 1024² they take 270 MB.
const MOST = 64;
const VERTEX = `
in vec3 position;
out vec2 at;
void main() { at = 0.5 + 0.5 * position.xy; gl_Position = vec4(position.xy, 0.0, 1.0); }`;
const HEAD = `
precision highp float;
precision highp sampler2DArray;
in vec2 at;
out vec4 colour;`;

export interface FrameTimes {
  size: number; expressions: number; fetches: number; facezip_ms: number; all_ms: number; ratio: number; rounds: number; frames: number; device: string;
}

/** Both draw a full square of pixels with every expression at once; the median of the rounds' times and ratios. */
export function measureFrames(stage: Stage): FrameTimes {
  const { renderer, scene } = stage;
  const size = Math.min(LARGEST, Math.max(...scene.size));
  const all = scene.expressions.length;
  const count = Math.min(MOST, all);
  const out = new THREE.WebGLRenderTarget(size, size, { depthBuffer: false });
  const weights = Float32Array.from({ length: all }, (_, n) => (n < count ? 1 / count : 0));
  const uniforms = bilinear(stage.blendUniforms);
  const ours = quadOf(`${HEAD}${blendSource(scene.difference_scale.length, scene.difference_zero)}
void main() { colour = vec4(blendOf(at), 1.0); }`, uniforms);
  const every = everyTexture(stage, ours, size, count);
  const facezip = () => {
    stage.prepass.render(weights);
    draw(renderer, ours, out);
  };
  const textures = () => draw(renderer, every.quad, out);
  for (const once of [facezip, textures]) seconds(renderer, once, out);
  const rounds = Array.from({ length: ROUNDS }, () => [seconds(renderer, facezip, out), seconds(renderer, textures, out)]);
  const copies = Object.values(uniforms).map(({ value }) => value).filter(isStored);
  for (const made of [out, every.target, ...copies]) made.dispose();
  renderer.setRenderTarget(null);
  stage.invalidate();
  return {
    size, expressions: count, fetches: scene.costs.fetches, rounds: ROUNDS, frames: FRAMES, device: deviceOf(renderer),
    facezip_ms: 1e3 * median(rounds.map(([a]) => a)), all_ms: 1e3 * median(rounds.map(([, b]) => b)),
    ratio: median(rounds.map(([a, b]) => a / b)),
  };
}

// The textures of all expressions as layers of one array: more than a shader may have by name.
function everyTexture(stage: Stage, ours: FullScreenQuad, size: number, count: number) {
  const { renderer } = stage;
  const target = new THREE.WebGLArrayRenderTarget(size, size, count + 1, { depthBuffer: false, minFilter: THREE.LinearFilter });
  for (let layer = 0; layer <= count; layer++) {
    stage.prepass.render(Float32Array.from({ length: stage.scene.expressions.length }, (_, n) => Number(n === layer - 1)));
    renderer.setRenderTarget(target, layer);
    ours.render(renderer);
  }
  const quad = quadOf(`${HEAD}
uniform sampler2DArray textures;
uniform float weights[${count}];
void main() {
  vec3 neutral = texture(textures, vec3(at, 0.0)).rgb, sum = neutral;
  for (int n = 0; n < ${count}; n++) sum += weights[n] * (texture(textures, vec3(at, float(n + 1))).rgb - neutral);
  colour = vec4(clamp(sum, 0.0, 1.0), 1.0);
}`, { textures: { value: target.texture }, weights: { value: new Array(count).fill(1 / count) } });
  return { target, quad };
}

function quadOf(fragmentShader: string, uniforms: Record<string, THREE.IUniform>): FullScreenQuad {
  return new FullScreenQuad(new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3, vertexShader: VERTEX, fragmentShader, uniforms, depthTest: false, depthWrite: false,
  }));
}

function draw(renderer: THREE.WebGLRenderer, quad: FullScreenQuad, target: THREE.WebGLRenderTarget): void {
  renderer.setRenderTarget(target);
  quad.render(renderer);
}

const isStored = (value: unknown): value is THREE.Texture => value instanceof THREE.Texture && !value.isRenderTargetTexture;

// Both sides are filtered alike: bilinear, without mip-maps.
function bilinear(uniforms: Record<string, THREE.IUniform>): Record<string, THREE.IUniform> {
  const plain = (value: unknown) => {
    if (!isStored(value)) return value;
    const copy = value.clone();
    Object.assign(copy, { minFilter: THREE.LinearFilter, generateMipmaps: false, anisotropy: 1 });
    return copy;
  };
  return Object.fromEntries(Object.entries(uniforms).map(([name, { value }]) => [name, { value: plain(value) }]));
}

// Reading one pixel back waits until all is drawn.
function seconds(renderer: THREE.WebGLRenderer, frame: () => void, target: THREE.WebGLRenderTarget): number {
  const pixel = new Uint8Array(4);
  const begin = performance.now();
  for (let k = 0; k < FRAMES; k++) frame();
  renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel);
  return (performance.now() - begin) / 1e3 / FRAMES;
}

function median(values: number[]): number {
  return values.toSorted((a, b) => a - b)[values.length >> 1];
}

function deviceOf(renderer: THREE.WebGLRenderer): string {
  const gl = renderer.getContext();
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
}
