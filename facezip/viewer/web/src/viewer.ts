// The page: read the scene, open the stage, bind what stands beside it.

import { measureFrames } from "./bench";
import { bindControls } from "./controls";
import { showCosts } from "./costs";
import { byId, element } from "./dom";
import { bindKeys } from "./keys";
import { Poses } from "./poses";
import { isSingle, readScene, type Scene } from "./scene";
import { Sliders } from "./sliders";
import { Stage } from "./stage";
import { State } from "./state";
import { SHADOW_SIZE } from "./studio";

async function start(): Promise<void> {
  // What goes wrong where nobody waits for it: textures that come later, shaders that a driver refuses.
  addEventListener("unhandledrejection", ({ reason }) => say(`Not everything is shown: ${wordsOf(reason)}.`));
  byId("canvas").addEventListener("shaderrefused", () => say("Not everything is shown: this GPU does not take a shader of this page."));
  const scene = await readScene();
  showFacts(scene);
  const state = new State(scene.expressions.length);
  state.layout = !scene.mesh;
  const poses = new Poses(state, scene);
  new Sliders(state, scene.expressions, () => poses.stop());
  const stage = await Stage.open(scene, state);
  bindControls(stage, state);
  showCosts(scene, stage);
  bindKeys(state, stage, poses);
  // For the console, and for tests.
  Object.assign(globalThis, { facezip: { scene, state, stage, measureFrames: () => measureFrames(stage) } });
  showLimits(stage);
  byId("status").textContent = "";
  document.body.classList.add("ready");
}

function showFacts(scene: Scene): void {
  const [rows, columns] = scene.tiles[0].textures[0].size;
  const names = scene.maps.length > 1 ? `${scene.maps.map(({ name }) => name).join(", ")}, ` : "";
  const tiles = scene.tiles.length > 1 ? `${scene.tiles.length} tiles of ` : "";
  const mesh = scene.mesh ? `, ${scene.mesh.vertices.toLocaleString("en")} vertices` : "";
  document.title = `${scene.name} · FaceZip`;
  byId("name").textContent = scene.name;
  byId("facts").textContent = `${scene.expressions.length} expressions, ${names}${tiles}${columns} × ${rows} texels${mesh}, method ${scene.method}`;
  if (isSingle()) byId("licences").removeAttribute("href");
}

const said = new Set<string>();

function say(text: string): void {
  if (!said.has(text)) byId("limits").append(element("li", {}, text));
  said.add(text);
}

/** What this GPU cannot do, and what is shown instead. */
function showLimits({ scene, renderer, head, originals, canvas }: Stage): void {
  const { maxTextureSize } = renderer.capabilities;
  if (head.scale < 1) say(`This GPU has no room for the textures: they are shown at 1/${1 / head.scale} of their size.`);
  if (scene.mesh && maxTextureSize < SHADOW_SIZE) say(`This GPU takes textures of up to ${maxTextureSize} texels: shadows are coarse.`);
  if (scene.originals && !originals) say("This GPU draws no floating-point numbers: the originals cannot be shown.");
  canvas.addEventListener("webglcontextlost", () => say("The GPU has stopped drawing; load the page again."));
}

const wordsOf = (error: unknown) => (error instanceof Error ? error.message : String(error));

start().catch((error: unknown) => {
  byId("status").textContent = `Cannot show the pack: ${wordsOf(error)}`;
  document.body.classList.add("failed");
});
