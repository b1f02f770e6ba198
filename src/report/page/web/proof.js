// What was traced, held against the traversal in double precision: for tests, and for whoever doubts a picture.

import { filmRay } from "./cpu.js";
import { Tracer } from "./trace.js";
import { writeRay } from "./ray_panel.js";

/** The ray through a place of the film, as text. */
export function rayText(film, x, y) {
  const [origin, direction] = filmRay(film, x, y);
  return writeRay({ origin, direction });
}

/** About so many pixels of the last whole picture, traced again: how many show another triangle, and the renderer's work over that of the CPU. */
export function compared(view, layer, { scene, facts }, root, most) {
  const { width, height, hit, work } = view.whole.reads[layer], { camera, order, brute } = view.renderer.job;
  const tracer = new Tracer(scene, facts), out = { pixels: 0, hits: 0, work: 0 };
  const step = Math.max(1, Math.ceil(Math.sqrt((width * height) / most)));
  let its = 0, own = 0;
  for (let y = 0; y < height; y += step) {
    for (let x = 0; x < width; x += step) {
      const at = 4 * (y * width + x);
      tracer.trace(...filmRay(camera, (2 * (x + 0.5)) / width - 1, (2 * (y + 0.5)) / height - 1), { root, order, brute });
      out.pixels++;
      if (hit[at] - 1 !== tracer.triangle && !isCopy(scene, hit[at] - 1, tracer.triangle)) out.hits++;
      its += work[at] + work[at + 1];
      own += tracer.inner + tracer.tests;
    }
  }
  out.work = own > 0 ? its / own : 1;
  return out;
}

/** Copies of one triangle in several leaves are one. */
const isCopy = (scene, a, b) => a >= 0 && b >= 0 && scene.geom[a] === scene.geom[b] && scene.prim[a] === scene.prim[b];
