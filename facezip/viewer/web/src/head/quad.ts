// A fragment shader over every pixel of a render target.

import * as THREE from "three";
import { FullScreenQuad } from "three/addons/postprocessing/Pass.js";

const VERTEX = `
in vec3 position;
out vec2 at;
void main() { at = 0.5 + 0.5 * position.xy; gl_Position = vec4(position.xy, 0.0, 1.0); }`;
const HEAD = `
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
in vec2 at;`;

export function quad(
  fragment: string, uniforms: Record<string, THREE.IUniform>, options: Partial<THREE.ShaderMaterialParameters> = {}
): FullScreenQuad {
  return new FullScreenQuad(new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3, vertexShader: VERTEX, fragmentShader: HEAD + fragment, uniforms, depthTest: false, depthWrite: false, ...options,
  }));
}

/** Draw into a target, or a layer of it, and leave the renderer as it was. */
export function drawInto(renderer: THREE.WebGLRenderer, target: THREE.WebGLRenderTarget, layer: number, draw: () => void): void {
  const before = [renderer.getRenderTarget(), renderer.getActiveCubeFace(), renderer.getActiveMipmapLevel()] as const;
  const { enabled } = renderer.xr;
  // A headset's cameras are not for this.
  renderer.xr.enabled = false;
  renderer.setRenderTarget(target, layer);
  draw();
  renderer.setRenderTarget(...before);
  renderer.xr.enabled = enabled;
}
