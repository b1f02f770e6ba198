// Pictures by WebGL2: records as textures of integers, one pass that traces and one that shades.

import { CORNERS, DIFFERENCE, SHADING, WIDTH, tracing } from "./shaders.js";
import { SHADES } from "./colour.js";

const BAND_MS = 40; // work that is handed to the GPU at once: it must not seem to hang

export class GpuRenderer {
  /** Null where the browser has no WebGL2. */
  static on(canvas) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true });
    return gl && new GpuRenderer(gl);
  }

  constructor(gl) {
    this.gl = gl;
    this.name = "GPU (WebGL2)";
    this.bandRows = 8;
    this.layers = [];
    this.shading = program(gl, SHADING);
    this.difference = program(gl, DIFFERENCE);
    gl.bindVertexArray(gl.createVertexArray());
  }

  /** Put the records of a scene on the GPU. Throws where they are more than its textures can hold. */
  load(scene, facts) {
    const gl = this.gl, { total, nodes, triangles, instances } = scene;
    const node = new Uint32Array(texels(2 * total));
    const box = new Uint32Array(scene.box.buffer);
    for (let n = 0; n < total; n++) {
      node.set(box.subarray(6 * n, 6 * n + 3), 8 * n);
      node.set(box.subarray(6 * n + 3, 6 * n + 6), 8 * n + 4);
      node[8 * n + 3] = scene.first[n];
      node[8 * n + 7] = scene.count[n] | (facts.depth[n] << 8);
    }
    const triangle = new Uint32Array(texels(3 * triangles));
    const corner = new Uint32Array(scene.corner.buffer);
    for (let i = 0; i < triangles; i++) {
      for (let k = 0; k < 3; k++) triangle.set(corner.subarray(9 * i + 3 * k, 9 * i + 3 * k + 3), 12 * i + 4 * k);
      triangle[12 * i + 3] = scene.prim[i];
      triangle[12 * i + 7] = scene.geom[i];
    }
    const instance = new Uint32Array(texels(8 * instances));
    const floats = new Float32Array(instance.buffer);
    for (let i = 0; i < instances; i++) {
      const tree = scene.instanceTree[i];
      floats.set(scene.toWorld.subarray(12 * i, 12 * i + 12), 32 * i);
      floats.set(scene.toObject.subarray(12 * i, 12 * i + 12), 32 * i + 12);
      instance.set([scene.nodeOffset[tree], scene.instanceId[i], scene.refOffset[tree], scene.refCount[tree]], 32 * i + 24);
    }
    const deepest = facts.deepest;
    const stack = deepest.trees + deepest.top + (scene.twoLevel ? deepest.instancesInLeaf : 0) + 2;
    return {
      scene,
      textures: [node, triangle, instance].map((data) => records(gl, data)),
      tracing: program(gl, tracing(stack, scene.twoLevel)),
      nodes, triangles, instances,
    };
  }

  /** Begin a picture; `step` goes on with it. `job`: loaded (one or two), roots, camera, width, height, order, brute. */
  start(job) {
    const { width, height } = job;
    for (let i = 0; i < job.loaded.length; i++) {
      const layer = this.layers[i];
      if (layer && layer.width >= width && layer.height >= height) continue;
      if (layer) this.drop(layer);
      this.layers[i] = this.layer(width, height);
    }
    this.job = { ...job, layer: 0, row: 0, ms: job.loaded.map(() => 0) };
  }

  /** Trace for about so long. True when the picture is whole. */
  async step(budget) {
    const gl = this.gl, job = this.job, end = performance.now() + budget;
    while (job.layer < job.loaded.length) {
      const began = performance.now();
      const rows = Math.min(this.bandRows, job.height - job.row);
      this.band(job, rows);
      // Reading a pixel waits for the GPU, and so measures it.
      gl.readPixels(0, job.row, 1, 1, gl.RGBA_INTEGER, gl.UNSIGNED_INT, new Uint32Array(4));
      const ms = performance.now() - began;
      job.ms[job.layer] += ms;
      const factor = Math.min(Math.max(BAND_MS / Math.max(ms, 0.5), 0.25), 4);
      this.bandRows = Math.min(Math.max(Math.round(rows * factor), 1), 4096);
      job.row += rows;
      if (job.row >= job.height) {
        job.layer++;
        job.row = 0;
      }
      if (performance.now() > end) break;
    }
    return job.layer >= job.loaded.length;
  }

  band(job, rows) {
    const gl = this.gl, loaded = job.loaded[job.layer], layer = this.layers[job.layer], use = loaded.tracing;
    gl.bindFramebuffer(gl.FRAMEBUFFER, layer.frame);
    gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
    gl.useProgram(use.program);
    bind(gl, use, loaded.textures, ["uNodes", "uTriangles", "uInstances"]);
    const { eye, forward, right, up } = job.camera, root = job.roots[job.layer];
    gl.uniform3fv(use.at("uEye"), eye);
    gl.uniform3fv(use.at("uForward"), forward);
    gl.uniform3fv(use.at("uRight"), right);
    gl.uniform3fv(use.at("uUp"), up);
    gl.uniform2f(use.at("uSize"), job.width, job.height);
    gl.uniform1i(use.at("uOrder"), job.order);
    gl.uniform1ui(use.at("uRoot"), root ? root.node : 0);
    gl.uniform1i(use.at("uRootInstance"), root ? root.instance : -2);
    gl.uniform1ui(use.at("uBrute"), job.brute);
    gl.uniform1ui(use.at("uTriangleCount"), loaded.triangles);
    gl.uniform1ui(use.at("uInstanceCount"), loaded.instances);
    gl.uniform1ui(use.at("uNodeCount"), loaded.nodes);
    gl.viewport(0, 0, job.width, job.height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, job.row, job.width, rows);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** What was traced, on this side: four numbers a pixel each, the lowest row first. */
  read(i) {
    const gl = this.gl, { width, height } = this.job;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.layers[i].frame);
    const take = (attachment) => {
      const out = new Uint32Array(4 * width * height);
      gl.readBuffer(attachment);
      gl.readPixels(0, 0, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, out);
      return out;
    };
    const read = { width, height, hit: take(gl.COLOR_ATTACHMENT0), work: take(gl.COLOR_ATTACHMENT1) };
    gl.readBuffer(gl.COLOR_ATTACHMENT0);
    return read;
  }

  /** Draw what was traced. `view`: shade, most, theme, mode ("a", "b", "split" or "difference"), split (share of the width). */
  shade(view) {
    const gl = this.gl, job = this.job, [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    if (!job) return;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, w, h);
    const scale = [job.width / w, job.height / h];
    const part = (from, to, draw) => {
      gl.enable(gl.SCISSOR_TEST);
      gl.scissor(from, 0, Math.max(to - from, 0), h);
      draw();
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    };
    const one = (i) => () => {
      const use = this.shading, loaded = job.loaded[i], layer = this.layers[i];
      gl.useProgram(use.program);
      bind(gl, use, [...loaded.textures, layer.hit, layer.work], ["uNodes", "uTriangles", "uInstances", "uHit", "uWork"]);
      gl.uniform2fv(use.at("uScale"), scale);
      gl.uniform3fv(use.at("uForward"), job.camera.forward);
      gl.uniform1i(use.at("uShade"), view.shade);
      gl.uniform1i(use.at("uDark"), view.theme === "dark" ? 1 : 0);
      gl.uniform1f(use.at("uMost"), view.most);
    };
    const two = job.loaded.length > 1;
    if (two && view.mode === "difference" && view.shade >= SHADES.nodes) {
      part(0, w, () => {
        const use = this.difference;
        gl.useProgram(use.program);
        bind(gl, use, [this.layers[0].work, this.layers[1].work], ["uWorkA", "uWorkB"]);
        gl.uniform2fv(use.at("uScale"), scale);
        gl.uniform1i(use.at("uShade"), view.shade);
        gl.uniform1f(use.at("uMost"), view.most);
      });
    } else if (two && view.mode === "split") {
      const middle = Math.round(w * view.split);
      part(0, middle, one(0));
      part(middle, w, one(1));
    } else {
      part(0, w, one(two && view.mode === "b" ? 1 : 0));
    }
    gl.disable(gl.SCISSOR_TEST);
  }

  layer(width, height) {
    const gl = this.gl, frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    const [hit, work] = [0, 1].map((i) => {
      const texture = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, texture);
      plain(gl);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32UI, width, height);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0 + i, gl.TEXTURE_2D, texture, 0);
      return texture;
    });
    return { frame, hit, work, width, height };
  }

  drop(layer) {
    this.gl.deleteTexture(layer.hit);
    this.gl.deleteTexture(layer.work);
    this.gl.deleteFramebuffer(layer.frame);
  }
}

/** Numbers in rows of whole texels. */
const texels = (count) => 4 * WIDTH * Math.max(1, Math.ceil(count / WIDTH));

function plain(gl) {
  for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
}

function records(gl, data) {
  const height = data.length / (4 * WIDTH);
  if (height > gl.getParameter(gl.MAX_TEXTURE_SIZE)) throw new Error("the scene is larger than this GPU's textures");
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  plain(gl);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32UI, WIDTH, height, 0, gl.RGBA_INTEGER, gl.UNSIGNED_INT, data);
  return texture;
}

function bind(gl, use, textures, names) {
  textures.forEach((texture, i) => {
    gl.activeTexture(gl.TEXTURE0 + i);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform1i(use.at(names[i]), i);
  });
  gl.activeTexture(gl.TEXTURE0 + 7);
}

function program(gl, text) {
  const made = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, CORNERS], [gl.FRAGMENT_SHADER, text]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error("a shader is refused: " + gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error("a program is refused: " + gl.getProgramInfoLog(made));
  const places = new Map();
  const at = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(made, name));
    return places.get(name);
  };
  return { program: made, at };
}
