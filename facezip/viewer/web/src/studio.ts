// Light for skin: a soft studio around the head as environment, and one key light that throws shadows.

import * as THREE from "three";

/** Panels of light: colour, radiance, size, and where they hang, in radii of the head. */
const PANELS: [THREE.ColorRepresentation, number, [number, number], [number, number, number]][] = [
  [0xfff1e4, 7, [3.2, 3.2], [-3.2, 2.6, 3.4]],
  [0xdfe9ff, 2.6, [3.6, 4.5], [4.4, 0.4, 1.6]],
  [0xe6edff, 9, [1.2, 4], [3.2, 1.6, -3.6]],
  [0xffe9d8, 5, [1.2, 4], [-3.6, 1.2, -3.2]],
  [0xffffff, 1.6, [6, 6], [0, 5.5, 0]],
  [0xffe2cf, 0.5, [6, 6], [0, -5, 1]],
];

export function studioEnvironment(renderer: THREE.WebGLRenderer): THREE.Texture {
  const room = new THREE.Scene();
  room.background = new THREE.Color(0x0b0c0e);
  for (const [colour, radiance, size, place] of PANELS) {
    const material = new THREE.MeshBasicMaterial({ color: new THREE.Color(colour).multiplyScalar(radiance), side: THREE.DoubleSide });
    const panel = new THREE.Mesh(new THREE.PlaneGeometry(...size), material);
    panel.position.set(...place);
    panel.lookAt(0, 0, 0);
    room.add(panel);
  }
  const generator = new THREE.PMREMGenerator(renderer);
  const { texture } = generator.fromScene(room, 0.03);
  generator.dispose();
  return texture;
}

export function keyLight(around: THREE.Sphere): THREE.DirectionalLight {
  const light = new THREE.DirectionalLight(0xfff3e8, 1.5);
  const { center, radius } = around;
  light.position.copy(center).add(new THREE.Vector3(-0.75, 0.95, 1.6).multiplyScalar(2 * radius));
  light.target.position.copy(center);
  light.castShadow = true;
  light.shadow.mapSize.set(1024, 1024);
  light.shadow.radius = 5;
  light.shadow.normalBias = 0.012 * radius;
  light.shadow.bias = -0.0008;
  const { camera } = light.shadow;
  Object.assign(camera, { left: -1.2 * radius, right: 1.2 * radius, top: 1.2 * radius, bottom: -1.2 * radius, near: 0.5 * radius, far: 8 * radius });
  return light;
}
