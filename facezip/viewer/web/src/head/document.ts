// What a head is drawn from: of the viewer's document (facezip/viewer/documents.py) what an export has as well; and where
// its images and arrays come from.

import type { SceneDocument, SceneMap, SceneTexture, SceneTile } from "../published";

export type MapEntry = Omit<SceneMap, "error">;
export type TextureEntry = SceneTexture;
export type TileEntry = Omit<SceneTile, "number">;

export interface HeadDocument extends Pick<SceneDocument, "expressions" | "slots" | "difference_zero" | "max_slope" | "uniform" | "fours"> {
  maps: MapEntry[];
  tiles: TileEntry[];
  /** Names of regions of the face that can be turned down; every tile has a mask of each. */
  regions?: string[];
  mesh: object | null;
}

export interface Assets {
  /** `NAME.zlib`, inflated. */
  array(name: string): Promise<ArrayBuffer>;
  /** `NAME.png`: bytes as they are stored, the first row first; of `scale` times the size. */
  image(name: string, scale: number, size: [number, number]): Promise<ImageBitmap>;
}

/** Layers of combined weights: four slots each. */
export const layersOf = (slots: number) => Math.ceil(slots / 4);
