// The hierarchy as rectangles within rectangles: a subtree's area is its share of the SAH cost.

import { childrenOf, nodeName, relativeCost, rootOf, worldArea } from "./tree.js";
import { css, tone } from "./colour.js";
import { counted, percent } from "./vector.js";

const SMALLEST = 3; // pixels: what is smaller is not divided further

export class Treemap {
  constructor(canvas, told) {
    this.canvas = canvas;
    this.told = told;
    this.cells = [];
    canvas.addEventListener("click", (e) => {
      const cell = this.at(e);
      if (cell) told.selected(cell.place);
    });
    canvas.addEventListener("pointermove", (e) => told.hovered(this.at(e)?.place ?? null));
    canvas.addEventListener("pointerleave", () => told.hovered(null));
  }

  /** What a place costs, in the same unit for all places of one scene. */
  weight(place) {
    const { scene, facts } = this;
    if (place.instance < 0 || place.node >= scene.nodes) return facts.cost[place.node];
    const tree = facts.treeOf[place.node], whole = facts.cost[scene.nodeOffset[tree]];
    return whole > 0 ? (facts.cost[place.node] / whole) * relativeCost(scene, facts.cost, tree) * worldArea(scene, place.instance) : 0;
  }

  /** `level`: steps below `top` that are told apart; `selected` is framed. */
  draw(scene, facts, top, level, selected) {
    Object.assign(this, { scene, facts, top, level });
    const canvas = this.canvas, ratio = devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * ratio);
    canvas.height = Math.round(canvas.clientHeight * ratio);
    const c = canvas.getContext("2d");
    c.scale(ratio, ratio);
    this.cells = [];
    c.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    if (!top) return;
    const root = { place: top, weight: this.weight(top), x: 0, y: 0, w: canvas.clientWidth, h: canvas.clientHeight, depth: 0, tint: 0.62, spread: 0.36 };
    const pending = [root];
    while (pending.length) {
      const cell = pending.pop();
      this.cells.push(cell);
      const children = cell.depth < level && Math.min(cell.w, cell.h) >= SMALLEST ? childrenOf(scene, cell.place) : [];
      if (!children.length || children.length > 4096) {
        c.fillStyle = css(tone(cell.tint).map((x) => x * (facts.depth[cell.place.node] % 2 ? 0.92 : 1)));
        c.fillRect(cell.x, cell.y, cell.w, cell.h);
        if (cell.w > 4 && cell.h > 4) {
          c.strokeStyle = "rgb(0 0 0 / 35%)";
          c.lineWidth = 0.5;
          c.strokeRect(cell.x + 0.25, cell.y + 0.25, cell.w - 0.5, cell.h - 0.5);
        }
        continue;
      }
      pending.push(...this.divided(cell, children));
    }
    const framed = this.cells.find((cell) => isSame(cell.place, selected));
    if (framed) {
      for (const [colour, width] of [["#000", 4], ["#ffd23f", 2]]) {
        c.strokeStyle = colour;
        c.lineWidth = width;
        c.strokeRect(framed.x + 1.5, framed.y + 1.5, Math.max(framed.w - 3, 2), Math.max(framed.h - 3, 2));
      }
    }
  }

  /** A cell's room, handed to children by their shares along its longer side. Halves by weight where they are many. */
  divided(cell, children) {
    const weighed = children.map((place) => ({ place, weight: this.weight(place) }));
    const out = [];
    const split = (items, x, y, w, h, tint, spread, depth) => {
      if (items.length === 1) {
        out.push({ ...items[0], x, y, w, h, depth, tint, spread });
        return;
      }
      const half = items.length >> 1, sum = (list) => list.reduce((total, item) => total + item.weight, 0);
      const [a, b] = [items.slice(0, half), items.slice(half)];
      const whole = sum(items), share = whole > 0 ? sum(a) / whole : 0.5;
      const hues = [tint - spread / 2, tint + spread / 2], next = spread * 0.62;
      if (w >= h) {
        split(a, x, y, w * share, h, hues[0], next, depth);
        split(b, x + w * share, y, w * (1 - share), h, hues[1], next, depth);
      } else {
        split(a, x, y, w, h * share, hues[0], next, depth);
        split(b, x, y + h * share, w, h * (1 - share), hues[1], next, depth);
      }
    };
    split(weighed, cell.x, cell.y, cell.w, cell.h, cell.tint, cell.spread, cell.depth + 1);
    return out;
  }

  /** The smallest cell under a pointer. */
  at(event) {
    const box = this.canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    let found = null;
    for (const cell of this.cells) {
      const holds = cell.x <= x && x < cell.x + cell.w && cell.y <= y && y < cell.y + cell.h;
      if (holds && (!found || cell.depth >= found.depth)) found = cell;
    }
    return found;
  }

  /** What the pointer is over, in words. */
  words(place) {
    const whole = this.weight(rootOf(this.scene)), share = whole > 0 ? this.weight(place) / whole : 0;
    return `${nodeName(this.scene, this.facts, place)}: ${percent(share)} of the SAH cost, `
      + counted(this.facts.below[place.node], "reference");
  }
}

export const isSame = (a, b) => a && b && a.node === b.node && a.instance === b.instance;
