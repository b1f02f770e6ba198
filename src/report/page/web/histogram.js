// How many pixels cost how much, under the picture: bars whose colours are those of the scale.

import { DIVERGING, HEAT, SHADES, css, measured, ramp } from "./colour.js";
import { figure } from "./vector.js";

const BINS = 48;

/** A number not smaller than this that reads well: 1, 2, 3, 4, 5, 6 or 8 times a power of ten. */
export function roundedUp(x) {
  if (!(x > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(x));
  for (const step of [1, 2, 3, 4, 5, 6, 8, 10]) if (step * power >= x * 0.999999) return step * power;
  return 10 * power;
}

/** Whether a ray had anything to do: rays beside the scene say nothing of its tree. */
export const hasWorked = (read, at) => read.work[at] > 0 || read.work[at + 1] > 0;

/** What a shade measured over a picture: of depths for pixels that hit something, of work for rays that had any. */
export function valuesOf(facts, shade, read) {
  const pixels = read.width * read.height, out = new Float64Array(pixels);
  let n = 0;
  for (let i = 0; i < pixels; i++) {
    if (shade === SHADES.depth) {
      if (read.hit[4 * i]) out[n++] = facts.depth[read.hit[4 * i + 3]];
    } else if (hasWorked(read, 4 * i)) out[n++] = measured(shade, read.work, 4 * i, 0);
  }
  return out.subarray(0, n);
}

/** What B costs more than A in each pixel whose ray had work in either. */
export function differencesOf(shade, [a, b]) {
  const out = [];
  for (let at = 0; at < a.work.length; at += 4) {
    if (hasWorked(a, at) || hasWorked(b, at)) out.push(measured(shade, b.work, at, 0) - measured(shade, a.work, at, 0));
  }
  return Float64Array.from(out);
}

export function summary(values) {
  if (!values.length) return { mean: 0, most: 0, high: 0, median: 0 };
  const sorted = Float64Array.from(values).sort();
  const at = (share) => sorted[Math.min(Math.floor(share * sorted.length), sorted.length - 1)];
  return { mean: values.reduce((a, b) => a + b, 0) / values.length, median: at(0.5), high: at(0.99), most: sorted[sorted.length - 1] };
}

/** Draw bars from `low` to `high`; what lies beyond stands in the last one. */
export function drawHistogram(canvas, values, low, high, ink) {
  const ratio = devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const c = canvas.getContext("2d");
  c.scale(ratio, ratio);
  const bins = new Uint32Array(BINS);
  for (const v of values) bins[Math.min(Math.max(Math.floor(((v - low) / (high - low)) * BINS), 0), BINS - 1)]++;
  const most = Math.max(...bins, 1), colours = low < 0 ? DIVERGING : HEAT, top = 14;
  const room = height - top - 1;
  for (let i = 0; i < BINS; i++) {
    // The root of a share is drawn, so that few expensive pixels are seen beside many cheap ones.
    const bar = bins[i] ? Math.max(Math.sqrt(bins[i] / most) * room, 1.5) : 0;
    c.fillStyle = css(ramp(colours, (i + 0.5) / BINS));
    c.fillRect((i * width) / BINS + 0.5, height - 1 - bar, width / BINS - 1, bar);
    c.strokeStyle = ink;
    c.globalAlpha = 0.35;
    if (bar) c.strokeRect((i * width) / BINS + 0.5, height - 1 - bar, width / BINS - 1, bar);
    c.globalAlpha = 1;
  }
  c.strokeStyle = ink;
  c.beginPath();
  c.moveTo(0, height - 0.5);
  c.lineTo(width, height - 0.5);
  c.stroke();
  return bins;
}

/** The scale: a strip of colours with five numbers below it. */
export function drawScale(strip, labels, low, high, isOpen) {
  const colours = low < 0 ? DIVERGING : HEAT;
  strip.style.background = `linear-gradient(to right, ${colours.map(css).join(", ")})`;
  const numbers = [0, 1, 2, 3, 4].map((i) => low + ((high - low) * i) / 4);
  const sign = low < 0 ? (x) => (x > 0 ? "+" : "") : () => "";
  labels.replaceChildren(...numbers.map((x, i) => {
    const span = document.createElement("span");
    span.textContent = sign(x) + figure(x) + (isOpen && i === 4 ? " or more" : "");
    return span;
  }));
}
