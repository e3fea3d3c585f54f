// The materials of a tile: skin under light, and each map flat with the views of what it is made of. All of them can have the
// originals at the left of the wipe.

import * as THREE from "three";
import { colourOf, flatMaterial } from "./head/flat";
import { float, numbersOf } from "./head/glsl";
import type { Tile } from "./head/head";
import { rolesOf, skinMaterial } from "./head/skin";
import type { Originals } from "./originals";
import type { Scene } from "./scene";
import type { State, View } from "./state";

const FLAT_VIEWS: View[] = ["flat", "weights", "differences", "change", "error", "uv"];

/** Gain of the views of small values: parts of 1, and degrees of normals. */
export const ERROR_RANGE = 16 / 255;
export const CHANGE_RANGE = 64 / 255;
export const ANGLE_RANGE = 8;

/** What all materials share and follow the state with. */
export class Shared {
  readonly uniforms: Record<string, THREE.IUniform>;

  constructor(scene: Scene) {
    this.uniforms = {
      shown: { value: 0 }, slot: { value: 0 }, wipe: { value: -1 }, clay: { value: false }, mipmaps: { value: true },
      weightRange: { value: scene.weight_range }, squares: { value: Math.max(8, scene.tiles[0].textures[0].size[1] / 32) },
    };
  }

  /** Follow the state; `width` is the stage's, in pixels of the device. */
  show(state: State, width: number): void {
    const { side } = state;
    const wipe = side === "compressed" ? -1 : side === "original" ? width + 1 : Math.round(state.wipe * width);
    const values = { shown: Math.max(0, FLAT_VIEWS.indexOf(state.view)), slot: state.slot, wipe, clay: state.view === "clay", mipmaps: state.mipmaps };
    for (const [name, value] of Object.entries(values)) this.uniforms[name].value = value;
  }
}

export class Looks {
  readonly lit: THREE.Material;
  /** One a map. */
  readonly flat: THREE.Material[];

  constructor(scene: Scene, tile: Tile, originals: Originals | null, shared: Shared) {
    const roles = rolesOf(scene);
    const { source, uniforms } = sided(tile, roles, originals, shared);
    const lookups = Object.fromEntries(Object.entries(roles).map(([role, m]) => [role, { map: scene.maps[m], call: `${role}_seen` }]));
    if (lookups.albedo) lookups.albedo.call = "albedo_or_clay";
    this.lit = skinMaterial(lookups, source + (lookups.albedo ? CLAY : ""), uniforms);
    this.flat = scene.maps.map((_, m) => viewsOf(scene, m, sided(tile, { chosen: m }, originals, shared)));
  }
}

// What shapes and gloss look like without colours.
const CLAY = `
uniform bool clay;
vec3 albedo_or_clay(vec2 at) { return clay ? vec3(0.62) : albedo_seen(at); }`;

interface Shader { source: string; uniforms: Record<string, THREE.IUniform> }

/** The blends of some maps, and `NAME_seen(at)`, which is the original at the left of the wipe. */
function sided(tile: Tile, maps: Record<string, number>, originals: Originals | null, shared: Shared): Shader {
  const { source, uniforms } = tile.shader(maps);
  const sides = Object.entries(maps).map(([name, m]) => {
    if (originals) uniforms[`${name}_scans`] = { value: originals.texture(tile.number, m) };
    return originals ? `
uniform sampler2D ${name}_scans;
vec3 ${name}_original(vec2 at) { return ${name}_clipped((mipmaps ? texture(${name}_scans, at) : textureLod(${name}_scans, at, 0.0)).rgb); }
vec3 ${name}_seen(vec2 at) { return gl_FragCoord.x < wipe ? ${name}_original(at) : ${name}_blend(at); }` : `
#define ${name}_original ${name}_blend
#define ${name}_seen ${name}_blend`;
  });
  return { source: [source, "uniform float wipe;", ...sides].join("\n"), uniforms: { ...uniforms, ...shared.uniforms } };
}

function viewsOf(scene: Scene, m: number, { source, uniforms }: Shader): THREE.ShaderMaterial {
  const normal = scene.maps[m].encoding === "normal";
  const slots = Array.from({ length: scene.slots }, (_, i) => i);
  return flatMaterial(`
uniform float weightRange, squares;
uniform int shown, slot;
${source}
vec3 shownOf(vec3 map) { return ${colourOf(scene.maps[m], "map")}; }
vec3 storedOf(vec4 texel) { return ${normal ? `vec3(texel.rg, ${float(scene.difference_zero)})` : numbersOf(scene.maps[m], "texel")}; }
float weightOf() {
${slots.map((i) => `  if (slot == ${i}) return weights[${i >> 2}][${i & 3}];`).join("\n")}
  return 0.0;
}
float errorOf(vec3 one, vec3 other) {
${normal
    ? `  return degrees(2.0 * asin(min(1.0, 0.5 * length(normalOf(one) - normalOf(other))))) / ${float(ANGLE_RANGE)};`
    : `  vec3 gap = abs(one - other);\n  return max(gap.r, max(gap.g, gap.b)) / ${float(ERROR_RANGE)};`}
}
${SCALES}
vec3 colourAt(vec2 at) {
  if (shown == 1) return signedColour(weightOf() / weightRange);
  if (shown == 2) return storedOf(fetch(chosen_map, at, float(slot + 1)));
  if (shown == 3) return 0.5 + 0.5 * (shownOf(chosen_seen(at)) - shownOf(chosen_neutral(at))) / ${float(CHANGE_RANGE)};
  if (shown == 4) return errorColour(errorOf(chosen_original(at), chosen_blend(at)));
  if (shown == 5) return squaresOf(at);
  return shownOf(chosen_seen(at));
}`, uniforms);
}

const SCALES = `
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
}`;
