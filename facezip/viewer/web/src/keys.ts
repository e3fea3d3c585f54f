// Single keys, for those who keep their hands there; listed on the page.

import { byId, element } from "./dom";
import type { Stage } from "./stage";
import type { Poses } from "./poses";
import { viewsOf } from "./controls";
import type { Side, State } from "./state";

const SIDES: Side[] = ["compressed", "wipe", "original"];

export function bindKeys(state: State, stage: Stage, poses: Poses): void {
  const { maps, slots, mesh } = stage.scene;
  const next = <T>(all: T[], now: T) => all[(all.indexOf(now) + 1) % all.length];
  const views = viewsOf(stage).map(([view]) => view);
  const keys: [string, string, () => void][] = [
    ["P", "play or pause", () => poses.toggle()],
    ["N", "neutral", () => poses.neutral()],
    ["R", "random pose", () => poses.random()],
    ["V", "next view", () => state.set({ view: next(views, state.view) })],
    ...(maps.length > 1 ? [["M", "next map", () => state.showMap((state.map + 1) % maps.length)] as [string, string, () => void]] : []),
    ["S", "next slot", () => state.set({ slot: (state.slot + 1) % slots })],
    ...(stage.originals ? [["C", "FaceZip, wipe, original", () => state.set({ side: next(SIDES, state.side) })] as [string, string, () => void]] : []),
    ["L", "skin or flat map", () => state.set({ view: state.view === "flat" ? "skin" : "flat" })],
    ...(mesh ? [["U", "head or UV layout", () => state.set({ layout: !state.layout })] as [string, string, () => void]] : []),
    ["W", "wireframe", () => state.set({ wireframe: !state.wireframe })],
    ["H", "camera home", () => stage.orbit.reset()],
    ["/", "search", () => byId("search").querySelector("input")!.focus()],
  ];
  const list = byId("keys").querySelector("dl")!;
  for (const [key, what] of [...keys, ["← → ↑ ↓ + −", "turn and zoom, with the head in focus"]]) {
    list.append(element("div", {}, element("dt", {}, element("kbd", {}, key)), element("dd", {}, what)));
  }
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target)) return;
    const found = keys.find(([key]) => key === event.key.toUpperCase());
    if (!found) return;
    event.preventDefault();
    found[2]();
  });
}

function isTyping(target: EventTarget | null): boolean {
  return target instanceof HTMLSelectElement || (target instanceof HTMLInputElement && ["search", "text"].includes(target.type));
}
