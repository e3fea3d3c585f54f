// Encodes textures as ETC1S with ktx2-encoder until standard input ends, at the quality of the first argument.
// In: width and height (32 bits each), RGBA texels. Out: bytes of the KTX2 file (32 bits), the RGBA texels that it gives.
import { NodeBasisEncoder } from "ktx2-encoder";

// The encoder reports to standard output, which is for texels.
console.log = () => {};

const RGBA32 = 13;
const qualityLevel = Number(process.argv[2]);
const encoder = new NodeBasisEncoder();

async function encode(width, height, data) {
  const file = await encoder.encode(data, {
    isUASTC: false,
    isKTX2File: true,
    generateMipmap: false,
    isPerceptual: false,
    isSetKTX2SRGBTransferFunc: false,
    qualityLevel,
    imageDecoder: async () => ({ width, height, data }),
  });
  const { KTX2File } = await encoder.init();
  const reader = new KTX2File(file);
  const texels = new Uint8Array(4 * width * height);
  const done = reader.startTranscoding() && reader.transcodeImage(texels, 0, 0, 0, RGBA32, 0, -1, -1);
  reader.close();
  reader.delete();
  if (!done) throw new Error("cannot transcode");
  return [file.length, texels];
}

let waiting = Buffer.alloc(0);
for await (const part of process.stdin) {
  waiting = Buffer.concat([waiting, part]);
  while (waiting.length >= 8) {
    const [width, height] = [waiting.readUInt32LE(0), waiting.readUInt32LE(4)];
    const end = 8 + 4 * width * height;
    if (waiting.length < end) break;
    const [length, texels] = await encode(width, height, waiting.subarray(8, end));
    const answer = Buffer.alloc(4);
    answer.writeUInt32LE(length);
    process.stdout.write(answer);
    process.stdout.write(texels);
    waiting = waiting.subarray(end);
  }
}
