// What ktx-parse reads of KTX2 files, and three.js' Zstandard of their levels; with --decode, its Basis transcoder too.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { read } from "ktx-parse";
import { ZSTDDecoder } from "three/examples/jsm/libs/zstddec.module.js";

const RGBA32 = 13;
const zstandard = new ZSTDDecoder();
await zstandard.init();
const base64 = (bytes) => Buffer.from(bytes).toString("base64");

async function transcoder() {
  const require = createRequire(import.meta.url);
  const script = require.resolve("three/examples/jsm/libs/basis/basis_transcoder.js");
  const load = new Function("require", "__dirname", readFileSync(script, "utf8") + "; return BASIS;");
  const basis = await load(require, "")({ wasmBinary: readFileSync(script.replace(".js", ".wasm")) });
  basis.initializeBasis();
  return basis;
}

function parse(content) {
  const file = read(new Uint8Array(content));
  const sheet = file.dataFormatDescriptor[0];
  return {
    format: file.vkFormat,
    size: [file.pixelHeight, file.pixelWidth, file.pixelDepth, file.layerCount, file.faceCount],
    scheme: file.supercompressionScheme,
    model: sheet.colorModel,
    transfer: sheet.transferFunction,
    samples: sheet.samples.map((sample) => [sample.channelType, sample.bitOffset, sample.bitLength]),
    keys: Object.keys(file.keyValue),
    options: file.keyValue.KTXwriterScParams,
    frames: file.levels.map((level) => level.levelData.length),
    levels: file.levels.map((level) => base64(zstandard.decode(level.levelData, level.uncompressedByteLength))),
  };
}

function decode(basis, content) {
  const reader = new basis.KTX2File(new Uint8Array(content));
  reader.startTranscoding();
  return Array.from({ length: reader.getLevels() }, (_, level) => {
    const texels = new Uint8Array(reader.getImageTranscodedSizeInBytes(level, 0, 0, RGBA32));
    reader.transcodeImage(texels, level, 0, 0, RGBA32, 0, -1, -1);
    return base64(texels);
  });
}

const files = process.argv.slice(2).filter((word) => word !== "--decode").map((file) => readFileSync(file));
const basis = process.argv.includes("--decode") ? await transcoder() : null;
console.log(JSON.stringify(files.map((content) => ({ ...parse(content), texels: basis && decode(basis, content) }))));
