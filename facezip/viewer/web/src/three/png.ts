// The bytes of a PNG file as they are stored: a canvas would multiply them by their alpha, which here is a number like any other.

const HEADER = 8;
const CHANNELS: Record<number, number> = { 0: 1, 2: 3, 4: 2, 6: 4 };

export interface Texels {
  width: number;
  height: number;
  channels: number;
  /** The first row first. */
  bytes: Uint8Array;
}

/** Of 8 bits a channel, not interlaced, without a palette: as FaceZip writes them. */
export async function readPng(file: ArrayBuffer): Promise<Texels> {
  const view = new DataView(file);
  const packed: Uint8Array<ArrayBuffer>[] = [];
  for (let at = HEADER; at < file.byteLength; at += 12 + view.getUint32(at)) {
    if (view.getUint32(at + 4) === 0x49444154) packed.push(new Uint8Array(file, at + 8, view.getUint32(at)));
  }
  const [width, height, depth, type, interlace] = [view.getUint32(16), view.getUint32(20), view.getUint8(24), view.getUint8(25), view.getUint8(28)];
  const channels = CHANNELS[type];
  if (depth !== 8 || !channels || interlace) throw new Error("a PNG of 8 bits a channel was expected");
  const inflated = new Blob(packed).stream().pipeThrough(new DecompressionStream("deflate"));
  const filtered = new Uint8Array(await new Response(inflated).arrayBuffer());
  return { width, height, channels, bytes: unfiltered(filtered, width * channels, height, channels) };
}

/** PNG specification, third edition, 9.2: each row is stored as differences from what is left of it, above it, or both. */
function unfiltered(filtered: Uint8Array, length: number, rows: number, step: number): Uint8Array {
  const bytes = new Uint8Array(length * rows);
  for (let y = 0, to = 0; y < rows; y++) {
    const filter = filtered[y * (length + 1)];
    for (let x = 0, from = y * (length + 1) + 1; x < length; x++, from++, to++) {
      const left = x < step ? 0 : bytes[to - step];
      const above = y ? bytes[to - length] : 0;
      const corner = x < step || !y ? 0 : bytes[to - length - step];
      bytes[to] = filtered[from] + [0, left, above, (left + above) >> 1, filter === 4 ? nearest(left, above, corner) : 0][filter];
    }
  }
  return bytes;
}

/** Paeth's predictor. */
function nearest(left: number, above: number, corner: number): number {
  const [a, b, c] = [Math.abs(above - corner), Math.abs(left - corner), Math.abs(left + above - 2 * corner)];
  return a <= b && a <= c ? left : b <= c ? above : corner;
}
