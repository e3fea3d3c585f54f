// What is drawn, and when: only after something changed.

import * as THREE from "three";
import { byId } from "./dom";
import { Face } from "./face";
import { readMaps } from "./maps";
import { Orbit } from "./orbit";
import { Originals } from "./originals";
import { Prepass } from "./prepass";
import type { Scene } from "./scene";
import { Skin } from "./skin";
import type { State } from "./state";
import { studio } from "./studio";

/** Pixels of the page above and below the layout, for names and legend. */
const MARGIN = 72;

export class Stage {
  readonly canvas = byId<HTMLCanvasElement>("canvas");
  readonly orbit: Orbit;
  private readonly head = new THREE.Scene();
  private readonly sheet = new THREE.Scene();
  private readonly sheetCamera = new THREE.OrthographicCamera();
  private readonly wires = new THREE.MeshBasicMaterial({ wireframe: true, transparent: true, opacity: 0.16, color: 0xffffff, depthWrite: false });
  private readonly skinMesh: THREE.Mesh | null;
  private readonly wireMeshes: THREE.Mesh[] = [];
  // Revisions of the weights that were blended last.
  private blended = -1;
  private blendedOriginals = -1;
  private asked = false;

  private constructor(
    readonly scene: Scene, readonly state: State, readonly renderer: THREE.WebGLRenderer, readonly face: Face | null,
    readonly prepass: Prepass, private readonly originals: Originals | null, private readonly skin: Skin,
  ) {
    this.sheet.add(new THREE.Mesh(new THREE.PlaneGeometry().translate(0.5, 0.5, 0), skin.flat));
    this.skinMesh = face ? new THREE.Mesh(face.geometry, skin.lit) : null;
    this.orbit = new Orbit(this.canvas, face?.geometry.boundingSphere ?? new THREE.Sphere(), () => this.draw());
    if (face) this.dress(face);
    state.onChange(() => this.draw());
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  static async open(scene: Scene, state: State): Promise<Stage> {
    const canvas = byId<HTMLCanvasElement>("canvas");
    const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    renderer.toneMapping = THREE.NoToneMapping;
    renderer.shadowMap.enabled = true;
    const [maps, face] = await Promise.all([readMaps(scene), scene.mesh ? Face.read(scene.mesh) : null]);
    const prepass = new Prepass(renderer, scene, maps);
    let stage: Stage | null = null;
    const originals = scene.original ? new Originals(renderer, scene, () => stage?.draw()) : null;
    await originals?.start();
    const skin = new Skin(scene, maps, prepass, originals?.target.texture ?? null);
    stage = new Stage(scene, state, renderer, face, prepass, originals, skin);
    stage.draw();
    return stage;
  }

  get blendUniforms(): Skin["uniforms"] {
    return this.skin.uniforms;
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
    const ratio = state.exact ? 1 : Math.min(devicePixelRatio, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
    this.blend();
    this.skin.show(state, canvas.width);
    renderer.setRenderTarget(null);
    renderer.setClearColor(0x000000, 0);
    for (const mesh of this.wireMeshes) mesh.visible = state.wireframe;
    if (state.layout || !this.skinMesh) this.drawSheet(canvas.width, canvas.height);
    else this.drawHead(this.skinMesh, width / height);
    canvas.dispatchEvent(new Event("drawn"));
  }

  // Once a frame, before anything is shaded: vertices, combined weights, and the originals where they are looked at.
  private blend(): void {
    const { weights, side, view, revision } = this.state;
    if (this.blended !== revision) {
      this.face?.deform(weights);
      this.prepass.render(weights);
      this.blended = revision;
    }
    const needed = view === "error" || (side !== "compressed" && (view === "texture" || view === "change"));
    if (needed && this.blendedOriginals !== revision && this.originals?.render(weights)) this.blendedOriginals = revision;
    this.canvas.dataset.complete = String(!needed || this.blendedOriginals === revision);
  }

  private drawHead(mesh: THREE.Mesh, aspect: number): void {
    mesh.material = this.skin.material(this.state);
    this.orbit.frame(aspect);
    this.renderer.render(this.head, this.orbit.camera);
  }

  // The camera counts in pixels, so that one texel can be one pixel exactly.
  private drawSheet(width: number, height: number): void {
    const [rows, columns] = this.scene.size;
    const fit = Math.min((0.92 * width) / columns, Math.max(0.5 * height, height - 2 * MARGIN * this.renderer.getPixelRatio()) / rows);
    const scale = this.state.exact ? 1 : fit;
    const [left, bottom] = [Math.floor((width - columns * scale) / 2), Math.floor((height - rows * scale) / 2)];
    Object.assign(this.sheetCamera, { left: -left, right: width - left, bottom: -bottom, top: height - bottom, near: -1, far: 1 });
    this.sheetCamera.updateProjectionMatrix();
    this.sheet.scale.set(columns * scale, rows * scale, 1);
    this.sheet.updateMatrixWorld(true);
    this.renderer.render(this.sheet, this.sheetCamera);
  }

  private dress(face: Face): void {
    const mesh = this.skinMesh!;
    mesh.castShadow = mesh.receiveShadow = true;
    mesh.frustumCulled = false;
    this.head.add(mesh, studio(face.geometry.boundingSphere!));
    this.addWires(face);
  }

  private addWires(face: Face): void {
    const onHead = new THREE.Mesh(face.geometry, this.wires);
    onHead.frustumCulled = false;
    this.wires.polygonOffset = true;
    this.wires.polygonOffsetFactor = -1;
    const layout = new THREE.BufferGeometry();
    const uv = face.geometry.getAttribute("uv");
    const flat = Float32Array.from({ length: 3 * uv.count }, (_, k) => (k % 3 === 2 ? 0.5 : uv.array[2 * Math.floor(k / 3) + (k % 3)]));
    layout.setAttribute("position", new THREE.BufferAttribute(flat, 3));
    layout.setIndex(face.geometry.getIndex());
    const onSheet = new THREE.Mesh(layout, this.wires);
    this.head.add(onHead);
    this.sheet.add(onSheet);
    this.wireMeshes.push(onHead, onSheet);
  }
}
