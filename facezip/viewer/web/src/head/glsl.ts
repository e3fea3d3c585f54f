// The blend of equation (1) in GLSL, for any map: one fetch of the neutral, one a difference, one a layer of combined weights.
//
// What is added are texels from 0 to 1 of colours (encoded, made linear last) and data, and slopes (x/z, y/z) of normals, which
// become unit vectors last.

import * as THREE from "three";
import { type HeadDocument, layersOf, type MapEntry, type TextureEntry } from "./document";

/**
 * `tileAt(uv)` is where a UV with v down lies on the tile; `readWeights(at)` comes once a pixel, before any map is looked at.
 * Where `mipmaps` is false, texels are taken as they are.
 */
export function weightSource({ slots }: HeadDocument): string {
  const layers = layersOf(slots);
  return `
uniform sampler2DArray weightMaps;
uniform bool mipmaps;
uniform vec2 place;
vec2 tileAt(vec2 uv) { return uv + vec2(-place.x, place.y); }
vec4 weights[${layers}];
void readWeights(vec2 at) {
${numbers(layers).map((layer) => `  weights[${layer}] = texture(weightMaps, vec3(at, ${layer}.0));`).join("\n")}
}
vec4 fetch(sampler2DArray map, vec2 at, float layer) {
  return mipmaps ? texture(map, vec3(at, layer)) : textureLod(map, vec3(at, layer), 0.0);
}`;
}

/** `NAME_neutral(at)` and `NAME_blend(at)`, of three numbers each; `NAME` is one of ours, not of a pack. */
export function mapSource(name: string, head: HeadDocument, map: MapEntry, texture: TextureEntry): string {
  const terms = numbers(head.slots).map((i) =>
    `  change += weights[${i >> 2}][${i & 3}] * ${name}_span[${i}] * (${numbersOf(map, fetched(name, i + 1))} - ${float(head.difference_zero)});`);
  return `
uniform sampler2DArray ${name}_map;
uniform vec3 ${name}_span[${head.slots}];
uniform float ${name}_gain;
vec3 ${name}_neutral(vec2 at) {
  vec3 stored = ${numbersOf(map, fetched(name, 0))};
${texture.neutral_bits === 16 ? `  stored = (256.0 * stored + ${numbersOf(map, fetched(name, head.slots + 1))}) / 257.0;` : ""}
  return ${map.encoding === "normal" ? `slopesOf(stored)` : "stored"};
}
vec3 ${name}_clipped(vec3 sum) { return clamp(sum, ${limits(head, map)}); }
vec3 ${name}_blend(vec2 at) {
  vec3 change = vec3(0.0);
${terms.join("\n")}
  return ${name}_clipped(${name}_neutral(at) + ${name}_gain * change);
}`;
}

/** What the functions of `mapSource` need. */
export const COMMON = `
vec3 slopesOf(vec3 stored) {
  vec2 across = 2.0 * stored.xy - 1.0;
  return vec3(across / max(sqrt(max(1.0 - dot(across, across), 0.0)), 1e-3), 0.0);
}
vec3 normalOf(vec3 slopes) { return normalize(vec3(slopes.xy, 1.0)); }
vec3 linearOf(vec3 encoded) {
  return mix(encoded / 12.92, pow((max(encoded, 0.0) + 0.055) / 1.055, vec3(2.4)), step(0.04045, encoded));
}`;

/** `NAME_gain` is what the map's change from its neutral is multiplied by. */
export function mapUniforms(name: string, texture: TextureEntry, texels: THREE.Texture | null): Record<string, THREE.IUniform> {
  return {
    [`${name}_gain`]: { value: 1 },
    [`${name}_map`]: { value: texels },
    [`${name}_span`]: { value: texture.difference_span.map((span) => new THREE.Vector3(...span)) },
  };
}

/** An expression of the value that texels of data or colours stand for. */
export function valueOf({ range: [low, high] }: MapEntry, texels: string): string {
  return low === 0 && high === 1 ? texels : `(${float(low)} + ${float(high - low)} * ${texels})`;
}

const numbers = (count: number) => Array.from({ length: count }, (_, i) => i);
const fetched = (name: string, layer: number) => `fetch(${name}_map, at, ${layer}.0)`;

/** A float of GLSL, which wants a point or an exponent. */
export const float = (value: number) => (Number.isInteger(value) ? value.toFixed(1) : String(value));

/** The three numbers of a texel as an image has them. */
export function numbersOf({ image_channels }: MapEntry, texel: string): string {
  if (image_channels === 1) return `${texel}.rrr`;
  return image_channels === 2 ? `vec3(${texel}.ra, 0.0)` : `${texel}.rgb`;
}

function limits({ max_slope }: HeadDocument, { encoding }: MapEntry): string {
  return encoding === "normal" ? `${float(-max_slope)}, ${float(max_slope)}` : "0.0, 1.0";
}
