// What is drawn, and when: only after something changed.

import * as THREE from "three";
import { byId } from "./dom";
import { Head } from "./head/head";
import { rolesOf } from "./head/skin";
import { Looks, Shared } from "./looks";
import { Orbit } from "./orbit";
import { Originals } from "./originals";
import { assets, type Scene } from "./scene";
import { Sheet } from "./sheet";
import { COMPARABLE, type State } from "./state";
import { studio } from "./studio";

export class Stage {
  readonly canvas = byId<HTMLCanvasElement>("canvas");
  readonly orbit: Orbit;
  readonly sheet: Sheet;
  private readonly world = new THREE.Scene();
  private readonly shared: Shared;
  private readonly looks: Looks[];
  private readonly wires = new THREE.MeshBasicMaterial({ wireframe: true, transparent: true, opacity: 0.16, color: 0xffffff, depthWrite: false });
  private readonly mesh: THREE.Mesh | null;
  // Revision of the weights that were blended last.
  private blended = -1;
  private asked = false;

  private constructor(readonly scene: Scene, readonly state: State, readonly renderer: THREE.WebGLRenderer, readonly head: Head, readonly originals: Originals | null) {
    const { face } = head;
    this.shared = new Shared(scene);
    this.looks = head.tiles.map((tile) => new Looks(scene, tile, originals, this.shared));
    this.sheet = new Sheet(head, this.wires);
    this.mesh = face ? new THREE.Mesh(face.geometry) : null;
    this.orbit = new Orbit(this.canvas, face?.around ?? new THREE.Sphere(), () => this.draw());
    if (this.mesh) this.dress(this.mesh, face!.around);
    state.onChange(() => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  static async open(scene: Scene, state: State): Promise<Stage> {
    const renderer = new THREE.WebGLRenderer({ canvas: byId<HTMLCanvasElement>("canvas"), antialias: true, alpha: true });
    renderer.debug.onShaderError = () => renderer.domElement.dispatchEvent(new Event("shaderrefused"));
    renderer.toneMapping = THREE.NoToneMapping;
    renderer.shadowMap.enabled = true;
    const head = await Head.open(renderer, scene, assets);
    let stage: Stage | null = null;
    const originals = scene.originals ? Originals.of(renderer, head, assets, () => stage?.draw()) : null;
    stage = new Stage(scene, state, renderer, head, originals);
    stage.draw();
    return stage;
  }

  /** Draw before the next frame is shown. */
  draw(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.drawNow();
    });
  }

  /** Blend again, whatever was blended last. */
  invalidate(): void {
    this.blended = -1;
    this.draw();
  }

  private drawNow(): void {
    const { renderer, state, canvas } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    renderer.setPixelRatio(state.exact ? 1 : Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    this.blend();
    this.shared.show(state, canvas.width);
    renderer.setRenderTarget(null);
    renderer.setClearColor(0x000000, 0);
    if (state.layout || !this.mesh) this.sheet.draw(renderer, this.looks.map(({ flat }) => flat[state.map]), state);
    else this.drawMesh(this.mesh, width / height);
    canvas.dispatchEvent(new Event("drawn"));
  }

  // The originals only where they are looked at.
  private blend(): void {
    const { weights, side, view, map, lit, revision } = this.state;
    if (this.blended !== revision) {
      this.head.blend(weights);
      this.blended = revision;
    }
    const needed = view === "error" || (side !== "compressed" && COMPARABLE.includes(view));
    const maps = lit ? Object.values(rolesOf(this.scene)) : [map];
    const complete = !needed || !this.originals || this.originals.render(weights, revision, maps);
    this.canvas.dataset.complete = String(complete);
  }

  private drawMesh(mesh: THREE.Mesh, aspect: number): void {
    const { lit, map, wireframe } = this.state;
    mesh.material = this.looks.map((looks) => (lit ? looks.lit : looks.flat[map]));
    mesh.children[0].visible = wireframe;
    this.orbit.frame(aspect);
    this.renderer.render(this.world, this.orbit.camera);
  }

  private dress(mesh: THREE.Mesh, around: THREE.Sphere): void {
    const wires = new THREE.Mesh(mesh.geometry, this.wires);
    this.wires.polygonOffset = true;
    this.wires.polygonOffsetFactor = -1;
    mesh.castShadow = mesh.receiveShadow = true;
    mesh.frustumCulled = wires.frustumCulled = false;
    mesh.add(wires);
    this.world.add(mesh, studio(around, this.renderer.capabilities.maxTextureSize));
  }
}
