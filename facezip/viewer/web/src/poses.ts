// Named poses, a random one, and the animation through all of them.

import { byId, element } from "./dom";
import type { Scene } from "./scene";
import type { State } from "./state";

const SECONDS_A_POSE = 1.6;
const GLIDE_SECONDS = 0.35;

interface Pose { name: string; weights: Float32Array }

export const prefersCalm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;

export class Poses {
  private readonly poses: Pose[];
  private readonly select = byId<HTMLSelectElement>("pose");
  private readonly time = byId<HTMLInputElement>("time");
  private readonly play = byId<HTMLButtonElement>("play");
  private gliding = 0;

  constructor(private readonly state: State, scene: Scene) {
    this.poses = posesOf(scene);
    this.select.append(element("option", { value: "" }, "Pose …"), ...this.poses.map(({ name }, k) => element("option", { value: k }, name)));
    this.select.addEventListener("change", () => {
      const pose = this.poses[Number(this.select.value)];
      if (this.select.value && pose) this.glide(pose.weights);
      this.select.value = "";
    });
    byId("neutral").addEventListener("click", () => this.neutral());
    byId("random").addEventListener("click", () => this.random());
    this.play.addEventListener("click", () => this.toggle());
    this.time.max = String(this.poses.length);
    this.time.addEventListener("input", () => {
      this.stop();
      this.showTime(Number(this.time.value));
    });
  }

  neutral(): void {
    this.glide(new Float32Array(this.state.weights.length));
  }

  /** Two or three expressions at once, whose weights sum to at most 1.2. */
  random(): void {
    const weights = new Float32Array(this.state.weights.length);
    const count = Math.min(weights.length, 2 + Math.floor(2 * Math.random()));
    const chosen = [...weights.keys()].sort(() => Math.random() - 0.5).slice(0, count);
    for (const n of chosen) weights[n] = Math.round((40 + 60 * Math.random()) * (1.2 / count)) / 100;
    this.glide(weights);
  }

  toggle(): void {
    if (this.playing) this.stop();
    else this.start();
  }

  stop(): void {
    cancelAnimationFrame(this.gliding);
    this.gliding = 0;
    this.play.setAttribute("aria-pressed", "false");
  }

  private get playing(): boolean {
    return this.play.getAttribute("aria-pressed") === "true";
  }

  private start(): void {
    this.stop();
    this.play.setAttribute("aria-pressed", "true");
    let last = performance.now();
    let time = Number(this.time.value);
    const step = (now: number) => {
      // A frame's time is that of its beginning, which may lie before the click.
      const passed = Math.min(Math.max(now - last, 0), 100);
      time = (time + passed / 1000 / SECONDS_A_POSE) % this.poses.length;
      last = now;
      this.time.value = String(time);
      this.showTime(time);
      this.gliding = requestAnimationFrame(step);
    };
    this.gliding = requestAnimationFrame(step);
  }

  // Each pose is reached in the middle of its time, and left again.
  private showTime(time: number): void {
    const at = Math.min(Math.floor(time), this.poses.length - 1);
    const rise = 0.5 - 0.5 * Math.cos(2 * Math.PI * (time - at));
    this.time.setAttribute("aria-valuetext", this.poses[at].name);
    this.state.setWeights(this.poses[at].weights.map((weight) => weight * rise));
  }

  private glide(target: Float32Array): void {
    this.stop();
    if (prefersCalm()) return this.state.setWeights(target);
    const from = this.state.weights.slice();
    const begin = performance.now();
    const step = (now: number) => {
      const t = Math.min(1, (now - begin) / 1000 / GLIDE_SECONDS);
      const eased = t * t * (3 - 2 * t);
      this.state.setWeights(t === 1 ? target : target.map((weight, n) => from[n] + eased * (weight - from[n])));
      this.gliding = t < 1 ? requestAnimationFrame(step) : 0;
    };
    this.gliding = requestAnimationFrame(step);
  }
}

function posesOf({ poses, expressions }: Scene): Pose[] {
  return poses.map(({ name, weights }) => {
    const all = new Float32Array(expressions.length);
    for (const [n, weight] of weights) all[n] = weight;
    return { name, weights: all };
  });
}
