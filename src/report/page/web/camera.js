// A camera that flies and circles: a place, two angles, and how far ahead lies what it circles around.

import { add, cross, dot, length, normalised, scaled, subtract } from "./vector.js";

export class Camera {
  constructor(bounds, upAxis = 1) {
    this.bounds = bounds;
    this.upAxis = upAxis;
    this.fov = 55; // degrees across the longer side
    this.aspect = 1;
    this.whole();
  }

  /** Look at a box from above one of its corners. */
  whole(bounds = this.bounds) {
    const centre = scaled(add(bounds[0], bounds[1]), 0.5);
    const radius = Math.max(length(subtract(bounds[1], bounds[0])) / 2, 1e-6);
    this.yaw = (216 * Math.PI) / 180;
    this.pitch = -0.38;
    const half = Math.atan(Math.min(...this.halves()));
    this.reach = (radius / Math.sin(half)) * 0.95;
    this.eye = subtract(centre, scaled(this.forward(), this.reach));
    this.size = Math.max(length(subtract(this.bounds[1], this.bounds[0])), 1e-6);
  }

  /** Stand at a place and look at another. */
  lookAt(eye, target) {
    const f = normalised(subtract(target, eye)), u = this.upAxis;
    this.eye = [...eye];
    this.pitch = Math.asin(Math.min(Math.max(f[u], -0.9999), 0.9999));
    this.yaw = Math.atan2(f[(u + 2) % 3], f[(u + 1) % 3]);
    this.reach = Math.max(length(subtract(target, eye)), 1e-6);
    this.size = Math.max(length(subtract(this.bounds[1], this.bounds[0])), 1e-6);
  }

  forward() {
    const f = [0, 0, 0], u = this.upAxis;
    f[u] = Math.sin(this.pitch);
    f[(u + 1) % 3] = Math.cos(this.pitch) * Math.cos(this.yaw);
    f[(u + 2) % 3] = Math.cos(this.pitch) * Math.sin(this.yaw);
    return f;
  }

  /** What makes rays: the film reaches from -right to right and from -up to up. */
  film() {
    const forward = this.forward(), pole = [0, 0, 0];
    pole[this.upAxis] = 1;
    const side = normalised(cross(forward, pole)), high = cross(side, forward);
    const [across, along] = this.halves();
    return { eye: this.eye, forward, right: scaled(side, across), up: scaled(high, along) };
  }

  /** How far the film reaches at distance 1: to the right and upward. */
  halves() {
    const longer = Math.tan((this.fov * Math.PI) / 360);
    return this.aspect >= 1 ? [longer, longer / this.aspect] : [longer * this.aspect, longer];
  }

  turn(dx, dy) {
    this.yaw += dx;
    this.pitch = Math.min(Math.max(this.pitch + dy, -1.55), 1.55);
  }

  /** Turn around what lies ahead. */
  circle(dx, dy) {
    const pivot = add(this.eye, scaled(this.forward(), this.reach));
    this.turn(dx, dy);
    this.eye = subtract(pivot, scaled(this.forward(), this.reach));
  }

  /** Move along the own axes: right, up, ahead. */
  move(right, up, ahead) {
    const film = this.film();
    const axes = [normalised(film.right), normalised(film.up), film.forward];
    [right, up, ahead].forEach((by, i) => {
      this.eye = add(this.eye, scaled(axes[i], by));
    });
  }

  /** Go nearer to what lies ahead, or away from it. */
  zoom(factor) {
    const next = Math.max(this.reach * factor, this.size * 1e-5);
    this.eye = add(this.eye, scaled(this.forward(), this.reach - next));
    this.reach = next;
  }
}

/** Where a point stands on the film, x and y from -1 to 1, and how far ahead. */
export function onFilm(film, p) {
  const to = subtract(p, film.eye);
  const ahead = dot(to, film.forward);
  return [dot(to, film.right) / dot(film.right, film.right), dot(to, film.up) / dot(film.up, film.up), ahead];
}
