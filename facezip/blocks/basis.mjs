// Encodes textures with ktx2-encoder until standard input ends.
// In: width and height (32 bits each), RGBA texels. Out: UASTC blocks, then the RGBA texels that they decode to.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

// The encoder reports to standard output, which is for texels.
console.log = () => {};

const UASTC_QUALITY = 2;
const RGBA32 = 13;
const LEVEL_INDEX = 80;

const folder = process.argv[2];
const entry = JSON.parse(readFileSync(join(folder, "package.json"))).exports["."].node.import;
const { NodeBasisEncoder } = await import(pathToFileURL(join(folder, entry)));
const encoder = new NodeBasisEncoder();

async function encode(width, height, data) {
  const file = await encoder.encode(data, {
    isUASTC: true,
    isKTX2File: true,
    generateMipmap: false,
    needSupercompression: false,
    isPerceptual: false,
    isSetKTX2SRGBTransferFunc: false,
    uastcLDRQualityLevel: UASTC_QUALITY,
    imageDecoder: async () => ({ width, height, data }),
  });
  const view = new DataView(file.buffer, file.byteOffset);
  const start = Number(view.getBigUint64(LEVEL_INDEX, true));
  const length = Number(view.getBigUint64(LEVEL_INDEX + 8, true));
  return [file, file.subarray(start, start + length)];
}

async function decode(file, width, height) {
  const { KTX2File } = await encoder.init();
  const reader = new KTX2File(file);
  const texels = new Uint8Array(4 * width * height);
  const done = reader.startTranscoding() && reader.transcodeImage(texels, 0, 0, 0, RGBA32, 0, -1, -1);
  reader.close();
  reader.delete();
  if (!done) throw new Error("cannot transcode");
  return texels;
}

let waiting = Buffer.alloc(0);
for await (const part of process.stdin) {
  waiting = Buffer.concat([waiting, part]);
  while (waiting.length >= 8) {
    const [width, height] = [waiting.readUInt32LE(0), waiting.readUInt32LE(4)];
    const end = 8 + 4 * width * height;
    if (waiting.length < end) break;
    const [file, blocks] = await encode(width, height, waiting.subarray(8, end));
    process.stdout.write(blocks);
    process.stdout.write(await decode(file, width, height));
    waiting = waiting.subarray(end);
  }
}
