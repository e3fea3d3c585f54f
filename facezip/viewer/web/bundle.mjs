// The viewer as one script and one style sheet, minified, with the licences of everything that went in; and what
// `facezip export --to three` copies: the head as a module beside three.js, and of three.js what its page needs.
import { build } from "esbuild";
import { copyFile, readFile, writeFile } from "node:fs/promises";

const { metafile } = await build({
  entryPoints: ["src/viewer.ts", "src/viewer.css"],
  outdir: "bundle",
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  loader: { ".glsl": "text" },
  legalComments: "none",
  metafile: true,
});

const packages = new Set();
for (const input of Object.keys(metafile.inputs)) {
  const found = /node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(input);
  if (found) packages.add(found[1]);
}
const notices = await Promise.all([...packages].sort().map(async (name) => {
  const about = JSON.parse(await readFile(`node_modules/${name}/package.json`, "utf8"));
  const licence = await readFile(`node_modules/${name}/LICENSE`, "utf8");
  return `${name} ${about.version}\n\n${licence.trim()}\n`;
}));
await writeFile("bundle/LICENCES.txt", `This page contains:\n\n${notices.join("\n")}`);

// What the module imports of three.js stays apart, so that there is one three.js in a page.
const addons = ["controls/OrbitControls", "loaders/GLTFLoader", "postprocessing/Pass"];
const shared = { bundle: true, format: "esm", target: "es2022", legalComments: "none" };
await build({
  ...shared,
  entryPoints: ["src/three/facezip.ts"],
  outdir: "bundle/three",
  external: ["three", "three/*"],
  banner: { js: "// FaceZip for three.js, made of the source of its viewer. MIT licence, as FaceZip." },
});
await build({
  ...shared,
  entryPoints: { "three.module": "three", ...Object.fromEntries(addons.map((name) => [`addons/${name}`, `three/addons/${name}.js`])) },
  outdir: "bundle/three/three",
  minify: true,
  splitting: true,
  chunkNames: "three.[hash]",
});
await copyFile("three/facezip.d.ts", "bundle/three/facezip.d.ts");
await copyFile("node_modules/three/LICENSE", "bundle/three/three/LICENSE");
