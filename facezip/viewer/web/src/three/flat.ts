// One map as it is, without light: colours as they are encoded, normals as (n + 1) / 2, data from black to white over its range.

import * as THREE from "three";
import type { MapEntry } from "../head/document";
import { COMMON } from "../head/glsl";

/** `source` has the function `shown_blend` and what it needs. */
export function flatMaterial({ encoding, channels }: MapEntry, source: string, uniforms: Record<string, THREE.IUniform>): THREE.ShaderMaterial {
  const value = encoding === "normal" ? "0.5 + 0.5 * normalOf(map)" : channels === 2 ? "vec3(map.rg, 0.0)" : "map";
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
  vec3 map = shown_blend(at);
  colour = vec4(${value}, 1.0);
}`,
  });
}
