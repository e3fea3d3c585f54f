// PNG as packs have it: 8 or 16 bits, not interlaced, no palette. Every checksum is looked at, and no more memory is asked
// for than the stated size needs.
import { crc32, inflateSync } from "node:zlib";
import { need } from "./refusal.mjs";

const SIGNATURE = "89504e470d0a1a0a";
const COLOUR_TYPES = { 1: 0, 2: 4, 3: 2, 4: 6 }; // channels → grey, grey with alpha, RGB, RGBA

/** The samples of a PNG file, row by row, or a refusal where it has another size, depth or number of channels. */
export function decodePng(bytes, [rows, columns], channels, bits, name) {
  const { header, data } = chunksOf(bytes, name);
  const stated = [header.readUInt32BE(4), header.readUInt32BE(0), header[8], header[9], header[12]].join();
  need(
    stated === [rows, columns, bits, COLOUR_TYPES[channels], 0].join(),
    `${name} is not of the size and type stated`,
  );
  const stride = (columns * channels * bits) / 8;
  const lines = unfold(data, rows * (stride + 1), name);
  const pixels = unfilter(lines, rows, stride, (channels * bits) / 8, name);
  return bits === 8
    ? pixels
    : Uint16Array.from({ length: pixels.length / 2 }, (_, i) => (pixels[2 * i] << 8) | pixels[2 * i + 1]);
}

function chunksOf(bytes, name) {
  need(bytes.toString("hex", 0, 8) === SIGNATURE, `${name} is no PNG`);
  const chunks = [];
  for (let at = 8; at < bytes.length;) {
    const end = at + 12 + (at + 12 <= bytes.length ? bytes.readUInt32BE(at) : 0);
    need(end <= bytes.length, `${name} is cut short`);
    need(crc32(bytes.subarray(at + 4, end - 4)) === bytes.readUInt32BE(end - 4), `${name} has a wrong checksum`);
    chunks.push({ kind: bytes.toString("latin1", at + 4, at + 8), body: bytes.subarray(at + 8, end - 4) });
    at = end;
  }
  need(
    chunks[0]?.kind === "IHDR" && chunks[0].body.length === 13 && chunks.at(-1).kind === "IEND",
    `${name} has no header or end`,
  );
  return {
    header: chunks[0].body,
    data: Buffer.concat(chunks.filter(({ kind }) => kind === "IDAT").map(({ body }) => body)),
  };
}

function unfold(data, length, name) {
  let lines;
  try {
    lines = inflateSync(data, { maxOutputLength: length });
  } catch (error) {
    need(false, `${name}: ${error.message}`);
  }
  need(lines.length === length, `${name} has too few pixels`);
  return lines;
}

/** Undo the filters of PNG's section 9: each byte was stored less a guess from its left, upper and upper left neighbours. */
function unfilter(lines, rows, stride, step, name) {
  const pixels = new Uint8Array(rows * stride);
  for (let row = 0; row < rows; row++) {
    const filter = lines[row * (stride + 1)];
    need(filter <= 4, `${name} has an unknown filter`);
    for (let x = 0; x < stride; x++) {
      const at = row * stride + x;
      const left = x >= step ? pixels[at - step] : 0;
      const up = row > 0 ? pixels[at - stride] : 0;
      const corner = x >= step && row > 0 ? pixels[at - stride - step] : 0;
      const guess = [0, left, up, (left + up) >> 1, filter === 4 ? paeth(left, up, corner) : 0][filter];
      pixels[at] = lines[row * (stride + 1) + 1 + x] + guess;
    }
  }
  return pixels;
}

function paeth(left, up, corner) {
  const [a, b, c] = [left, up, corner].map((near) => Math.abs(left + up - corner - near));
  return a <= b && a <= c ? left : b <= c ? up : corner;
}
