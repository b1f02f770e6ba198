// Lines over the picture: boxes of nodes, the ray that was picked.

import { onFilm } from "./camera.js";
import { add, scaled } from "./vector.js";
import { worldCorners } from "./tree.js";
import { css, hue } from "./colour.js";

const EDGES = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

export class Overlay {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  begin(film, ratio) {
    const { width, height } = this.canvas;
    this.film = film;
    this.ratio = ratio;
    this.context.clearRect(0, 0, width, height);
    this.context.lineJoin = "round";
  }

  /** The boxes of some places: each in a colour of its own if `colour` is null. */
  boxes(scene, places, colour, width) {
    const c = this.context;
    c.lineWidth = width * this.ratio;
    places.forEach((place, i) => {
      const corners = worldCorners(scene, place.node, place.instance);
      c.strokeStyle = colour ?? css(hue(i));
      c.beginPath();
      for (const [a, b] of EDGES) this.segment(corners[a], corners[b]);
      c.stroke();
    });
  }

  /** A ray up to its hit, or out of the scene. */
  ray(origin, direction, t, isHit, size) {
    const c = this.context, end = add(origin, scaled(direction, Number.isFinite(t) ? t : size * 2));
    for (const [colour, width] of [["#000", 4.5], ["#3fe0c5", 2]]) {
      c.strokeStyle = colour;
      c.lineWidth = width * this.ratio;
      c.beginPath();
      this.segment(origin, end);
      c.stroke();
    }
    this.dot(origin, "#3fe0c5", 4);
    if (isHit) this.dot(end, "#ffd23f", 5);
  }

  dot(p, colour, radius) {
    const at = this.place(p);
    if (!at) return;
    const c = this.context;
    c.beginPath();
    c.arc(at[0], at[1], radius * this.ratio, 0, 2 * Math.PI);
    c.fillStyle = colour;
    c.strokeStyle = "#000";
    c.lineWidth = 1.5 * this.ratio;
    c.fill();
    c.stroke();
  }

  pixel([x, y, ahead]) {
    return [((x / ahead + 1) / 2) * this.canvas.width, ((1 - y / ahead) / 2) * this.canvas.height];
  }

  place(p) {
    const at = onFilm(this.film, p);
    return at[2] > 1e-9 ? this.pixel(at) : null;
  }

  /** A line, cut where it comes from behind the camera. */
  segment(p, q) {
    let a = onFilm(this.film, p), b = onFilm(this.film, q);
    const close = 1e-4 * Math.max(Math.abs(a[2]), Math.abs(b[2]));
    if (a[2] < close && b[2] < close) return;
    const cut = (from, to) => {
      const f = (close - from[2]) / (to[2] - from[2]);
      return from.map((x, i) => x + f * (to[i] - x));
    };
    if (a[2] < close) a = cut(a, b);
    else if (b[2] < close) b = cut(b, a);
    const [from, to] = [this.pixel(a), this.pixel(b)];
    const far = 20000;
    if ([...from, ...to].some((x) => Math.abs(x) > far * 50)) return;
    this.context.moveTo(...from);
    this.context.lineTo(...to);
  }
}
