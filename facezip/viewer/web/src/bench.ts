// Frame time of the paper's blend beside that of fetching every texture, in turn, on this machine's GPU.

import * as THREE from "three";
import type { FullScreenQuad } from "three/addons/postprocessing/Pass.js";
import { COMMON } from "./head/glsl";
import { drawInto, quad } from "./head/quad";
import { layersOf } from "./head/document";
import { emptyArray } from "./head/textures";
import type { Stage } from "./stage";

const FRAMES = 4;
const ROUNDS = 7;
const LARGEST = 1024;
// As layers of 1024² they take 270 MB.
const MOST = 64;

export interface FrameTimes {
  /** The map that was measured, on the first tile. */
  map: string;
  size: number; expressions: number; fetches: number; facezip_ms: number; all_ms: number; ratio: number; rounds: number; frames: number; device: string;
}

/** Both draw a full square of pixels with every expression at once; the median of the rounds' times and ratios. */
export function measureFrames(stage: Stage): FrameTimes {
  const { renderer, scene, head } = stage;
  const [{ size: sides, neutral_bits }] = scene.tiles[0].textures;
  const size = Math.min(LARGEST, Math.max(...sides));
  const all = scene.expressions.length;
  const count = Math.min(MOST, all);
  const out = new THREE.WebGLRenderTarget(size, size, { depthBuffer: false });
  const weights = Float32Array.from({ length: all }, (_, n) => (n < count ? 1 / count : 0));
  const [tile] = head.tiles;
  const { source, uniforms } = tile.shader({ first: 0 });
  const texels = bilinear(renderer, tile.textures[0]);
  const ours = quad(`${COMMON}${source}
out vec4 colour;
void main() {
  readWeights(at);
  colour = vec4(first_blend(at), 1.0);
}`, { ...uniforms, mipmaps: { value: false }, first_map: { value: texels } });
  const blend = (betas: Float32Array) => tile.prepass.render(betas);
  const every = everyTexture(stage, blend, ours, size, count);
  const draw = (one: FullScreenQuad) => drawInto(renderer, out, 0, () => one.render(renderer));
  const facezip = () => {
    blend(weights);
    draw(ours);
  };
  const textures = () => draw(every.quad);
  for (const once of [facezip, textures]) seconds(renderer, once, out);
  const rounds = Array.from({ length: ROUNDS }, () => [seconds(renderer, facezip, out), seconds(renderer, textures, out)]);
  for (const made of [out, every.target, texels]) made.dispose();
  stage.invalidate();
  return {
    size, expressions: count, fetches: 1 + scene.slots + layersOf(scene.slots) + Number(neutral_bits === 16), rounds: ROUNDS, frames: FRAMES,
    device: deviceOf(renderer), map: scene.maps[0].name,
    facezip_ms: 1e3 * median(rounds.map(([a]) => a)), all_ms: 1e3 * median(rounds.map(([, b]) => b)),
    ratio: median(rounds.map(([a, b]) => a / b)),
  };
}

// The textures of all expressions as layers of one array: more than a shader may have by name.
function everyTexture({ renderer, scene }: Stage, blend: (betas: Float32Array) => void, ours: FullScreenQuad, size: number, count: number) {
  const target = new THREE.WebGLArrayRenderTarget(size, size, count + 1, { depthBuffer: false, minFilter: THREE.LinearFilter });
  for (let layer = 0; layer <= count; layer++) {
    blend(Float32Array.from({ length: scene.expressions.length }, (_, n) => Number(n === layer - 1)));
    drawInto(renderer, target, layer, () => ours.render(renderer));
  }
  const one = quad(`
uniform sampler2DArray textures;
uniform float weights[${count}];
out vec4 colour;
void main() {
  vec3 neutral = texture(textures, vec3(at, 0.0)).rgb, sum = neutral;
  for (int n = 0; n < ${count}; n++) sum += weights[n] * (texture(textures, vec3(at, float(n + 1))).rgb - neutral);
  colour = vec4(clamp(sum, 0.0, 1.0), 1.0);
}`, { textures: { value: target.texture }, weights: { value: new Array(count).fill(1 / count) } });
  return { target, quad: one };
}

// Both sides are filtered alike: bilinear, without mip-maps.
function bilinear(renderer: THREE.WebGLRenderer, texture: THREE.DataArrayTexture): THREE.DataArrayTexture {
  const { width, height, depth } = texture.image;
  const copy = emptyArray(width, height, depth, { format: texture.format, minFilter: THREE.LinearFilter, magFilter: THREE.LinearFilter });
  renderer.copyTextureToTexture(texture, copy);
  return copy;
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
