// Made by `python -m tests.documents.make` from the published schemas (docs/documents.md); do not edit.

/** What blocks add to expressions: RMSE of 255, of normals mean angles in degrees. */
export interface CodecErrors {
  /** of the codec. */
  name: string;
  /** mean over expressions. */
  rmse?: number;
  /** by expression. */
  rmse_per_expression?: Record<string, number>;
  /** without fitting each texture to what was lost of the others. */
  rmse_without_fit?: number;
  /** mean over expressions. */
  angular_error?: number;
  /** by expression. */
  angular_error_per_expression?: Record<string, number>;
  /** without fitting each texture to what was lost of the others. */
  angular_error_without_fit?: number;
  /** what storing lost of each texture. */
  maps?: Record<string, number>;
}

/** An export of one tile, as it stands in facezip.json. */
export interface ExportDocument {
  /** facezip-NAME/VERSION. A version may gain fields; one that loses or changes a field has another number. */
  format: "facezip-export/1";
  /** what takes it. */
  target: string;
  /** of the pack. */
  name: string;
  /** its UDIM number. */
  tile: number;
  /** of the first texture. */
  resolution: [number, number];
  /** of the first texture. */
  channels: number;
  /** textures of combined weights, four slots each. */
  layers: number;
  /** rows and columns of a weight map. */
  weight_size: [number, number];
  /** by expression, where weights are uniform, else none. */
  uniform_weights: number[][];
  /** what can be turned down. */
  gains: Gains;
  /** expressions as weight maps have them. */
  order: string[];
  /** by name. */
  expressions: Record<string, ExpressionPlace>;
  /** by name. */
  textures: Record<string, ExportedTexture>;
  /** by name. */
  maps: Record<string, ExportedMap>;
  /** of the first map. */
  codec: CodecErrors;
  /** of the first map. */
  mips: MipErrors[];
  /** of the face, where some were given. */
  regions?: ExportedRegions;
  /** where weight maps are sums of them. */
  masks?: ExportedMasks;
  /** what is not usual, for people: the size of a head of an unknown unit. */
  notes: string[];
  /** all others, which are looked at when the last is written. */
  files: Record<string, ExportedFile>;
  /** of the document without this field, as JSON with sorted keys and no spaces. */
  sha256: string;
  /** the folder, and the bytes of all files; not in the file. */
  output?: string;
  /** the folder, and the bytes of all files; not in the file. */
  bytes?: number;
}

/** What a file has to be. */
export interface ExportedFile {
  /** of its content. */
  bytes?: number;
  /** of its content. */
  sha256?: string;
  /** of a texture: how an importer has to take it. */
  srgb?: boolean;
  /** of a texture: how an importer has to take it. */
  mipmaps?: boolean;
  /** of a PNG: rows and columns, and the SHA-256 of its numbers, however they are compressed. */
  size?: [number, number];
  /** of a PNG: rows and columns, and the SHA-256 of its numbers, however they are compressed. */
  numbers?: string;
  /** of an importer's file, in the place of all that. */
  settings?: Record<string, string>;
}

/** Where a map is. */
export interface ExportedMap {
  /** what its numbers stand for, and the values of texels of 0 and 1. */
  encoding: "srgb" | "data" | "normal";
  /** what its numbers stand for, and the values of texels of 0 and 1. */
  range: [number, number];
  /** rows and columns. */
  size: [number, number];
  /** names among the textures. */
  neutral: string;
  /** names among the textures. */
  differences: string[];
  /** its own in those. */
  channels: number[];
  /** slopes of normals are clipped to this, either way. */
  max_slope?: number;
  /** of blocks. */
  codec?: CodecErrors;
  /** level by level. */
  mips: MipErrors[];
}

/** Masks that weight maps are sums of, in the place of weight maps. */
export interface ExportedMasks {
  /** their atlas, by four. */
  file: string;
  /** fours beside each other, and rows and columns of a mask. */
  columns: number;
  /** fours beside each other, and rows and columns of a mask. */
  size: [number, number];
  /** of the masks. */
  names: string[];
  /** whether all activations lie in 0..1. */
  clamped: boolean;
  /** activations of an expression by four: for each layer of four slots one of each mask. */
  vectors: number;
  /** those of all expressions as half floats, little-endian, in base64. */
  activations: string;
}

/** The atlas of masks: its file, how many are beside each other, and rows and columns of one. */
export interface ExportedRegions {
  file: string;
  columns: number;
  size: [number, number];
}

