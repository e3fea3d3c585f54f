// What a head is drawn from, as facezip/viewer/scene.py says it; and where its images and arrays come from.

export interface MapEntry {
  name: string;
  encoding: "srgb" | "data" | "normal";
  /** The values that texels of 0 and 1 stand for. */
  range: [number, number];
  /** Of a value; 2 for normals. */
  channels: number;
  /** Of its images: 3 for normals; two channels may come as grey with alpha. */
  image_channels: number;
}

export interface TextureEntry {
  /** Rows and columns of neutral and differences. */
  size: [number, number];
  /** 8 or 16. */
  neutral_bits: number;
  /** D = (t − zero) · span: of texels, or of slopes for normals. */
  difference_span: [number, number, number][];
}

export interface TileEntry {
  /** Column and row of the UDIM tile. */
  place: [number, number];
  /** Rows and columns of one weight map. */
  weight_size: [number, number];
  weight_span: number[];
  weight_offset: number[];
  /** One a map. */
  textures: TextureEntry[];
}

export interface HeadDocument {
  expressions: string[];
  maps: MapEntry[];
  tiles: TileEntry[];
  /** Difference textures of a map. */
  slots: number;
  difference_zero: number;
  /** Slopes of normals are clipped to this, either way. */
  max_slope: number;
  /** Whether every weight map is one texel of floats. */
  uniform: boolean;
  /** How many images hold the masks that weight maps are sums of, by four; left out where weight maps are stored. */
  fours?: number;
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
