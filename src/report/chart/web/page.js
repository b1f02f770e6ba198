"use strict";
// A point shows the figures of its row where it stands, and both are lit together. Without this script the table says the same.
const tip = document.getElementById("tip");
let held = null;

function element(name, text) {
  const made = document.createElement(name);
  made.textContent = text;
  return made;
}

function light(section, row, isLit) {
  section.querySelectorAll(`[data-row="${row}"]`).forEach((one) => one.classList.toggle("lit", isLit));
}

function hide() {
  document.querySelectorAll(".lit").forEach((one) => one.classList.remove("lit"));
  tip.hidden = true;
}

function show(point) {
  hide();
  const section = point.closest("section");
  const row = section.querySelector(`tr[data-row="${point.dataset.row}"]`);
  if (!row) return;
  light(section, point.dataset.row, true);
  const heads = [...section.querySelectorAll("thead th")].map((head) => head.textContent);
  const cells = [...row.children].map((cell) => cell.textContent);
  const list = document.createElement("dl");
  cells.forEach((cell, i) => {
    if (i > 0 && cell) list.append(element("dt", heads[i]), element("dd", cell));
  });
  tip.replaceChildren(element("b", cells[0]), list);
  tip.hidden = false;
  // Beside the marker where there is room, else above or below it, and within the window in any case.
  const at = point.querySelector(".touch").getBoundingClientRect();
  const box = tip.getBoundingClientRect();
  const width = document.documentElement.clientWidth;
  let left = at.right + 6;
  let top = at.top;
  if (left + box.width > width - 8) left = at.left - box.width - 6;
  if (left < 8) {
    left = Math.max(8, Math.min(at.left, width - box.width - 8));
    top = at.bottom + 6;
    if (top + box.height > innerHeight && at.top - box.height - 6 > 0) top = at.top - box.height - 6;
  }
  tip.style.left = `${left + scrollX}px`;
  tip.style.top = `${top + scrollY}px`;
}

document.querySelectorAll(".point[data-row]").forEach((point) => {
  point.addEventListener("pointerenter", () => show(point));
  point.addEventListener("pointerleave", () => (held && held.isConnected ? show(held) : hide()));
  point.addEventListener("focus", () => { held = point; show(point); });
  point.addEventListener("blur", () => { held = null; hide(); });
  // A tap holds the point where it has no focus of its own.
  point.addEventListener("click", (event) => { held = point; show(point); event.stopPropagation(); });
});
document.querySelectorAll("tr[data-row]").forEach((row) => {
  const section = row.closest("section");
  row.addEventListener("pointerenter", () => { hide(); light(section, row.dataset.row, true); });
  row.addEventListener("pointerleave", () => (held ? show(held) : hide()));
});
document.addEventListener("click", () => { held = null; hide(); });
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") { held = null; hide(); }
  // From point to point in the order of the axis.
  const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  const here = document.activeElement;
  if (!step || !here || !here.classList.contains("point")) return;
  const place = (point) => point.querySelector(".touch").cx.baseVal.value;
  const all = [...here.closest("svg").querySelectorAll(".point[tabindex]")].sort((a, b) => place(a) - place(b));
  const next = all[all.indexOf(here) + step];
  if (next) { next.focus(); event.preventDefault(); }
});
