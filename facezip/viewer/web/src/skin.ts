// The main pass: six fetches, the blend of equation (1) in encoded values, made linear last; and the views of its parts.

import * as THREE from "three";
import type { Maps } from "./maps";
import type { Prepass } from "./prepass";
import type { Scene } from "./scene";
import type { State, View } from "./state";

const VIEWS: View[] = ["texture", "weights", "differences", "change", "error", "uv"];

/** Gain of the views of small values. */
export const ERROR_RANGE = 16 / 255;
export const CHANGE_RANGE = 64 / 255;

export class Skin {
  readonly lit: THREE.MeshPhysicalMaterial;
  readonly flat: THREE.MeshBasicMaterial;
  readonly uniforms: Record<string, THREE.IUniform>;

  constructor(scene: Scene, maps: Maps, prepass: Prepass, original: THREE.Texture | null) {
    const slots = maps.differences.length;
    const [, width] = scene.size;
    this.uniforms = {
      neutralMap: { value: maps.neutral },
      originalMap: { value: original ?? maps.neutral },
      differenceScale: { value: scene.difference_scale.map((scale) => new THREE.Vector3(...scale)) },
      weightRange: { value: scene.weight_range },
      shown: { value: 0 }, slot: { value: 0 }, wipe: { value: 0 }, squares: { value: Math.max(8, width / 32) },
    };
    maps.differences.forEach((map, i) => { this.uniforms[`differenceMap${i}`] = { value: map }; });
    prepass.combined.forEach((map, layer) => { this.uniforms[`weightMap${layer}`] = { value: map }; });
    const source = fragmentSource(slots, scene.difference_zero);
    this.lit = this.prepare(new THREE.MeshPhysicalMaterial(SKIN), source);
    this.flat = this.prepare(new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, toneMapped: false }), source);
  }

  /** Follow the state; `width` is the stage's, in pixels of the device. */
  show(state: State, width: number): void {
    const { side } = state;
    this.uniforms.shown.value = VIEWS.indexOf(state.view);
    this.uniforms.slot.value = state.slot;
    this.uniforms.wipe.value = side === "compressed" ? -1 : side === "original" ? width + 1 : Math.round(state.wipe * width);
    for (const material of [this.lit, this.flat]) {
      if ("MIPMAPS" in material.defines! === state.mipmaps) continue;
      if (state.mipmaps) material.defines!.MIPMAPS = "";
      else delete material.defines!.MIPMAPS;
      material.needsUpdate = true;
    }
  }

  material(state: State): THREE.Material {
    return state.lit && state.view === "texture" && !state.layout ? this.lit : this.flat;
  }

  private prepare<M extends THREE.Material>(material: M, source: string): M {
    material.defines = { ...material.defines, USE_UV: "", MIPMAPS: "" };
    material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, this.uniforms);
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", `#include <common>\n${source}`)
        .replace("#include <map_fragment>", "diffuseColor.rgb = linearOf(encodedColour(vec2(vUv.x, 1.0 - vUv.y)));");
    };
    return material;
  }
}

const SKIN: THREE.MeshPhysicalMaterialParameters = {
  side: THREE.DoubleSide, roughness: 0.55, metalness: 0, specularIntensity: 0.5,
};

/** GLSL of the blend: one fetch of the neutral, one a difference, one a layer of combined weights. */
export function blendSource(slots: number, zero: number): string {
  const each = Array.from({ length: slots }, (_, i) => i);
  const layers = Math.ceil(slots / 4);
  return `
uniform sampler2D neutralMap, ${each.map((i) => `differenceMap${i}`).join(", ")};
uniform sampler2D ${each.slice(0, layers).map((layer) => `weightMap${layer}`).join(", ")};
uniform vec3 differenceScale[${slots}];
#ifdef MIPMAPS
#define fetch(map, at) texture(map, at)
#else
#define fetch(map, at) textureLod(map, at, 0.0)
#endif
vec3 blendOf(vec2 at) {
  vec3 colour = fetch(neutralMap, at).rgb;
${each.slice(0, layers).map((layer) => `  vec4 weights${layer} = texture(weightMap${layer}, at);`).join("\n")}
${each.map((i) => `  colour += weights${i >> 2}[${i & 3}] * differenceScale[${i}] * (fetch(differenceMap${i}, at).rgb - ${zero.toFixed(9)});`).join("\n")}
  return clamp(colour, 0.0, 1.0);
}`;
}

function fragmentSource(slots: number, zero: number): string {
  const each = Array.from({ length: slots }, (_, i) => i);
  return `${blendSource(slots, zero)}
uniform sampler2D originalMap;
uniform float weightRange, wipe, squares;
uniform int shown, slot;
vec3 linearOf(vec3 encoded) {
  return mix(encoded / 12.92, pow((encoded + 0.055) / 1.055, vec3(2.4)), step(0.04045, encoded));
}
vec3 originalOf(vec2 at) { return clamp(fetch(originalMap, at).rgb, 0.0, 1.0); }
vec3 sideOf(vec2 at) { return gl_FragCoord.x < wipe ? originalOf(at) : blendOf(at); }
vec3 storedOf(vec2 at) {
${each.map((i) => `  if (slot == ${i}) return fetch(differenceMap${i}, at).rgb;`).join("\n")}
  return vec3(0.0);
}
float weightOf(vec2 at) {
${each.map((i) => `  if (slot == ${i}) return texture(weightMap${i >> 2}, at)[${i & 3}];`).join("\n")}
  return 0.0;
}
vec3 signedColour(float value) {
  vec3 far = value < 0.0 ? vec3(0.36, 0.68, 1.0) : vec3(1.0, 0.62, 0.26);
  return mix(vec3(0.085, 0.09, 0.1), far, min(abs(value), 1.0));
}
vec3 errorColour(float value) {
  float t = clamp(value, 0.0, 1.0) * 4.0;
  vec3 low = mix(vec3(0.02, 0.02, 0.06), vec3(0.32, 0.1, 0.47), min(t, 1.0));
  vec3 middle = mix(low, vec3(0.78, 0.23, 0.38), clamp(t - 1.0, 0.0, 1.0));
  return mix(mix(middle, vec3(0.99, 0.62, 0.25), clamp(t - 2.0, 0.0, 1.0)), vec3(1.0, 0.98, 0.8), clamp(t - 3.0, 0.0, 1.0));
}
vec3 squaresOf(vec2 at) {
  vec2 cell = floor(at * squares);
  float odd = mod(cell.x + cell.y, 2.0);
  return mix(vec3(at.x, 1.0 - at.y, 0.45) * 0.75 + 0.1, vec3(0.1), 0.55 * odd);
}
vec3 encodedColour(vec2 at) {
  if (shown == 1) return signedColour(weightOf(at) / weightRange);
  if (shown == 2) return storedOf(at);
  if (shown == 3) return 0.5 + 0.5 * (sideOf(at) - fetch(neutralMap, at).rgb) / ${CHANGE_RANGE.toFixed(6)};
  if (shown == 4) {
    vec3 gap = abs(originalOf(at) - blendOf(at));
    return errorColour(max(gap.r, max(gap.g, gap.b)) / ${ERROR_RANGE.toFixed(6)});
  }
  if (shown == 5) return squaresOf(at);
  return sideOf(at);
}`;
}
