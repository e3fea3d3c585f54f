// What the page shows, in one place; whoever draws or lists it hears of every change.

/** All maps under light, on their own colours or on grey clay; one map as it is; and what it is made of. */
export type View = "skin" | "clay" | "flat" | "weights" | "differences" | "change" | "error" | "uv";
export type Side = "compressed" | "wipe" | "original";

/** Views that have an original side. */
export const COMPARABLE: View[] = ["skin", "clay", "flat", "change"];

export class State {
  /** Blendshape weights β, one an expression. */
  readonly weights: Float32Array<ArrayBuffer>;
  view: View = "skin";
  /** Which map, in the views of one. */
  map = 0;
  /** Which difference texture and channel of the weight maps. */
  slot = 0;
  side: Side = "compressed";
  /** Where the wipe stands, from 0 to 1 of the stage's width; the original is to its left. */
  wipe = 0.5;
  layout = false;
  wireframe = false;
  mipmaps = true;
  /** The layout at one texel a pixel. */
  exact = false;
  /** Counts the changes of the weights. */
  revision = 0;
  private readonly listeners: (() => void)[] = [];

  constructor(expressions: number) {
    this.weights = new Float32Array(expressions);
  }

  /** Whether all maps are shown under light. */
  get lit(): boolean {
    return !this.layout && (this.view === "skin" || this.view === "clay");
  }

  /** Whether a single map is seen: what is laid flat is never lit. */
  get showsMap(): boolean {
    return !this.lit && this.view !== "weights" && this.view !== "uv";
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  set(change: Partial<Pick<State, "view" | "map" | "slot" | "side" | "wipe" | "layout" | "wireframe" | "mipmaps" | "exact">>): void {
    Object.assign(this, change);
    this.changed();
  }

  showMap(map: number): void {
    this.set({ map, ...(this.showsMap ? {} : { view: "flat" }) });
  }

  setWeight(n: number, weight: number): void {
    this.weights[n] = weight;
    this.revision++;
    this.changed();
  }

  setWeights(weights: ArrayLike<number>): void {
    this.weights.set(weights);
    this.revision++;
    this.changed();
  }

  private changed(): void {
    for (const listener of this.listeners) listener();
  }
}
