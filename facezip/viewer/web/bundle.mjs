// One script and one style sheet, minified, and the licences of everything that went in.
import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";

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
