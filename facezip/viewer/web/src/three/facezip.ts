// A FaceZip head in a scene of three.js: morph targets move it, its material blends its maps under the same weights.

import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import type { HeadDocument } from "../head/document";
import { readTile, shaderOf, Tile, type TileContent } from "../head/head";
import { rolesOf, skinMaterial } from "../head/skin";
import { type Exported, readExported } from "./exported";
import { flatMaterial } from "./flat";

type Numbers = Record<string, number>;
type Uniforms = Record<string, THREE.IUniform>;

/** A tile of the head: what it is made of until a GPU has it, its mesh, and the uniforms of its materials. */
interface Part { content: TileContent | null; mesh: THREE.Mesh; tile: Tile | null; skin: THREE.MeshPhysicalMaterial; materials: Uniforms[] }

/** `url` is of the folder that `facezip export --to three` wrote; `scale` makes its textures smaller, as 0.5. */
export async function loadFaceZip(url: string | URL, { scale = 1 }: { scale?: number } = {}): Promise<FaceZipHead> {
  const base = new URL(`${String(url).replace(/\/?$/, "/")}`, globalThis.document?.baseURI).href;
  const exported = await readExported(base);
  const [{ scene }, ...contents] = await Promise.all([
    new GLTFLoader().loadAsync(`${base}head.glb`), ...exported.document.tiles.map((_, t) => readTile(exported.document, exported.assets, t, scale)),
  ]);
  return new FaceZipHead(exported, scene, contents);
}

export class FaceZipHead extends THREE.Group {
  /** Names, in the order of the pack. */
  readonly expressions: readonly string[];
  /** What changes are multiplied by, 1 at first: of a map, of an expression's textures, of a region of the face. */
  readonly gains: { maps: Numbers; expressions: Numbers; regions: Numbers };
  private readonly document: HeadDocument;
  private readonly parts: Part[];
  private readonly beta: Float32Array;
  private renderer: THREE.WebGLRenderer | null = null;
  private blended = "";

  constructor({ document, materials }: Exported, scene: THREE.Object3D, contents: TileContent[]) {
    super();
    this.document = document;
    this.expressions = document.expressions;
    const ones = (names: readonly string[]) => Object.seal(Object.fromEntries(names.map((name) => [name, 1])));
    this.gains = Object.freeze({ maps: ones(document.maps.map(({ name }) => name)), expressions: ones(document.expressions), regions: ones(document.regions ?? []) });
    this.beta = new Float32Array(document.expressions.length);
    const meshes: THREE.Mesh[] = [];
    scene.traverse((found) => { if (found instanceof THREE.Mesh) meshes.push(found); });
    // No face may lie on a tile.
    this.parts = meshes.map((mesh) => {
      const t = materials.indexOf((mesh.material as THREE.Material).name);
      return this.partOf(mesh, t, contents[t]);
    });
    this.add(scene);
  }

  /** The skin of each tile that has faces. */
  get materials(): THREE.MeshPhysicalMaterial[] {
    return this.parts.map(({ skin }) => skin);
  }

  /** Weights of all expressions. */
  get weights(): Readonly<Numbers> {
    return Object.fromEntries(this.expressions.map((name, n) => [name, this.beta[n]]));
  }

  /** Set weights by name, as in `{ smile: 0.5 }`; all others stay. */
  set(weights: Readonly<Numbers>): void {
    const places = Object.entries(weights).map(([name, weight]) => {
      const n = this.expressions.indexOf(name);
      if (n < 0) throw new Error(`this head has no expression '${name}'; it has ${this.expressions.join(", ")}`);
      if (!Number.isFinite(weight)) throw new Error(`the weight of '${name}' is ${weight}, not a number`);
      return [n, weight];
    });
    for (const [n, weight] of places) {
      this.beta[n] = weight;
      for (const { mesh } of this.parts) mesh.morphTargetInfluences![mesh.morphTargetDictionary![this.expressions[n]]] = weight;
    }
  }

  /** One map as it is, without light; `null` is the skin again. */
  show(map: string | null): void {
    const m = this.document.maps.findIndex(({ name }) => name === map);
    if (map !== null && m < 0) throw new Error(`this head has no map '${map}'; it has ${Object.keys(this.gains.maps).join(", ")}`);
    this.parts.forEach((part) => {
      if (part.mesh.material !== part.skin) this.forget(part);
      part.mesh.material = map === null ? part.skin : this.flatOf(part, m);
    });
  }

  dispose(): void {
    for (const part of this.parts) {
      if (part.mesh.material !== part.skin) this.forget(part);
      part.skin.dispose();
      part.mesh.geometry.dispose();
      part.tile?.prepass.dispose();
      for (const texture of part.tile?.textures ?? []) texture.dispose();
      for (const image of part.content?.images.flat() ?? []) image.close();
    }
  }

  private partOf(mesh: THREE.Mesh, t: number, content: TileContent): Part {
    const { document } = this;
    const roles = rolesOf(document);
    const { source, uniforms } = shaderOf(document, t, roles);
    const lookups = Object.fromEntries(Object.entries(roles).map(([role, m]) => [role, { map: document.maps[m], call: `${role}_blend` }]));
    const skin = skinMaterial(lookups, source, uniforms);
    skin.name = (mesh.material as THREE.Material).name;
    (mesh.material as THREE.Material).dispose();
    mesh.material = skin;
    const part: Part = { content, mesh, tile: null, skin, materials: [uniforms] };
    mesh.userData.tile = t;
    mesh.onBeforeRender = (renderer) => this.blend(renderer);
    return part;
  }

  private flatOf(part: Part, m: number): THREE.Material {
    const { source, uniforms } = shaderOf(this.document, part.mesh.userData.tile, { shown: m }, part.tile);
    part.materials.push(uniforms);
    return flatMaterial(this.document.maps[m], source, uniforms);
  }

  private forget(part: Part): void {
    (part.mesh.material as THREE.Material).dispose();
    part.materials.length = 1;
  }

  // Before any part is drawn: the combined weights of equation (8), where they are others than before.
  private blend(renderer: THREE.WebGLRenderer): void {
    if (this.renderer !== renderer) this.upload(renderer);
    const { maps, expressions, regions } = this.gains;
    const weights = this.beta.map((beta, n) => beta * expressions[this.expressions[n]]);
    const gains = Float32Array.from(this.document.regions ?? [], (name) => regions[name]);
    const wanted = `${weights};${gains}`;
    if (this.blended !== wanted) for (const { tile } of this.parts) tile!.prepass.render(weights, gains);
    this.blended = wanted;
    const shown = this.document.maps.find((_, m) => this.parts[0].materials[1] && this.parts[0].materials[1].shown_map?.value === this.parts[0].tile!.textures[m]);
    for (const { materials } of this.parts) {
      for (const uniforms of materials) {
        for (const [role, m] of Object.entries(rolesOf(this.document))) if (uniforms[`${role}_gain`]) uniforms[`${role}_gain`].value = maps[this.document.maps[m].name];
        if (uniforms.shown_gain && shown) uniforms.shown_gain.value = maps[shown.name];
      }
    }
  }
}
