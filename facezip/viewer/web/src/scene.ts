// What Python wrote: a document, and assets by name, inside the page or beside it on the server.

import { asked, bitmapOf } from "./head/assets";
import type { Assets } from "./head/document";
import type { SceneDocument } from "./published";

export type Scene = SceneDocument;

const block = (name: string) => document.querySelector(`script[data-name="${name}"]`)?.textContent;

/** Whether everything is inside the page. */
export const isSingle = () => block("scene.json") != null;

export async function readScene(): Promise<Scene> {
  const inside = block("scene.json");
  return inside == null ? (await asked("scene.json")).json() : JSON.parse(inside);
}

/** Arrays are little-endian, as every machine that has WebGL. */
export const assets: Assets = {
  async array(name) {
    const stream = new Blob([await bytesOf(`${name}.zlib`)]).stream();
    return new Response(stream.pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  },

  async image(name, scale, size) {
    return bitmapOf(new Blob([await bytesOf(`${name}.png`)], { type: "image/png" }), scale, size);
  },
};

async function bytesOf(name: string): Promise<Uint8Array<ArrayBuffer>> {
  const inside = block(name);
  if (inside == null) return new Uint8Array(await (await asked(name)).arrayBuffer());
  return Uint8Array.from(atob(inside), (character) => character.charCodeAt(0));
}
