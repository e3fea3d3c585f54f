// A map as it is, without light, or what else can be shown at a place of it.

import * as THREE from "three";
import type { MapEntry } from "./document";
import { COMMON } from "./glsl";

/** An expression of a value as a colour: as it is encoded, normals as (n + 1) / 2, data from black to white over its range. */
export function colourOf({ encoding, channels }: MapEntry, value: string): string {
  if (encoding === "normal") return `0.5 + 0.5 * normalOf(${value})`;
  return channels === 2 ? `vec3(${value}.rg, 0.0)` : value;
}

/** `source` has `vec3 colourAt(vec2 at)`, `readWeights` and what they need. */
export function flatMaterial(source: string, uniforms: Record<string, THREE.IUniform>): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3, side: THREE.DoubleSide, toneMapped: false, uniforms,
    vertexShader: `
#include <common>
#include <morphtarget_pars_vertex>
#include <clipping_planes_pars_vertex>
out vec2 face;
void main() {
  face = uv;
  #include <morphinstance_vertex>
  #include <begin_vertex>
  #include <morphtarget_vertex>
  #include <project_vertex>
  #include <clipping_planes_vertex>
}`,
    fragmentShader: `
in vec2 face;
out vec4 colour;
${COMMON}${source}
void main() {
  vec2 at = tileAt(face);
  readWeights(at);
  colour = vec4(colourAt(at), 1.0);
}`,
  });
}
