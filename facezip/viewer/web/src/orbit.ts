// The camera around the head: pointer, wheel, fingers, and arrow keys.

import * as THREE from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

const FIELD = 26;
const STEP = Math.PI / 36;

export class Orbit {
  readonly camera = new THREE.PerspectiveCamera(FIELD);
  private readonly controls: OrbitControls;

  constructor(canvas: HTMLCanvasElement, private readonly around: THREE.Sphere, moved: () => void) {
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.minDistance = 1.2 * around.radius;
    this.controls.maxDistance = 14 * around.radius;
    this.reset();
    this.controls.addEventListener("change", moved);
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  reset(): void {
    const { center, radius } = this.around;
    const distance = (1.1 * radius) / Math.sin((FIELD / 2) * (Math.PI / 180));
    this.controls.target.copy(center);
    this.camera.position.copy(center).add(new THREE.Vector3(0.22, 0.06, 0.97).setLength(distance));
    this.camera.near = 0.05 * radius;
    this.camera.far = 30 * radius;
    this.controls.update();
  }

  /** Fit the stage: where it is higher than wide, the field of view is that of its width. */
  frame(aspect: number): void {
    const half = Math.tan((FIELD / 2) * (Math.PI / 180)) / Math.min(1, aspect);
    this.camera.fov = 2 * Math.atan(half) * (180 / Math.PI);
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
  }

  private key(event: KeyboardEvent): void {
    const turns: Record<string, [number, number, number]> = {
      ArrowLeft: [-STEP, 0, 1], ArrowRight: [STEP, 0, 1], ArrowUp: [0, -STEP, 1], ArrowDown: [0, STEP, 1],
      "+": [0, 0, 0.92], "=": [0, 0, 0.92], "-": [0, 0, 1 / 0.92],
    };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Home") this.reset();
    else if (turns[event.key]) this.turn(...turns[event.key]);
    else return;
    event.preventDefault();
  }

  private turn(azimuth: number, polar: number, zoom: number): void {
    const { target } = this.controls;
    const place = new THREE.Spherical().setFromVector3(this.camera.position.clone().sub(target));
    place.theta += azimuth;
    place.phi += polar;
    place.radius *= zoom;
    this.camera.position.copy(target).add(new THREE.Vector3().setFromSpherical(place.makeSafe()));
    this.controls.update();
  }
}
