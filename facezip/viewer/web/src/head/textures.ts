// A map of a tile as one array texture: the neutral, the differences, and the lower half of a neutral of 16 bits. Values stay
// encoded; row 0 is the top of the image. One sampler a map leaves room for all of them among the 16 that a shader has for certain.

import * as THREE from "three";
import type { Assets, HeadDocument, MapEntry, TextureEntry } from "./document";

// Of all textures, with their mip-maps; what a modest GPU holds beside everything else.
const MOST_BYTES = 1.5e9;

/** How much smaller textures have to be for a GPU, as 1, 1/2, 1/4 …. */
export function scaleFor(renderer: THREE.WebGLRenderer, head: HeadDocument): number {
  const textures = head.tiles.flatMap((tile) => tile.textures.map((texture, m) => ({ texture, map: head.maps[m] })));
  const side = Math.max(...textures.flatMap(({ texture }) => texture.size));
  const bytes = textures.reduce((sum, { texture, map }) => sum + (4 / 3) * layerCount(head, texture) * texture.size[0] * texture.size[1] * texelBytes(map), 0);
  let scale = 1;
  while (side * scale > renderer.capabilities.maxTextureSize || bytes * scale * scale > MOST_BYTES) scale /= 2;
  return scale;
}

/** The images of a map of a tile, in the order of the layers of its texture. */
export function readImages(head: HeadDocument, assets: Assets, t: number, m: number, scale: number): Promise<ImageBitmap[]> {
  const entry = head.tiles[t].textures[m];
  const stem = `tile_${t}.map_${m}`;
  const names = [`${stem}.neutral`, ...entry.difference_span.map((_, i) => `${stem}.difference_${i}`), ...(entry.neutral_bits === 16 ? [`${stem}.neutral_low`] : [])];
  return Promise.all(names.map((name) => assets.image(name, scale, entry.size)));
}

/** On the GPU; the images are closed. */
export function textureOf(renderer: THREE.WebGLRenderer, map: MapEntry, images: ImageBitmap[]): THREE.DataArrayTexture {
  const [{ width, height }] = images;
  const texture = emptyArray(width, height, images.length, {
    format: formatOf(map), generateMipmaps: true, minFilter: THREE.LinearMipmapLinearFilter, magFilter: THREE.LinearFilter, anisotropy: 4,
  });
  images.forEach((image, layer) => {
    texture.mipmapsAutoUpdate = layer === images.length - 1;
    renderer.copyTextureToTexture(new THREE.Texture(image), texture, null, new THREE.Vector3(0, 0, layer));
    image.close();
  });
  return texture;
}

const layerCount = (head: HeadDocument, texture: TextureEntry) => head.slots + (texture.neutral_bits === 16 ? 2 : 1);

// Two channels of data come as grey and alpha, which only four channels keep.
const formatOf = (map: MapEntry) => (map.encoding === "normal" ? THREE.RGFormat : map.channels === 1 ? THREE.RedFormat : THREE.RGBAFormat);

const texelBytes = (map: MapEntry) => (map.encoding === "normal" ? 2 : map.channels === 1 ? 1 : 4);

/** Layers to be filled by copies. */
export function emptyArray(columns: number, rows: number, layers: number, options: Partial<THREE.DataArrayTexture>): THREE.DataArrayTexture {
  const texture = Object.assign(new THREE.DataArrayTexture(null, columns, rows, layers), options);
  texture.source.dataReady = false;
  texture.needsUpdate = true;
  return texture;
}
