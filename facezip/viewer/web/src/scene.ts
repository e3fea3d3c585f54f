// What Python wrote: a document, and assets by name, inside the page or beside it on the server.

export interface Scene {
  name: string;
  method: string;
  expressions: string[];
  /** Rows and columns of neutral and differences. */
  size: [number, number];
  difference_scale: [number, number, number][];
  difference_zero: number;
  difference_steps: number;
  /** Rows and columns of one weight map. */
  weight_size: [number, number];
  weight_columns: number;
  weight_scale: number[];
  weight_offset: number[];
  /** The largest absolute weight. */
  weight_range: number;
  uniform: boolean;
  costs: { bytes_on_gpu: number; bytes_raw: number; bytes_on_disk: number; fetches: number };
  mesh: { vertices: number; triangles: number; delta_scale: number[] } | null;
  original: { rmse: number; rmse_per_expression: number[] } | null;
}

const block = (name: string) => document.querySelector(`script[data-name="${name}"]`)?.textContent;

/** Whether everything is inside the page. */
export const isSingle = () => block("scene.json") != null;

export async function readScene(): Promise<Scene> {
  const inside = block("scene.json");
  return inside == null ? (await asked("scene.json")).json() : JSON.parse(inside);
}

export async function readBytes(name: string): Promise<Uint8Array<ArrayBuffer>> {
  const inside = block(`${name}`);
  if (inside == null) return new Uint8Array(await (await asked(name)).arrayBuffer());
  return Uint8Array.from(atob(inside), (character) => character.charCodeAt(0));
}

/** An array that Python deflated; little-endian, as every machine that has WebGL. */
export async function readArray(name: string): Promise<ArrayBuffer> {
  const stream = new Blob([await readBytes(`${name}.zlib`)]).stream();
  return new Response(stream.pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

/** The bytes of an image as they are stored: no colour management, no alpha, first row first. */
export async function readImage(name: string): Promise<ImageBitmap> {
  const image = new Blob([await readBytes(`${name}.png`)], { type: "image/png" });
  return createImageBitmap(image, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
}

async function asked(name: string): Promise<Response> {
  const response = await fetch(name);
  if (!response.ok) throw new Error(`${name}: the server answers ${response.status}`);
  return response;
}