/** A file, and the numbers that turn its texels t, from 0 to 1, back into values. */
export interface ExportedTexture {
  /** its name. */
  file: string;
  /** the file of the lower bits, of a neutral of 16. */
  low?: string;
  /** of a difference: (t − zero) · scale, a number a channel. */
  scale?: number[];
  /** of a difference: (t − zero) · scale, a number a channel. */
  zero?: number;
  /** of weights: t · scale + offset. */
  offset?: number[];
  /** of weights: weight maps beside each other, and rows and columns of one. */
  columns?: number;
  /** of weights: weight maps beside each other, and rows and columns of one. */
  size?: [number, number];
}

/** Where an expression is: its morph target, and column and row of any weight map of its own in the atlas. */
export interface ExpressionPlace {
  morph_target: number;
  weight_tile?: [number, number];
}

/** Names of what can be turned down after export: maps, expressions, and regions of the face. */
export interface Gains {
  maps: string[];
  expressions: string[];
  regions: string[];
}

/** What a curve drives: a mask in a layer of a map, layers from 1 on. */
export interface LayerCurve {
  map: string;
  layer: number;
  mask: string;
}

/** Where a map is, and how far what the engine mixes is from the pack: RMSE of 255, of normals angles in degrees. */
export interface LayeredMap {
  /** what its numbers stand for, and the values of texels of 0 and 1. */
  encoding: "srgb" | "data" | "normal";
  /** what its numbers stand for, and the values of texels of 0 and 1. */
  range: [number, number];
  /** rows and columns. */
  size: [number, number];
  /** names among the textures; no layers where the engine does not mix the map. */
  neutral: string;
  /** names among the textures; no layers where the engine does not mix the map. */
  layers: string[];
  /** mean over expressions. */
  rmse?: number;
  /** by expression. */
  rmse_per_expression?: Record<string, number>;
  /** mean over blends of neighbours, half and half. */
  rmse_blends?: number;
  /** of a texel in an expression. */
  rmse_largest?: number;
  /** mean over expressions. */
  angular_error?: number;
  /** by expression. */
  angular_error_per_expression?: Record<string, number>;
  /** mean over blends of neighbours, half and half. */
  angular_error_blends?: number;
  /** of a texel in an expression. */
  angular_error_largest?: number;
  /** the share of its layers' values that 8 bits cut, 0..1. */
  beyond?: number;
}

/** A whole picture, or a mask. */
export interface LayeredTexture {
  /** its name. */
  file: string;
  /** how an importer has to take it; with mip-maps where that is left out. */
  srgb: boolean;
  /** how an importer has to take it; with mip-maps where that is left out. */
  mipmaps?: boolean;
}

/** An export of layers under masks, for MetaHuman or O3DE, as it stands in facezip.json. */
export interface LayersExport {
  /** facezip-NAME/VERSION. A version may gain fields; one that loses or changes a field has another number. */
  format: "facezip-export/1";
  /** as of TileExport. */
  target: string;
  /** as of TileExport. */
  name: string;
  /** as of TileExport. */
  tile: number;
  /** by name. */
  textures: Record<string, LayeredTexture>;
  /** by name. */
  maps: Record<string, LayeredMap>;
  /** by name, of MetaHuman. */
  curves?: Record<string, LayerCurve>;
  /** what the engine leaves out, for people. */
  notes: string[];
  /** as of ExportDocument. */
  files: Record<string, ExportedFile>;
  /** as of ExportDocument. */
  sha256: string;
  /** as of ExportDocument. */
  output?: string;
  /** as of ExportDocument. */
  bytes?: number;
}

/** How far one level of mip-maps is from how a blend should look from afar; _blends of unseen blends. */
export interface MipErrors {
  /** rows and columns of the level. */
  size: [number, number];
  /** how far the mean of a blend's texels is from the blend of plain mip-maps. */
  product_gap: number;
  /** how far the mean of a blend's texels is from the blend of plain mip-maps. */
  product_gap_blends?: number;
  /** every texture averaged on its own, stored as it is. */
  plain: number;
  /** every texture averaged on its own, stored as it is. */
  plain_blends?: number;
  /** the same in blocks. */
  averaged?: number;
  /** the same in blocks. */
  averaged_blends?: number;
  /** in blocks and fitted, as written. */
  fitted?: number;
  /** in blocks and fitted, as written. */
  fitted_blends?: number;
}

/** Bytes and fetches, as of PackFacts. */
export interface SceneCosts {
  bytes_on_gpu: number;
  bytes_raw: number;
  bytes_on_disk: number;
  fetches: number;
}

