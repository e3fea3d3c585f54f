// Elements out of text, never out of markup: a name is shown, whatever is in it.

type Attributes = Record<string, string | number | boolean>;

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Attributes = {}, ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== false) made.setAttribute(name, value === true ? "" : String(value));
  }
  made.append(...children);
  return made;
}

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found as T;
}

/** A group of buttons of which one is pressed; arrow keys move among them, as in any radio group. */
export function choice<V extends string | number>(
  label: string, options: readonly (readonly [V, string])[], chosen: V, choose: (value: V) => void
): { element: HTMLElement; show(value: V): void; enable(on: boolean): void } {
  const name = `choice-${label}`.replaceAll(" ", "-");
  const inputs = options.map(([value]) => element("input", { type: "radio", name, value }));
  const labels = options.map(([, text], k) => element("label", {}, inputs[k], element("span", {}, text)));
  const group = element("fieldset", { class: "choice" }, element("legend", {}, label), element("div", {}, ...labels));
  inputs.forEach((input, k) => input.addEventListener("change", () => choose(options[k][0])));
  const show = (value: V) => inputs.forEach((input, k) => { input.checked = options[k][0] === value; });
  show(chosen);
  return { element: group, show, enable: (on) => { group.disabled = !on; } };
}

export function toggle(label: string, flip: (on: boolean) => void): { element: HTMLElement; show(on: boolean): void } {
  const input = element("input", { type: "checkbox" });
  input.addEventListener("change", () => flip(input.checked));
  const show = (on: boolean) => { input.checked = on; };
  return { element: element("label", { class: "toggle" }, input, element("span", {}, label)), show };
}
