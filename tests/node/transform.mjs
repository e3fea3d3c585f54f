// A round trip through glTF-Transform: read, drop duplicates and what nothing refers to, write.
import { NodeIO } from "@gltf-transform/core";
import { ALL_EXTENSIONS } from "@gltf-transform/extensions";
import { dedup, prune } from "@gltf-transform/functions";

const io = new NodeIO().registerExtensions(ALL_EXTENSIONS);
const document = await io.read(process.argv[2]);
await document.transform(dedup(), prune());
await io.write(process.argv[3], document);
const mesh = document.getRoot().listMeshes()[0];
console.log(JSON.stringify({ targets: mesh.getExtras().targetNames }));
