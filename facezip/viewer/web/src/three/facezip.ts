// A FaceZip head in a scene of three.js: morph targets move it, its material blends its maps under the same weights.

import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import type { HeadDocument } from "../head/document";
import { readTile, type TileContent } from "../head/head";
import { type Exported, readExported } from "./exported";
import { Part } from "./part";

type Numbers = Record<string, number>;

/** `url` is that of the folder that `facezip export --to three` wrote; `scale` makes its textures smaller, as 0.5. */
export async function loadFaceZip(url: string | URL, { scale = 1 }: { scale?: number } = {}): Promise<FaceZipHead> {
  const base = new URL(String(url).replace(/\/?$/, "/"), document.baseURI).href;
  const exported = await readExported(base);
  const [{ scene }, ...contents] = await Promise.all([
    new GLTFLoader().loadAsync(`${base}head.glb`),
    ...exported.document.tiles.map((_, t) => readTile(exported.document, exported.assets, t, scale)),
  ]);
  return new FaceZipHead(exported, scene, contents);
}

export class FaceZipHead extends THREE.Group {
  /** Names, in the order of the pack. */
  readonly expressions: readonly string[];
  /** What changes are multiplied by, 1 at first: those of a map, of an expression's textures, of a region of the face. */
  readonly gains: { readonly maps: Numbers; readonly expressions: Numbers; readonly regions: Numbers };
  private readonly document: HeadDocument;
  private readonly parts: Part[];
  private readonly beta: Float32Array;
  private renderer: THREE.WebGLRenderer | null = null;
  private blended = "";

  /** @internal */
  constructor({ document, materials }: Exported, scene: THREE.Object3D, contents: TileContent[]) {
    super();
    this.document = document;
    this.expressions = document.expressions;
    this.beta = new Float32Array(document.expressions.length);
    this.gains = { maps: ones(document.maps.map(({ name }) => name)), expressions: ones(document.expressions), regions: ones(document.regions ?? []) };
    const meshes: THREE.Mesh[] = [];
    scene.traverse((found) => { if (found instanceof THREE.Mesh) meshes.push(found); });
    // No face may lie on a tile.
    this.parts = meshes.map((mesh) => {
      const t = materials.indexOf((mesh.material as THREE.Material).name);
      return new Part(document, t, mesh, contents[t]);
    });
    for (const mesh of meshes) mesh.onBeforeRender = (renderer) => this.blend(renderer);
    this.add(scene);
  }

  /** The skin of each tile that has faces. */
  get materials(): THREE.MeshPhysicalMaterial[] {
    return this.parts.map(({ skin }) => skin);
  }

  /** The weights of all expressions. */
  get weights(): Readonly<Numbers> {
    return Object.fromEntries(this.expressions.map((name, n) => [name, this.beta[n]]));
  }

  /** Set weights by name, as in `{ smile: 0.5 }`; all others stay. */
  set(weights: Readonly<Numbers>): void {
    const places = Object.entries(weights).map(([name, weight]) => [placeOf(name, this.expressions, "expression"), weight]);
    const wrong = Object.entries(weights).find(([, weight]) => !Number.isFinite(weight));
    if (wrong) throw new Error(`the weight of '${wrong[0]}' is ${wrong[1]}, not a number`);
    for (const [n, weight] of places) {
      this.beta[n] = weight;
      for (const { mesh } of this.parts) mesh.morphTargetInfluences![n] = weight;
    }
  }

  /** One map as it is, without light; `null` is the skin again. */
  show(map: string | null): void {
    const m = map === null ? null : placeOf(map, this.document.maps.map(({ name }) => name), "map");
    for (const part of this.parts) part.show(m);
  }

  /** Give back what the GPU has of the head. */
  dispose(): void {
    for (const part of this.parts) part.dispose();
  }

  // Before each part is drawn; the weights are combined where they have changed.
  private blend(renderer: THREE.WebGLRenderer): void {
    if (this.renderer !== renderer) this.upload(renderer);
    const { gains, document } = this;
    const weights = this.beta.map((beta, n) => beta * gains.expressions[this.expressions[n]]);
    const left = Float32Array.from(document.regions ?? [], (name) => gains.regions[name]);
    const wanted = `${weights};${left}`;
    for (const part of this.parts) {
      if (wanted !== this.blended) part.blend(weights, left);
      part.turn(document.maps.map(({ name }) => gains.maps[name]));
    }
    this.blended = wanted;
  }

  private upload(renderer: THREE.WebGLRenderer): void {
    if (!("isWebGLRenderer" in renderer)) throw new Error("FaceZip draws with three's WebGLRenderer; WebGPURenderer does not know its shaders");
    if (this.renderer) throw new Error("a FaceZip head belongs to the renderer that drew it first; load it again for another");
    const { maxTextureSize } = renderer.capabilities;
    const side = Math.max(...this.parts.map((part) => part.side));
    if (side > maxTextureSize) throw new Error(`this GPU takes textures of up to ${maxTextureSize} texels, the head has ${side}; load it with { scale: ${maxTextureSize / side} }`);
    for (const part of this.parts) part.upload(renderer);
    this.renderer = renderer;
    renderer.domElement.addEventListener("webglcontextrestored", () => console.error("FaceZip: the GPU has lost the textures of a head; load it again"));
  }
}

/** A name that is not there cannot be added: writing to it is a TypeError. */
const ones = (names: readonly string[]): Numbers => Object.seal(Object.fromEntries(names.map((name) => [name, 1])));

function placeOf(name: string, names: readonly string[], what: string): number {
  const n = names.indexOf(name);
  if (n < 0) throw new Error(`this head has no ${what} '${name}'; it has ${names.join(", ")}`);
  return n;
}
