import type { Group, MeshPhysicalMaterial } from "three";

/** `url` is that of the folder that `facezip export --to three` wrote; `scale` makes its textures smaller, as 0.5. */
export declare function loadFaceZip(url: string | URL, options?: { scale?: number }): Promise<FaceZipHead>;

/** A head in a scene: morph targets move it, its material blends its maps under the same weights. */
export declare class FaceZipHead extends Group {
  private constructor();
  /** Names, in the order of the pack. */
  readonly expressions: readonly string[];
  /** What changes are multiplied by, 1 at first: those of a map, of an expression's textures, of a region of the face. */
  readonly gains: {
    readonly maps: Record<string, number>;
    readonly expressions: Record<string, number>;
    readonly regions: Record<string, number>;
  };
  /** The skin of each tile that has faces. */
  get materials(): MeshPhysicalMaterial[];
  /** The weights of all expressions. */
  get weights(): Readonly<Record<string, number>>;
  /** Set weights by name, as in `{ smile: 0.5 }`; all others stay. An unknown name is an error. */
  set(weights: Readonly<Record<string, number>>): void;
  /** One map as it is, without light; `null` is the skin again. */
  show(map: string | null): void;
  /** Give back what the GPU has of the head. */
  dispose(): void;
}
