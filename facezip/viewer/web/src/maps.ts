// The maps of a pack as textures. Values stay encoded (sRGB); row 0 is the top of the image, at v = 1.

import * as THREE from "three";
import { readArray, readImage, type Scene } from "./scene";

export interface Maps {
  neutral: THREE.Texture;
  differences: THREE.Texture[];
  /** One RGBA atlas a layer of four slots. */
  weights: THREE.DataTexture[];
}

export async function readMaps(scene: Scene): Promise<Maps> {
  const slots = scene.difference_scale.length;
  const [neutral, differences, weights] = await Promise.all([
    readImage("neutral").then(colourTexture),
    Promise.all(scene.difference_scale.map((_, i) => readImage(`difference_${i}`).then(colourTexture))),
    Promise.all(Array.from({ length: Math.ceil(slots / 4) }, (_, layer) => readAtlas(scene, layer))),
  ]);
  return { neutral, differences, weights };
}

/** An image as stored, filtered as an engine would. */
export function colourTexture(image: ImageBitmap): THREE.Texture {
  const texture = new THREE.Texture(image);
  texture.colorSpace = THREE.NoColorSpace;
  texture.flipY = false;
  texture.premultiplyAlpha = false;
  texture.generateMipmaps = true;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

// Read texel by texel alone: no filter ever reaches from one weight map into the next.
async function readAtlas(scene: Scene, layer: number): Promise<THREE.DataTexture> {
  const stored = await readArray(`weights_${layer}`);
  const columns = scene.weight_columns * scene.weight_size[1];
  const rows = Math.ceil(scene.expressions.length / scene.weight_columns) * scene.weight_size[0];
  const texture = scene.uniform
    ? new THREE.DataTexture(new Float32Array(stored), columns, rows, THREE.RGBAFormat, THREE.FloatType)
    : new THREE.DataTexture(new Uint8Array(stored), columns, rows, THREE.RGBAFormat, THREE.UnsignedByteType);
  texture.needsUpdate = true;
  return texture;
}
