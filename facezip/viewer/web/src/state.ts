// What the page shows, in one place; whoever draws or lists it hears of every change.

export type View = "texture" | "weights" | "differences" | "change" | "error" | "uv";
export type Side = "compressed" | "wipe" | "original";

export class State {
  /** Blendshape weights β, one an expression. */
  readonly weights: Float32Array<ArrayBuffer>;
  view: View = "texture";
  /** Which difference texture and channel of the weight maps. */
  slot = 0;
  side: Side = "compressed";
  /** Where the wipe stands, from 0 to 1 of the stage's width; the original is to its left. */
  wipe = 0.5;
  lit = true;
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

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  set(change: Partial<Pick<State, "view" | "slot" | "side" | "wipe" | "lit" | "layout" | "wireframe" | "mipmaps" | "exact">>): void {
    Object.assign(this, change);
    this.changed();
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
