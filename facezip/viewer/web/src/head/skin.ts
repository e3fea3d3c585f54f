// Skin under light: three's physical material (GGX over Lambert), with whatever maps there are blended into it.

import * as THREE from "three";
import type { HeadDocument, MapEntry } from "./document";
import { COMMON, valueOf } from "./glsl";

/** The maps that light meets, called and stored as every renderer takes them. */
export const ROLES = { albedo: "srgb", normal: "normal", roughness: "data", specular: "data", cavity: "data" } as const;
export type Role = keyof typeof ROLES;

/** Of skin that is an albedo alone: little gloss, which nothing breaks up. */
const MATTE: THREE.MeshPhysicalMaterialParameters = { roughness: 0.55, specularIntensity: 0.5 };
/** Of skin with any other map, where none says; the reflectance at normal incidence is 0.08 · specular. */
const ROUGHNESS = 0.48;
const SPECULAR = 0.42;
const FLESH = new THREE.Color(0.6, 0.4, 0.33);
// How much of what a cavity takes from the highlight it takes from the diffuse light as well, which scatters in the skin.
const DIFFUSE_CAVITY = 0.3;

/** Which of the maps are which roles. */
export function rolesOf({ maps }: HeadDocument): Record<string, number> {
  const found = Object.entries(ROLES).map(([role, encoding]) => [role, maps.findIndex((map) => map.name === role && map.encoding === encoding)] as const);
  return Object.fromEntries(found.filter(([, m]) => m !== -1));
}

/** A map, and the function `f(at)` of the shader that gives its texels or slopes. */
export interface Lookup { map: MapEntry; call: string }
export type Lookups = Partial<Record<Role, Lookup>>;

/** `source` has the functions of `lookups`, `readWeights` and their uniforms. The attribute `uv` has v down. */
export function skinMaterial(lookups: Lookups, source: string, uniforms: Record<string, THREE.IUniform>): THREE.MeshPhysicalMaterial {
  const { albedo, ...relief } = lookups;
  const gloss = Object.keys(relief).length ? { roughness: ROUGHNESS } : MATTE;
  const material = new THREE.MeshPhysicalMaterial({ side: THREE.DoubleSide, metalness: 0, ...gloss, ...(albedo ? {} : { color: FLESH }) });
  const chunks = chunksOf(lookups, source);
  material.defines = { ...material.defines, USE_UV: "" };
  material.customProgramCacheKey = () => JSON.stringify(chunks);
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    for (const [name, text] of Object.entries(chunks)) {
      shader.fragmentShader = shader.fragmentShader.replace(`#include <${name}>`, `#include <${name}>\n${text}`);
    }
  };
  return material;
}

/** What comes after which of three's chunks. */
function chunksOf({ albedo, normal, roughness, specular, cavity }: Lookups, source: string): Record<string, string> {
  const value = ({ map, call }: Lookup) => valueOf(map, `${call}(skinAt)`);
  const share = (lookup: Lookup) => `clamp(${value(lookup)}.r, 0.0, 1.0)`;
  return {
    common: `${COMMON}${source}${FRAME}`,
    map_fragment: `
vec2 skinAt = tileAt(vUv);
readWeights(skinAt);
${albedo ? `diffuseColor.rgb *= linearOf(${value(albedo)});` : ""}`,
    ...(roughness && { roughnessmap_fragment: `roughnessFactor = ${share(roughness)};` }),
    ...(normal && { normal_fragment_maps: `normal = normalize(skinFrame(-vViewPosition, normal, vec2(vUv.x, -vUv.y)) * normalOf(${normal.call}(skinAt)));` }),
    ...((normal || roughness || specular || cavity) && { lights_physical_fragment: `
material.specularColor = material.specularColorBlended = vec3(0.08 * ${specular ? share(specular) : SPECULAR});
material.specularF90 = 1.0;` }),
    ...(cavity && { lights_fragment_end: `
float cavity = ${share(cavity)}, fill = mix(1.0, cavity, ${DIFFUSE_CAVITY});
reflectedLight.directSpecular *= cavity;
reflectedLight.indirectSpecular *= cavity;
reflectedLight.directDiffuse *= fill;
reflectedLight.indirectDiffuse *= fill;` }),
  };
}

// The frame of tangent space, x along u and y on the side of v, out of derivatives over the screen: no attribute has to morph.
const FRAME = `
mat3 skinFrame(vec3 position, vec3 normal, vec2 uv) {
  vec3 right = dFdx(position), up = dFdy(position);
  vec2 uvRight = dFdx(uv), uvUp = dFdy(uv);
  float turn = sign(uvRight.x * uvUp.y - uvUp.x * uvRight.y);
  vec3 alongU = turn * (uvUp.y * right - uvRight.y * up), alongV = turn * (uvRight.x * up - uvUp.x * right);
  vec3 across = alongU - dot(alongU, normal) * normal;
  vec3 tangent = across * inversesqrt(max(dot(across, across), 1e-30));
  vec3 bitangent = cross(normal, tangent);
  return mat3(tangent, dot(bitangent, alongV) < 0.0 ? -bitangent : bitangent, normal);
}`;
