// The section "View", the wipe, and the legend of what is shown.

import { byId, choice, element, toggle } from "./dom";
import type { Scene } from "./scene";
import { CHANGE_RANGE, ERROR_RANGE } from "./skin";
import type { Side, State, View } from "./state";

export function bindControls(scene: Scene, state: State): void {
  const slots = scene.difference_scale.length;
  const views: [View, string][] = [
    ["texture", "Skin"], ["weights", "Weights"], ["differences", "Differences"], ["change", "Change"],
    ...(scene.original ? [["error", "Error"] as [View, string]] : []), ["uv", "UV"],
  ];
  const view = choice("Show", views, state.view, (value) => state.set({ view: value }));
  const slot = choice("Map", Array.from({ length: slots }, (_, i) => [i, String(i + 1)] as const), 0, (value) => state.set({ slot: value }));
  const sides: [Side, string][] = [["compressed", "FaceZip"], ["wipe", "Wipe"], ["original", "Original"]];
  const side = choice("Side", sides, state.side, (value) => state.set({ side: value }));
  const light = choice("Light", [["lit", "Studio"], ["flat", "Flat"]], "lit", (value) => state.set({ lit: value === "lit" }));
  const surface = choice("Surface", [["head", "Head"], ["layout", "Layout"]], state.layout ? "layout" : "head", (value) => state.set({ layout: value === "layout" }));
  const wires = toggle("Wireframe", (on) => state.set({ wireframe: on }));
  const mipmaps = toggle("Mip-maps", (on) => state.set({ mipmaps: on }));
  const exact = toggle("Texel = pixel", (on) => state.set({ exact: on }));
  const toggles = element("div", { class: "toggles" }, wires.element, mipmaps.element, exact.element);
  surface.enable(!!scene.mesh);
  byId("view").append(view.element, slot.element, ...(scene.original ? [side.element] : []), light.element, surface.element, toggles);
  const show = () => {
    view.show(state.view);
    slot.show(state.slot);
    slot.enable(state.view === "weights" || state.view === "differences");
    side.show(state.side);
    side.enable(state.view === "texture" || state.view === "change");
    light.show(state.lit ? "lit" : "flat");
    light.enable(state.view === "texture" && !state.layout);
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
  const texts: Partial<Record<View, [string, string, string]>> = {
    weights: [`−${range}`, `weight ${state.slot + 1}`, range],
    differences: ["0", `difference ${state.slot + 1}, zero at ${zero}`, "255"],
    change: [`−${change}`, "change of 255", String(change)],
    error: ["0", "error of 255", String(Math.round(255 * ERROR_RANGE))],
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
    const comparable = state.view === "texture" || state.view === "change";
    const wiping = state.side === "wipe" && comparable;
    handle.hidden = !wiping;
    stage.style.setProperty("--wipe", `${100 * state.wipe}%`);
    handle.setAttribute("aria-valuenow", String(Math.round(100 * state.wipe)));
    handle.setAttribute("aria-valuetext", `${Math.round(100 * state.wipe)} % original`);
    byId("left-side").textContent = comparable && state.side !== "compressed" ? "Original" : "";
    byId("right-side").textContent = wiping ? "FaceZip" : "";
  });
}
