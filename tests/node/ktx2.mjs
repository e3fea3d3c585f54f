// What ktx-parse reads of a KTX2 file; with --decode, what three.js' Basis transcoder makes of its levels.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { read } from "ktx-parse";

const content = readFileSync(process.argv[2]);
const file = read(new Uint8Array(content));
const sheet = file.dataFormatDescriptor[0];
const facts = {
  format: file.vkFormat,
  size: [file.pixelHeight, file.pixelWidth, file.pixelDepth, file.layerCount, file.faceCount],
  scheme: file.supercompressionScheme,
  model: sheet.colorModel,
  transfer: sheet.transferFunction,
  keys: Object.keys(file.keyValue),
  levels: file.levels.map((level) => Buffer.from(level.levelData).toString("base64")),
};
if (process.argv.includes("--decode")) {
  const require = createRequire(import.meta.url);
  const folder = require.resolve("three/examples/jsm/libs/basis/basis_transcoder.js");
  const factory = new Function("require", "__dirname", readFileSync(folder, "utf8") + "; return BASIS;")(require, "");
  const basis = await factory({ wasmBinary: readFileSync(folder.replace(".js", ".wasm")) });
  basis.initializeBasis();
  const reader = new basis.KTX2File(new Uint8Array(content));
  reader.startTranscoding();
  const RGBA32 = 13;
  facts.texels = file.levels.map((_, level) => {
    const texels = new Uint8Array(reader.getImageTranscodedSizeInBytes(level, 0, 0, RGBA32));
    reader.transcodeImage(texels, level, 0, 0, RGBA32, 0, -1, -1);
    return Buffer.from(texels).toString("base64");
  });
}
console.log(JSON.stringify(facts));
