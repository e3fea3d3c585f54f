// The section "View", the wipe, and the legend of what is shown.

import { byId, choice, element, toggle } from "./dom";
import { rolesOf } from "./head/skin";
import { ANGLE_RANGE, CHANGE_RANGE, ERROR_RANGE } from "./looks";
import type { Scene } from "./scene";
import type { Stage } from "./stage";
import { COMPARABLE, type Side, type State, type View } from "./state";

const NONE = -1;

/** What can be shown: clay where there is more than colours, errors where there are originals. */
export function viewsOf({ scene, originals }: Stage): [View, string][] {
  const { albedo, ...relief } = rolesOf(scene);
  const views: [View, string][] = [["skin", "Skin"], ["clay", "Clay"], ["flat", "Flat"], ["weights", "Weights"], ["differences", "Differences"], ["change", "Change"], ["error", "Error"], ["uv", "UV"]];
  return views.filter(([view]) => (view !== "clay" || (albedo !== undefined && Object.keys(relief).length)) && (view !== "error" || originals));
}

export function bindControls(stage: Stage, state: State): void {
  const { scene, originals } = stage;
  const view = choice("Show", viewsOf(stage), state.view, (value) => state.set({ view: value }));
  const map = choice("Map", scene.maps.map(({ name }, m) => [m, name] as const), NONE, (value) => state.showMap(value));
  const slot = choice("Slot", Array.from({ length: scene.slots }, (_, i) => [i, String(i + 1)] as const), 0, (value) => state.set({ slot: value }));
  const sides: [Side, string][] = [["compressed", "FaceZip"], ["wipe", "Wipe"], ["original", "Original"]];
  const side = choice("Side", sides, state.side, (value) => state.set({ side: value }));
  const surface = choice("Surface", [["head", "Head"], ["layout", "Layout"]], state.layout ? "layout" : "head", (value) => state.set({ layout: value === "layout" }));
  const wires = toggle("Wireframe", (on) => state.set({ wireframe: on }));
  const mipmaps = toggle("Mip-maps", (on) => state.set({ mipmaps: on }));
  const exact = toggle("Texel = pixel", (on) => state.set({ exact: on }));
  const toggles = element("div", { class: "toggles" }, wires.element, mipmaps.element, exact.element);
  surface.enable(!!scene.mesh);
  byId("view").append(view.element, ...(scene.maps.length > 1 ? [map.element] : []), slot.element, ...(originals ? [side.element] : []), surface.element, toggles);
  const show = () => {
    view.show(state.view);
    map.show(state.showsMap ? state.map : NONE);
    slot.show(state.slot);
    slot.enable(state.view === "weights" || state.view === "differences");
    side.show(state.side);
    side.enable(COMPARABLE.includes(state.view));
    surface.show(state.layout ? "layout" : "head");
    wires.show(state.wireframe);
    mipmaps.show(state.mipmaps);
    exact.show(state.exact);
    exact.element.classList.toggle("off", !state.layout);
    showLegend(scene, state);
  };
  state.onChange(show);
  bindWipe(state);
  show();
}

function showLegend(scene: Scene, state: State): void {
  const legend = byId("legend");
  const range = scene.weight_range.toFixed(2);
  const change = Math.round(255 * CHANGE_RANGE);
  const zero = Math.round(255 * scene.difference_zero);
  const { name, encoding } = scene.maps[state.map];
  const of = scene.maps.length > 1 ? ` of ${name}` : "";
  const texts: Partial<Record<View, [string, string, string]>> = {
    weights: [`−${range}`, `weight ${state.slot + 1}`, range],
    differences: ["0", `difference ${state.slot + 1}${of}, zero at ${zero}`, "255"],
    change: [`−${change}`, `change${of}, in 255`, String(change)],
    error: encoding === "normal" ? ["0°", `error${of}`, `${ANGLE_RANGE}°`] : ["0", `error${of}, in 255`, String(Math.round(255 * ERROR_RANGE))],
  };
  const text = texts[state.view];
  legend.dataset.view = text ? state.view : "";
  legend.querySelectorAll("span").forEach((span, k) => { span.textContent = text?.[k] ?? ""; });
}

function bindWipe(state: State): void {
  const [handle, stage] = [byId("wipe"), byId("stage")];
  const move = (share: number) => state.set({ wipe: Math.min(1, Math.max(0, share)) });
  handle.addEventListener("pointerdown", (event) => handle.setPointerCapture(event.pointerId));
  handle.addEventListener("pointermove", (event) => {
    const box = stage.getBoundingClientRect();
    if (handle.hasPointerCapture(event.pointerId)) move((event.clientX - box.left) / box.width);
  });
  handle.addEventListener("keydown", (event) => {
    const steps: Record<string, number> = { ArrowLeft: -0.02, ArrowDown: -0.02, ArrowRight: 0.02, ArrowUp: 0.02, PageDown: -0.1, PageUp: 0.1, Home: -1, End: 1 };
    if (!(event.key in steps)) return;
    event.preventDefault();
    move(state.wipe + steps[event.key]);
  });
  state.onChange(() => {
    const comparable = COMPARABLE.includes(state.view);
    const wiping = state.side === "wipe" && comparable;
    handle.hidden = !wiping;
    stage.style.setProperty("--wipe", `${100 * state.wipe}%`);
    handle.setAttribute("aria-valuenow", String(Math.round(100 * state.wipe)));
    handle.setAttribute("aria-valuetext", `${Math.round(100 * state.wipe)} % original`);
    byId("left-side").textContent = comparable && state.side !== "compressed" ? "Original" : "";
    byId("right-side").textContent = wiping ? "FaceZip" : "";
  });
}
