"use strict";

// The wipe: the original over the compressed picture, cut at the slider's position.
function bindWipe(card) {
  const frame = card.querySelector(".wipe .frame");
  if (!frame) return;
  const slider = frame.querySelector("input");
  const update = () => {
    frame.style.setProperty("--x", slider.value + "%");
    slider.setAttribute("aria-valuetext", slider.value + " % " + (slider.dataset.over || "original"));
  };
  slider.addEventListener("input", update);
  update();
  const blink = card.querySelector(".blink");
  blink.addEventListener("click", () => {
    const on = frame.classList.toggle("blinking");
    blink.setAttribute("aria-pressed", String(on));
  });
  bindZoom(card);
  borrow(card);
}

// All four pictures are magnified about one point, which follows the pointer or the arrow keys.
function bindZoom(card) {
  const [button, panels] = [card.querySelector(".zoom"), card.querySelector(".panels")];
  const point = { x: 50, y: 40 };
  let zoom = 1;
  const update = () => {
    panels.style.setProperty("--zoom", zoom);
    panels.style.setProperty("--at", point.x + "% " + point.y + "%");
    panels.classList.toggle("zoomed", zoom > 1);
    button.textContent = "Zoom " + zoom + "×";
  };
  const moveTo = (x, y) => {
    [point.x, point.y] = [x, y].map((value) => Math.min(100, Math.max(0, value)));
    update();
  };
  button.addEventListener("click", () => { zoom = zoom === 4 ? 1 : zoom * 2; update(); });
  button.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-4, 0], ArrowRight: [4, 0], ArrowUp: [0, -4], ArrowDown: [0, 4] }[event.key];
    if (!step || zoom === 1) return;
    event.preventDefault();
    moveTo(point.x + step[0], point.y + step[1]);
  });
  panels.addEventListener("pointermove", (event) => {
    const frame = event.target.closest(".frame");
    if (!frame || zoom === 1) return;
    const box = frame.getBoundingClientRect();
    const along = event.target.type === "range" ? point.x : (100 * (event.clientX - box.left)) / box.width;
    moveTo(along, (100 * (event.clientY - box.top)) / box.height);
  });
}

// The wipe shows the pictures of its neighbours, which are in the page once.
function borrow(card) {
  const [under, over] = [".under", ".over"].map((name) => card.querySelector(".wipe " + name + " img"));
  if (!under) return;
  under.src = card.querySelector("img.compressed").src;
  over.src = card.querySelector("img.original").src;
}

function bindChoice(card) {
  const source = card.querySelector(".card-data");
  if (!source) return;
  const data = JSON.parse(source.textContent);
  const image = (kind) => card.querySelector("img." + kind);
  const first = data.views[0];
  first.original = image("original").src;
  first.compressed[data.pack] = image("compressed").src;
  first.difference[data.pack] = image("difference").src;
  const [view, pack] = [card.querySelector(".choose-view"), card.querySelector(".choose-pack")];
  const show = () => {
    const chosen = data.views[view ? Number(view.value) : 0];
    const index = pack ? Number(pack.value) : data.pack;
    image("original").src = chosen.original;
    image("compressed").src = chosen.compressed[index];
    image("difference").src = chosen.difference[index];
    card.querySelector(".place").textContent = chosen.label;
    if (pack) card.querySelector(".chosen-pack").textContent = pack.options[index].text;
    borrow(card);
    showNumbers(card, chosen, index);
  };
  for (const select of [view, pack]) if (select) select.addEventListener("change", show);
}

function showNumbers(card, view, index) {
  const rows = [...card.querySelectorAll(".render-numbers tbody tr")];
  rows.forEach((row) => {
    const texts = row.dataset.pack === undefined ? view.floor : view.numbers[Number(row.dataset.pack)];
    row.classList.toggle("chosen", Number(row.dataset.pack) === index);
    row.querySelectorAll("td").forEach((cell, i) => { cell.textContent = texts[i]; });
  });
}

// Cards by their outcome, and by a part of their name.
function bindFilter(filter) {
  const [boxes, text] = [[...filter.querySelectorAll("[type=checkbox]")], filter.querySelector("[type=search]")];
  const cards = [...document.querySelectorAll(".card")];
  const update = () => {
    const shown = new Set(boxes.filter((box) => box.checked).map((box) => box.value));
    const part = text.value.trim().toLowerCase();
    for (const card of cards) {
      card.hidden = !shown.has(card.dataset.outcome) || !card.dataset.name.toLowerCase().includes(part);
    }
    const count = cards.filter((card) => !card.hidden).length;
    filter.querySelector("output").textContent = count + " of " + cards.length + " shown";
  };
  filter.addEventListener("input", update);
  update();
}

for (const filter of document.querySelectorAll(".filter")) bindFilter(filter);
for (const card of document.querySelectorAll(".card")) {
  bindChoice(card);
  bindWipe(card);
}
