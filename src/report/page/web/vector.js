// Points and directions as arrays of three numbers, and affine maps as twelve: three rows of four, the fourth being the translation.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);

export function normalised(a) {
  const l = length(a);
  return l > 0 ? scaled(a, 1 / l) : [0, 0, 0];
}

/** A point moved by the map that stands in `m` from `at` on. */
export function movePoint(m, at, p) {
  const row = (r) => m[at + r] * p[0] + m[at + r + 1] * p[1] + m[at + r + 2] * p[2] + m[at + r + 3];
  return [row(0), row(4), row(8)];
}

/** A direction moved by the same map: its translation does not count. */
export function moveDirection(m, at, d) {
  const row = (r) => m[at + r] * d[0] + m[at + r + 1] * d[1] + m[at + r + 2] * d[2];
  return [row(0), row(4), row(8)];
}

/** A normal moved by the transposed linear part of the inverse map, `m`. */
export function moveNormal(m, at, n) {
  const column = (c) => m[at + c] * n[0] + m[at + 4 + c] * n[1] + m[at + 8 + c] * n[2];
  return [column(0), column(1), column(2)];
}

/** A number as people read it: thousands apart, or few digits. */
export function figure(x) {
  if (!Number.isFinite(x)) return "–";
  if (Number.isInteger(x)) return x.toLocaleString("en");
  const size = Math.abs(x);
  if (size >= 1000) return Math.round(x).toLocaleString("en");
  if (size >= 0.001) return String(Number(x.toPrecision(3)));
  return x.toExponential(1);
}

/** A share as percent, in three digits. */
export function percent(share) {
  if (!Number.isFinite(share)) return "–";
  if (share > 0 && share < 1e-5) return "under 0.001 %";
  return `${figure(Number((100 * share).toPrecision(3)))} %`;
}

/** "1 triangle", "2 triangles". */
export const counted = (n, one, many = one + "s") => `${figure(n)} ${n === 1 ? one : many}`;
