// Pictures without a GPU: workers trace rows of pixels, and this side shades them.

import { Tracer } from "./trace.js";
import { add, normalised, scaled } from "./vector.js";
import { DIVERGING, SHADES, measured, pixelColour, ramp } from "./colour.js";

const BAND = 8; // rows that a worker traces at once

/** The ray through a place on the film, which goes from -1 to 1 both ways, upward. Its numbers are those of single precision, as in the shader. */
export function filmRay(camera, x, y) {
  const d = normalised(add(camera.forward, add(scaled(camera.right, x), scaled(camera.up, y))));
  return [camera.eye.map(Math.fround), d.map(Math.fround)];
}

/** Trace rows of a picture; four numbers a pixel in `hit` and in `work`, as the shader writes them. */
export function traceRows(tracer, job, root, from, rows) {
  const hit = new Uint32Array(4 * rows * job.width), work = new Uint32Array(hit.length);
  const options = { root, order: job.order, brute: job.brute };
  const distance = new Float32Array(1), bits = new Uint32Array(distance.buffer);
  for (let row = 0, at = 0; row < rows; row++) {
    for (let x = 0; x < job.width; x++, at += 4) {
      const [o, d] = filmRay(job.camera, (2 * (x + 0.5)) / job.width - 1, (2 * (from + row + 0.5)) / job.height - 1);
      tracer.trace(o, d, options);
      work[at] = tracer.inner;
      work[at + 1] = tracer.tests;
      work[at + 2] = tracer.entered;
      if (tracer.triangle < 0) continue;
      distance[0] = tracer.t;
      hit[at] = tracer.triangle + 1;
      hit[at + 1] = tracer.instance + 1;
      hit[at + 2] = bits[0];
      hit[at + 3] = tracer.leaf;
    }
  }
  return { hit, work };
}

/** What runs in a worker. */
export function serve(scope) {
  const tracers = new Map();
  scope.onmessage = ({ data }) => {
    if (data.scene) tracers.set(data.key, new Tracer(data.scene, data.facts));
    else {
      const rows = traceRows(tracers.get(data.key), data.job, data.root, data.from, data.rows);
      scope.postMessage({ ...rows, id: data.id, layer: data.layer, from: data.from }, [rows.hit.buffer, rows.work.buffer]);
    }
  };
}

export class CpuRenderer {
  /** `code` is the script of the page, which a worker runs as well. */
  constructor(canvas, code) {
    this.context = canvas.getContext("2d");
    this.canvas = canvas;
    const many = Math.min(Math.max((navigator.hardwareConcurrency || 2) - 1, 1), 4);
    this.name = many > 1 ? `CPU (${many} workers)` : "CPU (one worker)";
    const url = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
    this.workers = Array.from({ length: many }, () => {
      // A page that was opened as a file may start no worker of the kind "module".
      const worker = new Worker(url);
      worker.onmessage = ({ data }) => this.take(worker, data);
      worker.onerror = (event) => this.failed?.(new Error(event.message || "a worker cannot start"));
      return worker;
    });
    this.idle = new Set(this.workers);
    this.keys = 0;
    this.id = 0;
    this.layers = [];
  }

  load(scene, facts) {
    const key = this.keys++;
    for (const worker of this.workers) worker.postMessage({ key, scene, facts });
    return { key, scene, facts };
  }

  start(job) {
    const size = 4 * job.width * job.height;
    this.job = { ...job, id: ++this.id, layer: 0, row: 0, left: 0, ms: job.loaded.map(() => 0), began: performance.now() };
    for (let i = 0; i < job.loaded.length; i++) this.job.left += Math.ceil(job.height / BAND);
    this.layers = job.loaded.map(() => ({ width: job.width, height: job.height, hit: new Uint32Array(size), work: new Uint32Array(size) }));
    for (const worker of [...this.idle]) this.give(worker);
  }

  give(worker) {
    const job = this.job;
    if (job.layer >= job.loaded.length) {
      this.idle.add(worker);
      return;
    }
    this.idle.delete(worker);
    const rows = Math.min(BAND, job.height - job.row), { layer, row } = job;
    const { camera, width, height, order, brute } = job;
    worker.postMessage({
      id: job.id, layer, from: row, rows, key: job.loaded[layer].key, root: job.roots[layer], job: { camera, width, height, order, brute },
    });
    job.row += rows;
    if (job.row >= job.height) {
      job.layer++;
      job.row = 0;
    }
  }

  take(worker, data) {
    const job = this.job;
    if (data.id === job.id) {
      const layer = this.layers[data.layer];
      layer.hit.set(data.hit, 4 * data.from * job.width);
      layer.work.set(data.work, 4 * data.from * job.width);
      job.ms[data.layer] = performance.now() - job.began - (data.layer ? job.ms[0] : 0);
      job.left--;
    }
    this.give(worker);
    this.wake?.();
  }

  /** Wait for about so long. True when the picture is whole. */
  async step(budget) {
    if (this.job.left > 0) {
      await new Promise((resolve) => {
        const timer = setTimeout(resolve, budget);
        this.wake = () => {
          if (this.job.left > 0) return;
          clearTimeout(timer);
          resolve();
        };
      });
    }
    return this.job.left <= 0;
  }

  read(i) {
    return this.layers[i];
  }

  shade(view) {
    const { width: w, height: h } = this.canvas, job = this.job;
    if (!job || !w || !h) return;
    const image = this.context.createImageData(w, h), two = this.layers.length > 1;
    const differs = two && view.mode === "difference" && view.shade >= SHADES.nodes;
    for (let y = 0, out = 0; y < h; y++) {
      const row = Math.floor(((h - 1 - y + 0.5) * job.height) / h);
      for (let x = 0; x < w; x++, out += 4) {
        const at = 4 * (row * job.width + Math.floor(((x + 0.5) * job.width) / w));
        let rgb;
        if (differs) {
          const of = (i) => measured(view.shade, this.layers[i].work, at, 0);
          rgb = ramp(DIVERGING, 0.5 + (0.5 * (of(1) - of(0))) / view.most);
        } else {
          const i = !two ? 0 : view.mode === "b" || (view.mode === "split" && x >= Math.round(w * view.split)) ? 1 : 0;
          const { scene, facts } = job.loaded[i];
          rgb = pixelColour(scene, facts, view, this.layers[i].hit, this.layers[i].work, at, job.camera.forward);
        }
        image.data[out] = rgb[0];
        image.data[out + 1] = rgb[1];
        image.data[out + 2] = rgb[2];
        image.data[out + 3] = 255;
      }
    }
    this.context.putImageData(image, 0, 0);
  }
}
