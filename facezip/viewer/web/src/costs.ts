// The section "Costs": memory and fetches, here and without FaceZip; and the frame time on this machine, when asked.

import { measureFrames } from "./bench";
import { byId, element } from "./dom";
import type { Scene } from "./scene";
import type { Stage } from "./stage";

const megabytes = (bytes: number) => `${(bytes / 1e6).toFixed(2)} MB`;

export function showCosts(scene: Scene, stage: Stage): void {
  const { costs, expressions, maps } = scene;
  const rows: [string, string, string][] = [
    ["GPU memory", megabytes(costs.bytes_on_gpu), megabytes(costs.bytes_raw)],
    ["Fetches a pixel", String(costs.fetches), String(maps.length * (expressions.length + 1))],
  ];
  const head = element("tr", {}, element("td"), element("th", { scope: "col" }, "FaceZip"), element("th", { scope: "col" }, "all textures"));
  const body = rows.map(([name, ours, theirs]) => element("tr", {}, element("th", { scope: "row" }, name), element("td", { class: "ours" }, ours), element("td", {}, theirs)));
  const times = ["Frame time", "–", "–"].map((text, k) => element(k ? "td" : "th", k ? {} : { scope: "row" }, text));
  times[1].className = "ours";
  const table = element("table", {}, element("thead", {}, head), element("tbody", {}, ...body, element("tr", {}, ...times)));
  const button = element("button", { id: "measure" }, "Measure frame time here");
  const note = element("p", { class: "muted", id: "measured", role: "status" }, "");
  const facts = [`On disk ${megabytes(costs.bytes_on_disk)}.`];
  const errors = maps.filter(({ error }) => error !== null).map(({ name, encoding, error }) => `${name} ${error!.toFixed(2)}${encoding === "normal" ? "°" : ""}`);
  if (errors.length) facts.push(`RMSE to the originals, of 255, and mean angle: ${errors.join(", ")}.`);
  byId("costs").append(table, element("p", { class: "muted" }, facts.join(" ")), button, note);
  button.addEventListener("click", async () => {
    button.disabled = true;
    note.textContent = "Measuring …";
    await new Promise((done) => setTimeout(done, 50));
    const found = measureFrames(stage);
    times[1].textContent = `${found.facezip_ms.toFixed(2)} ms`;
    times[2].textContent = `${found.all_ms.toFixed(2)} ms`;
    note.textContent = `${found.map}, ${found.size}² pixels, ${found.expressions} expressions at once: ${found.ratio.toFixed(2)} of the time of all textures, on ${found.device}`;
    button.disabled = false;
  });
}
