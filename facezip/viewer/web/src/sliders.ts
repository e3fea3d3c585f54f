// One slider an expression: in groups, and to be searched, where there are many.

import { byId, element } from "./dom";
import type { State } from "./state";

const MANY = 12;
const REGIONS: [string, RegExp][] = [
  ["Brows", /brow/i], ["Eyes", /eye|blink|wink|lid/i], ["Nose", /nose|sneer/i], ["Cheeks", /cheek/i],
  ["Jaw", /jaw|chin/i], ["Mouth", /mouth|lip|smil|smirk|pucker|funnel|grin|kiss/i], ["Tongue", /tongue/i],
];
const OTHER = "Whole face";

export class Sliders {
  private readonly rows: { row: HTMLElement; input: HTMLInputElement; output: HTMLOutputElement; name: string }[];
  private readonly groups: HTMLElement[] = [];

  constructor(private readonly state: State, expressions: string[], private readonly touched: () => void) {
    this.rows = expressions.map((name, n) => this.row(name, n));
    const place = byId("sliders");
    for (const [title, members] of grouped(expressions)) {
      const rows = members.map((n) => this.rows[n].row);
      const group = title ? element("section", { class: "group" }, element("h3", {}, title), ...rows) : element("div", {}, ...rows);
      this.groups.push(group);
      place.append(group);
    }
    const search = byId("search");
    search.hidden = expressions.length <= MANY;
    const field = search.querySelector("input")!;
    field.addEventListener("input", () => this.filter(field.value));
    state.onChange(() => this.show());
  }

  private row(name: string, n: number) {
    const input = element("input", { type: "range", min: 0, max: 1, step: 0.01, value: 0, id: `weight-${n}` });
    const output = element("output", { for: `weight-${n}` }, "0.00");
    const label = element("label", { for: `weight-${n}`, title: name }, name);
    input.addEventListener("input", () => {
      this.touched();
      this.state.setWeight(n, Number(input.value));
    });
    input.addEventListener("dblclick", () => this.state.setWeight(n, 0));
    return { row: element("div", { class: "slider" }, label, output, input), input, output, name };
  }

  private show(): void {
    this.rows.forEach(({ row, input, output }, n) => {
      const weight = this.state.weights[n];
      const text = weight.toFixed(2);
      if (output.textContent === text) return;
      output.textContent = text;
      input.value = String(weight);
      input.style.setProperty("--part", `${100 * weight}%`);
      row.classList.toggle("active", weight !== 0);
    });
  }

  private filter(text: string): void {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    for (const { row, name } of this.rows) row.hidden = !words.every((word) => name.toLowerCase().includes(word));
    for (const group of this.groups) group.hidden = !group.querySelector(".slider:not([hidden])");
    byId("none-found").hidden = this.groups.some((group) => !group.hidden);
  }
}

/** Titles and members; one group without a title where names are few or speak of no region. */
function grouped(names: string[]): [string, number[]][] {
  const all = [...names.keys()];
  const regionOf = (n: number) => REGIONS.find(([, pattern]) => pattern.test(names[n]))?.[0] ?? OTHER;
  const titles = [...REGIONS.map(([title]) => title), OTHER];
  const groups = titles.map((title): [string, number[]] => [title, all.filter((n) => regionOf(n) === title)]);
  const used = groups.filter(([, members]) => members.length);
  return names.length <= MANY || used.length < 2 ? [["", all]] : used;
}
