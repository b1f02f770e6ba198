// What a pixel is drawn with. The shader has the same in GLSL: tables and constants are shared with it.

import { moveNormal, normalised, cross, subtract } from "./vector.js";
import { NODE_COST } from "./tree.js";

export const SHADES = { lit: 0, normal: 1, part: 2, instance: 3, depth: 4, nodes: 5, tests: 6, cost: 7 };
/** What the numbers of a scale count. */
export const UNITS = {
  depth: "depth of the leaf that was hit",
  nodes: "nodes entered by a ray",
  tests: "triangles tested by a ray",
  cost: "cost of a ray (1.2 × nodes + triangles)",
};
/** From little to much, and from less in B over equal to less in A. */
export const HEAT = [[13, 8, 58], [96, 25, 122], [190, 55, 92], [243, 139, 44], [252, 244, 176]];
export const DIVERGING = [[20, 92, 178], [120, 172, 220], [236, 236, 232], [234, 150, 90], [178, 48, 32]];
export const BACKGROUND = { light: [222, 226, 232], dark: [22, 24, 29] };

/** A surface that faces the camera, where the lamp stands. */
export const LIT = [232, 226, 214];

export function ramp(table, share) {
  const x = Math.min(Math.max(share, 0), 1) * (table.length - 1);
  const i = Math.min(Math.floor(x), table.length - 2), f = x - i;
  return [0, 1, 2].map((c) => table[i][c] * (1 - f) + table[i + 1][c] * f);
}

export const css = (rgb) => `rgb(${rgb.map(Math.round).join(" ")})`;

/** A colour of this hue, 0 to 1 and around again. */
export const tone = (h) => [0, 1 / 3, 2 / 3].map((k) => 255 * (0.35 + 0.6 * (0.5 + 0.5 * Math.cos(2 * Math.PI * (h - k)))));

/** Colours that differ for neighbouring numbers. */
export const hue = (number) => tone((number * 0.61803399 + 0.11) % 1);

/** What a shade measures for a pixel: `work` has inner nodes, tests and instances from `at` on. */
export function measured(shade, work, at, depth) {
  switch (shade) {
    case SHADES.depth: return depth;
    case SHADES.nodes: return work[at];
    case SHADES.tests: return work[at + 1];
    default: return NODE_COST * work[at] + work[at + 1];
  }
}

/** The normal of a triangle in world space, of length 1, to the side where its corners go counter-clockwise. */
export function normalOf(scene, triangle, instance) {
  const corner = (k) => Array.from(scene.corner.subarray(9 * triangle + 3 * k, 9 * triangle + 3 * k + 3));
  const [a, b, c] = [corner(0), corner(1), corner(2)];
  const n = cross(subtract(b, a), subtract(c, a));
  return normalised(instance >= 0 ? moveNormal(scene.toObject, 12 * instance, n) : n);
}

/** The colour of one pixel, 0 to 255 each. `hit` and `work` are four numbers a pixel, as the shader writes them. */
export function pixelColour(scene, facts, view, hit, work, at, forward) {
  const shade = view.shade, triangle = hit[at] - 1, instance = hit[at + 1] - 1;
  if (shade >= SHADES.nodes) return ramp(HEAT, measured(shade, work, at, 0) / view.most);
  if (triangle < 0) return BACKGROUND[view.theme];
  if (shade === SHADES.depth) return ramp(HEAT, facts.depth[hit[at + 3]] / view.most);
  const n = normalOf(scene, triangle, instance);
  if (shade === SHADES.normal) return n.map((x) => 255 * (0.5 + 0.45 * x));
  const facing = Math.abs(n[0] * forward[0] + n[1] * forward[1] + n[2] * forward[2]);
  if (shade === SHADES.lit) return LIT.map((x) => x * (0.25 + 0.75 * facing));
  const base = hue(shade === SHADES.part ? scene.geom[triangle] : instance < 0 ? 0 : scene.instanceId[instance]);
  return base.map((x) => x * (0.45 + 0.55 * facing));
}
