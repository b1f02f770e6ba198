// When pictures are made: a coarse one at once after each change, a whole one when the hand rests.

import { SHADES } from "./colour.js";
import { differencesOf, roundedUp, summary, valuesOf } from "./histogram.js";

const MOVING_MS = 35; // that a coarse picture may take
const WHOLE_MS = 4000; // that a whole one may take; beyond it, pixels are traced in squares
const REST_MS = 140; // without a change, until the whole picture is begun

export class View {
  /** `told.shaded(result)` after each picture is drawn. */
  constructor(renderer, canvas, told) {
    this.renderer = renderer;
    this.canvas = canvas;
    this.told = told;
    renderer.failed = told.failed;
    this.version = 0;
    this.coarse = 0.25;
    this.perPixel = null; // milliseconds, measured
    this.whole = null; // the last whole picture's numbers
    this.setting = null;
    this.run();
  }

  /** Something that rays depend on is different. */
  touch(setting) {
    if (setting) this.setting = setting;
    this.version++;
    this.touched = performance.now();
    this.whole = null;
    this.wake?.();
  }

  /** Only colours are different. */
  recolour() {
    this.coloured = true;
    this.wake?.();
  }

  async run() {
    let shown = -1, isWhole = false;
    for (;;) {
      if (this.coloured && shown >= 0) {
        this.coloured = false;
        this.finish(isWhole);
      }
      if (!this.setting || (shown === this.version && isWhole)) {
        await new Promise((resolve) => { this.wake = resolve; });
        this.wake = null;
        continue;
      }
      const wanted = this.version;
      try {
        if (shown !== wanted) {
          await this.trace(this.coarse, wanted, true);
          const ms = Math.max(this.ms, 1);
          this.perPixel = ms / this.pixels;
          this.coarse = Math.min(Math.max(this.coarse * Math.sqrt(MOVING_MS / ms), 0.06), 1);
          [shown, isWhole] = [wanted, false];
          this.finish(false);
          await frame();
        } else {
          const rest = this.touched + REST_MS - performance.now();
          if (rest > 0) await new Promise((resolve) => setTimeout(resolve, rest));
          if (this.version !== wanted) continue;
          const area = this.canvas.width * this.canvas.height;
          const scale = Math.min(1, Math.max(0.06, Math.sqrt(WHOLE_MS / (this.perPixel * area))));
          if (!(await this.trace(scale, wanted, false))) {
            shown = -1; // what was traced is of two sizes
            continue;
          }
          this.perPixel = this.ms / this.pixels;
          // What a few pixels cost says little: where there was time for more, they are traced again.
          isWhole = scale === 1 || this.ms > WHOLE_MS / 3;
          this.whole = this.measure();
          this.finish(true, isWhole);
        }
      } catch (error) {
        this.told.failed(error);
        [shown, isWhole] = [wanted, true];
      }
    }
  }

  /** False where the setting changed on the way. A coarse picture is made in any case. */
  async trace(scale, wanted, always) {
    const { width, height } = this.canvas;
    const size = [width, height].map((x) => Math.max(1, Math.round(x * scale)));
    this.pixels = size[0] * size[1] * this.setting.loaded.length;
    this.renderer.start({ ...this.setting, camera: this.setting.camera(), width: size[0], height: size[1] });
    while (!(await this.renderer.step(always ? 200 : 30))) {
      if (!always && this.version !== wanted) return false;
      await frame();
    }
    this.size = size;
    this.ms = this.renderer.job.ms.reduce((a, b) => a + b, 0);
    return true;
  }

  measure() {
    return { reads: this.setting.loaded.map((_, i) => this.renderer.read(i)), ms: [...this.renderer.job.ms], size: this.size };
  }

  finish(isWhole, isLast = isWhole) {
    const look = this.told.look();
    if (isWhole && this.whole) this.judge(look);
    this.renderer.shade({ ...look, most: this.most ?? 1 });
    this.told.shaded({ isWhole: isWhole && this.whole !== null, isLast, ms: this.renderer.job.ms, size: this.size });
  }

  /** Numbers under the picture, and the top of the scale. */
  judge(look) {
    const shade = look.shade >= SHADES.depth ? look.shade : SHADES.cost;
    const values = this.whole.reads.map((read, i) => valuesOf(look.facts[i], shade, read));
    const used = look.mode === "a" ? [0] : look.mode === "b" ? [1] : values.map((_, i) => i);
    this.figures = values.map(summary);
    this.differs = values.length > 1 && look.mode === "difference" && shade >= SHADES.nodes;
    if (this.differs) {
      this.values = differencesOf(shade, this.whole.reads);
      this.difference = summary(this.values);
      const sizes = summary(this.values.map(Math.abs));
      this.most = roundedUp(sizes.high);
      this.isOpen = sizes.most > this.most;
    } else {
      const shown = used.filter((i) => values[i]);
      this.values = shown.length === 1 ? values[shown[0]] : Float64Array.from(shown.flatMap((i) => [...values[i]]));
      this.most = roundedUp(shade === SHADES.depth ? Math.max(...shown.map((i) => this.figures[i].most)) : Math.max(...shown.map((i) => this.figures[i].high)));
      this.isOpen = Math.max(...shown.map((i) => this.figures[i].most)) > this.most;
    }
  }
}

const frame = () => new Promise((resolve) => (document.hidden ? setTimeout(resolve, 16) : requestAnimationFrame(resolve)));
