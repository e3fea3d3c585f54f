// The page: read the scene, open the stage, bind what stands beside it.

import { measureFrames } from "./bench";
import { bindControls } from "./controls";
import { showCosts } from "./costs";
import { byId } from "./dom";
import { bindKeys } from "./keys";
import { Poses } from "./poses";
import { isSingle, readScene, type Scene } from "./scene";
import { Sliders } from "./sliders";
import { Stage } from "./stage";
import { State } from "./state";

async function start(): Promise<void> {
  const scene = await readScene();
  showFacts(scene);
  const state = new State(scene.expressions.length);
  state.layout = !scene.mesh;
  const poses = new Poses(state, scene.expressions);
  new Sliders(state, scene.expressions, () => poses.stop());
  bindControls(scene, state);
  const stage = await Stage.open(scene, state);
  showCosts(scene, stage);
  bindKeys(state, stage, poses);
  // For the console, and for tests.
  Object.assign(globalThis, { facezip: { scene, state, stage, measureFrames: () => measureFrames(stage) } });
  byId("status").textContent = "";
  document.body.classList.add("ready");
}

function showFacts(scene: Scene): void {
  const [rows, columns] = scene.size;
  const mesh = scene.mesh ? `, ${scene.mesh.vertices.toLocaleString("en")} vertices` : "";
  document.title = `${scene.name} · FaceZip`;
  byId("name").textContent = scene.name;
  byId("facts").textContent = `${scene.expressions.length} expressions, ${columns} × ${rows} texels${mesh}, method ${scene.method}`;
  if (isSingle()) byId("licences").removeAttribute("href");
}

start().catch((error: unknown) => {
  byId("status").textContent = `Cannot show the pack: ${error instanceof Error ? error.message : String(error)}`;
  document.body.classList.add("failed");
});
