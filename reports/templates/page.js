"use strict";

// The wipe: the original over the compressed picture, cut at the slider's position.
function bindWipe(card) {
  const frame = card.querySelector(".wipe .frame");
  if (!frame) return;
  const slider = frame.querySelector("input");
  const update = () => {
    frame.style.setProperty("--x", slider.value + "%");
    slider.setAttribute("aria-valuetext", slider.value + " % original");
  };
  slider.addEventListener("input", update);
  update();
  const blink = card.querySelector(".blink");
  blink.addEventListener("click", () => {
    const on = frame.classList.toggle("blinking");
    blink.setAttribute("aria-pressed", String(on));
  });
  borrow(card);
}

// The wipe shows the pictures of its neighbours, which are in the page once.
function borrow(card) {
  const [under, over] = [".under", ".over"].map((name) => card.querySelector(".wipe " + name));
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

for (const card of document.querySelectorAll(".card")) {
  bindChoice(card);
  // Far cards wait until they come near, so that opening the page decodes what is on screen.
  const near = new IntersectionObserver((entries) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    near.disconnect();
    bindWipe(card);
  }, { rootMargin: "1200px" });
  near.observe(card);
}