/** What the viewer's page draws. */
export interface SceneDocument {
  /** facezip-NAME/VERSION. A version may gain fields; one that loses or changes a field has another number. */
  format: "facezip-scene/1";
  /** of the pack. */
  name: string;
  /** of the pack. */
  method: string;
  /** of the pack. */
  expressions: string[];
  /** that it offers. */
  poses: ScenePose[];
  /** albedo first, numbers ascending. */
  maps: SceneMap[];
  /** albedo first, numbers ascending. */
  tiles: SceneTile[];
  /** difference textures of a map. */
  slots: number;
  /** the texel that stands for no difference. */
  difference_zero: number;
  /** slopes of normals are clipped to this, either way. */
  max_slope: number;
  /** whether every weight map is one texel of floats. */
  uniform: boolean;
  /** the largest absolute weight. */
  weight_range: number;
  /** images that hold the masks which weight maps are sums of, by four; left out where weight maps are stored. */
  fours?: number;
  /** at run time. */
  costs: SceneCosts;
  /** null where the pack has none. */
  mesh: SceneMesh | null;
  /** whether the original textures are there. */
  originals: boolean;
}

/** One map, as the page draws it. */
export interface SceneMap {
  /** albedo, normal, roughness, specular, cavity, or what character.toml calls it. */
  name: string;
  /** what its numbers stand for: sRGB-encoded colours, data as it is, or unit vectors. */
  encoding: "srgb" | "data" | "normal";
  /** numbers of a texel. */
  channels: number;
  /** the values that texels of 0 and 1 stand for. */
  range: [number, number];
  /** of its images: 3 for normals; two channels may come as grey with alpha. */
  image_channels: number;
  /** to the originals, where those are there: degrees of normals, else parts of 255. */
  error: number | null;
}

/** How many vertices and triangles the head has. */
export interface SceneMesh {
  vertices: number;
  triangles: number;
}

/** A named blend. */
export interface ScenePose {
  /** of the pose. */
  name: string;
  /** places of expressions, and their weights. */
  weights: [number, number][];
}

/** One map on one tile. */
export interface SceneTexture {
  /** rows and columns of neutral and differences. */
  size: [number, number];
  /** of a channel of the neutral, 8 or 16. */
  neutral_bits: number;
  /** D = (t − zero) · span: of texels, or of slopes for normals. */
  difference_span: [number, number, number][];
}

/** One UDIM tile. */
export interface SceneTile {
  /** of the tile. */
  number: number;
  /** its column and row. */
  place: [number, number];
  /** rows and columns of one weight map. */
  weight_size: [number, number];
  /** a weight is t · span + offset; one of each a slot. */
  weight_span: number[];
  /** a weight is t · span + offset; one of each a slot. */
  weight_offset: number[];
  /** one a map. */
  textures: SceneTexture[];
}

/** One tile. */
export interface TileExport {
  /** facezip-NAME/VERSION. A version may gain fields; one that loses or changes a field has another number. */
  format: "facezip-export/1";
  /** what takes it. */
  target: string;
  /** of the pack. */
  name: string;
  /** its UDIM number. */
  tile: number;
  /** of the first texture. */
  resolution: [number, number];
  /** of the first texture. */
  channels: number;
  /** textures of combined weights, four slots each. */
  layers: number;
  /** rows and columns of a weight map. */
  weight_size: [number, number];
  /** by expression, where weights are uniform, else none. */
  uniform_weights: number[][];
  /** what can be turned down. */
  gains: Gains;
  /** expressions as weight maps have them. */
  order: string[];
  /** by name. */
  expressions: Record<string, ExpressionPlace>;
  /** by name. */
  textures: Record<string, ExportedTexture>;
  /** by name. */
  maps: Record<string, ExportedMap>;
  /** of the first map. */
  codec: CodecErrors;
  /** of the first map. */
  mips: MipErrors[];
  /** of the face, where some were given. */
  regions?: ExportedRegions;
  /** where weight maps are sums of them. */
  masks?: ExportedMasks;
}

/** An export of several tiles, as it stands in facezip.json. */
export interface TilesDocument {
  /** facezip-NAME/VERSION. A version may gain fields; one that loses or changes a field has another number. */
  format: "facezip-export/1";
  /** as of TileExport. */
  target: string;
  /** as of TileExport. */
  name: string;
  /** by UDIM number; each stands in the folder of its tile, too. */
  tiles: Record<string, TileExport>;
  /** as of ExportDocument. */
  notes: string[];
  /** as of ExportDocument. */
  files: Record<string, ExportedFile>;
  /** as of ExportDocument. */
  sha256: string;
  /** as of ExportDocument. */
  output?: string;
  /** as of ExportDocument. */
  bytes?: number;
}
