// Light for skin: a soft sky, a key light that throws shadows, a cool fill, and two rims. No environment map: filtering
// one takes seconds where no GPU helps.

import * as THREE from "three";

/** Texels of a side of the shadow map; fewer where the GPU takes none so large. */
export const SHADOW_SIZE = 1024;
/** Colour, strength, and the direction that a light comes from. */
const LAMPS: [THREE.ColorRepresentation, number, [number, number, number]][] = [
  [0xd5e2ff, 0.6, [1.5, 0.15, 0.75]],
  [0xdfe8ff, 1.3, [1.1, 0.7, -1.25]],
  [0xffe3cf, 1.1, [-1.3, 0.55, -1.05]],
];

export function studio(around: THREE.Sphere, largest: number): THREE.Object3D {
  const lights = new THREE.Group().add(keyLight(around, largest), new THREE.HemisphereLight(0xe9efff, 0x5a4238, 0.85));
  for (const [colour, strength, from] of LAMPS) {
    const lamp = new THREE.DirectionalLight(colour, strength);
    lamp.position.set(...from);
    lights.add(lamp);
  }
  return lights;
}

function keyLight({ center, radius }: THREE.Sphere, largest: number): THREE.Object3D {
  const light = new THREE.DirectionalLight(0xfff0e2, 2.3);
  light.position.copy(center).add(new THREE.Vector3(-0.8, 0.85, 1.6).multiplyScalar(2 * radius));
  light.target.position.copy(center);
  light.castShadow = true;
  light.shadow.mapSize.setScalar(Math.min(SHADOW_SIZE, largest));
  light.shadow.radius = 6;
  light.shadow.normalBias = 0.012 * radius;
  light.shadow.bias = -0.0008;
  const half = 1.2 * radius;
  Object.assign(light.shadow.camera, { left: -half, right: half, top: half, bottom: -half, near: 0.5 * radius, far: 8 * radius });
  return new THREE.Group().add(light, light.target);
}
