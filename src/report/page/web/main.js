// The page: scenes are unpacked, settings become pictures, and what is picked is told.

import { inflated, unpacked } from "./data.js";
import { cutAt, factsOf, pathTo, rootOf, worldCorners } from "./tree.js";
import { ORDERS } from "./trace.js";
import { SHADES, UNITS, css, hue } from "./colour.js";
import { GpuRenderer } from "./gpu.js";
import { CpuRenderer, filmRay, serve } from "./cpu.js";
import { Camera } from "./camera.js";
import { steer } from "./input.js";
import { Overlay } from "./overlay.js";
import { drawHistogram, drawScale } from "./histogram.js";
import { Treemap, isSame } from "./treemap.js";
import { element, followed, readRay, showRay, writeRay } from "./ray_panel.js";
import { showNode } from "./node_panel.js";
import { View } from "./view.js";
import { compared, rayText } from "./proof.js";
import { fileRows, lineOf, sharesOf, testedOf } from "./file_panel.js";
import { counted, figure, percent } from "./vector.js";

const MOST_BOXES = 3000;
const MOST_SWATCHES = 5;
/** What stands under pictures whose colours stand for no numbers. */
const PLAIN = { lit: "The surface in the light of a lamp beside the camera", normal: "Which way the surface faces: red is x, green is y, blue is z" };
/** What the mean of a pair is a mean of. */
const MEANS = { depth: "depth of hit leaves", nodes: "number of nodes entered", tests: "number of triangles tested", cost: "cost of a ray" };
const SHARES = { part: "Parts, by their share of the picture", instance: "Instances, by their share of the picture" };
const $ = (id) => document.getElementById(id);

async function start() {
  const head = JSON.parse($("head").textContent);
  const isPair = head.together === "compare" && head.scenes.length > 1;
  const opened = [];
  const open = async (i) => {
    if (opened[i]) return opened[i];
    const scene = unpacked(await inflated($(`data-${i}`).textContent), head.scenes[i].counts);
    const facts = factsOf(scene), root = rootOf(scene);
    return (opened[i] = { head: head.scenes[i], scene, facts, root, selected: root, loaded: null });
  };
  let shown = isPair ? [await open(0), await open(1)] : [await open(0)];

  const want = new URLSearchParams(location.search).get("renderer");
  const film = $("film");
  let renderer = want === "cpu" ? null : GpuRenderer.on(film);
  try {
    for (const one of shown) if (renderer) one.loaded = renderer.load(one.scene, one.facts);
  } catch (error) {
    console.warn(error);
    renderer = null;
  }
  if (!renderer) {
    const fresh = film.cloneNode();
    $("film").replaceWith(fresh);
    renderer = new CpuRenderer(fresh, $("code").textContent);
    for (const one of shown) one.loaded = renderer.load(one.scene, one.facts);
  }
  const canvas = $("film"), overlay = new Overlay($("lines"));
  const state = { theme: "light", ray: null, found: null, active: 0, ready: 0 };
  const active = () => shown[state.active];
  const camera = new Camera(boundsOf(shown[0]));

  // What rays depend on, as a renderer takes it.
  const setting = () => ({
    loaded: shown.map((one) => one.loaded),
    roots: shown.map((one) => ($("only").checked ? one.selected : one.root)),
    camera: () => camera.film(),
    order: ORDERS[$("order").value],
    brute: $("brute").checked ? bruteCount() : 0,
  });
  const look = () => ({
    shade: SHADES[$("shade").value], theme: state.theme, facts: shown.map((one) => one.facts),
    mode: isPair ? $("mode").value : "a", split: $("split").value / 100,
  });
  const view = new View(renderer, canvas, {
    look, shaded: (result) => shaded(result),
    failed: (error) => {
      $("message").textContent = `The picture cannot be made: ${error.message}.`;
      $("message").hidden = false;
    },
  });
  const retrace = () => view.touch(setting());
  const told = { selected: (place) => select(place), hovered: (place) => { $("map-words").textContent = place ? map.words(place) : mapRest(); } };
  const map = new Treemap($("map"), told);
  const mapRest = () => (active().selected ? map.words(active().selected) : "The scene has no triangles.");

  function bruteCount() {
    const all = Math.max(...shown.map(testedOf), 1);
    return Math.max(1, Math.round(all ** ($("brute-most").value / 100)));
  }

  // Under the picture.
  function shaded({ isWhole, isLast, ms, size }) {
    drawLines();
    const shade = $("shade").value, hasScale = shade in UNITS;
    const pair = isPair && look().mode === "split";
    $("divider").hidden = !pair;
    $("divider").style.left = `${$("split").value}%`;
    if (!isWhole) return;
    const low = view.differs ? -view.most : 0, unit = UNITS[hasScale ? shade : "cost"];
    $("unit").hidden = hasScale;
    $("swatches").hidden = !(shade in SHARES);
    $("unit").textContent = SHARES[shade] ?? PLAIN[shade];
    if (shade in SHARES) swatches(shade);
    const what = view.differs ? `B less A, ${unit}` : unit[0].toUpperCase() + unit.slice(1);
    $("spread-title").textContent = `${what}: ${hasScale ? "the colours, and " : ""}how many pixels have how much (heights are square roots)`;
    drawHistogram($("histogram"), view.values, low, view.most, getComputedStyle(document.body).color);
    drawScale($("strip"), $("labels"), low, view.most, view.isOpen);
    const said = view.figures.map((f, i) => `${isPair ? "AB"[i] + ": " : ""}mean ${figure(Number(f.mean.toPrecision(4)))}, median ${figure(f.median)}, most ${figure(f.most)}, `
      + `${figure(Math.max(Math.round(ms[i]), 1))} ms`);
    $("status").textContent = `${said.join(" · ")} a picture. ${figure(size[0])} × ${figure(size[1])} rays`
      + (size[0] < canvas.width ? " (fewer than pixels, to hold the time)" : "") + ` on the ${renderer.name}`
      + ($("brute").checked ? `, each tests ${counted(Math.min(bruteCount(), Math.max(...shown.map(testedOf))), "triangle")}` : "");
    if (isPair) pairWords();
    if (isLast) document.documentElement.dataset.ready = String((state.ready += 1));
  }
  function pairWords() {
    const [a, b] = view.figures.map((f) => f.mean), change = a > 0 ? (100 * (b - a)) / a : 0;
    const shade = $("shade").value, unit = MEANS[shade] ?? MEANS.cost;
    $("pair-words").textContent = `From this camera the mean ${unit} is ${figure(Number(a.toPrecision(4)))} in A and ${figure(Number(b.toPrecision(4)))} in B: `
      + (Math.abs(change) < 0.05 ? "no difference." : `${Math.abs(change).toFixed(1)} % ${change > 0 ? "more" : "less"}.`);
  }
  function swatches(shade) {
    const rows = sharesOf(shade, view.whole.reads[state.active], active());
    const items = rows.slice(0, MOST_SWATCHES).map(([key, name, share]) => {
      const item = element("li"), colour = element("i");
      colour.style.background = css(hue(key));
      item.append(colour, `${name} ${percent(share)}`);
      return item;
    });
    if (rows.length > items.length) items.push(element("li", `and ${figure(rows.length - items.length)} more`));
    $("swatches").replaceChildren(...items);
  }

  // Over the picture.
  function drawLines() {
    overlay.begin(camera.film(), canvas.width / Math.max(canvas.clientWidth, 1));
    const one = active();
    if (one.selected && $("boxes").checked) overlay.boxes(one.scene, state.cut.places, null, 1.3);
    if (one.selected && !isSame(one.selected, one.root)) overlay.boxes(one.scene, [one.selected], "#ffd23f", 2.5);
    if (state.ray) {
      const visited = state.found.visited.slice(0, 400);
      overlay.boxes(one.scene, visited, "rgb(63 224 197 / 30%)", 1);
      overlay.ray(state.ray.origin, state.ray.direction, state.found.hit?.t ?? Infinity, state.found.hit !== null, camera.size);
    }
  }

  // Nodes.
  function select(place, quiet = false) {
    const one = active();
    if (!place || !one.root) return;
    one.selected = { node: place.node, instance: place.instance };
    showSelected();
    if (!quiet && $("only").checked) retrace();
    else drawLines();
  }
  function showSelected() {
    const one = active();
    if (!one.selected) {
      $("map-words").textContent = mapRest();
      return;
    }
    const level = Number($("level").value);
    state.cut = cutAt(one.scene, one.selected, level, MOST_BOXES);
    $("level-number").textContent = level;
    $("box-count").textContent = $("boxes").checked ? `(${state.cut.all ? counted(state.cut.places.length, "box", "boxes") : `the first ${figure(MOST_BOXES)}`})` : "";
    map.draw(one.scene, one.facts, $("only").checked ? one.selected : one.root, 64, one.selected);
    showNode({ crumbs: $("crumbs"), name: $("node-name"), facts: $("node-facts"), parent: $("parent"), first: $("first"), second: $("second") },
      one.scene, one.facts, one.selected, (at) => map.weight(at), told);
    $("map-words").textContent = mapRest();
  }

  // Rays.
  function pick(ray, isTyped) {
    const one = active();
    state.ray = ray;
    state.found = followed(one.scene, one.facts, ray, { root: $("only").checked ? one.selected : one.root, order: ORDERS[$("order").value], brute: 0 });
    $("ray").hidden = false;
    $("ray-hint").hidden = true;
    $("ray-text").value = writeRay(ray);
    showRay({ facts: $("ray-facts"), command: $("ray-command"), list: $("ray-nodes"), count: $("ray-count") }, one.scene, one.head, one.facts, ray, state.found, told);
    history.replaceState(null, "", `#ray=${writeRay(ray)}`);
    if (state.found.hit) {
      const { leaf, instance } = state.found.hit, path = pathTo(one.scene, one.facts, { node: leaf, instance });
      select($("boxes").checked ? path[Math.min(Number($("level").value) + pathTo(one.scene, one.facts, one.root).length - 1, path.length - 1)] : path[path.length - 1]);
    }
    if (isTyped) besideRay(ray, state.found.hit?.t ?? camera.size);
    drawLines();
  }
  /** Stand where the ray is seen from its side. */
  function besideRay({ origin, direction }, t) {
    const end = origin.map((o, a) => o + t * direction[a]), middle = origin.map((o, a) => (o + end[a]) / 2);
    const span = Math.max(Math.hypot(...end.map((e, a) => e - origin[a])), camera.size * 0.06), u = camera.upAxis;
    const side = [0, 0, 0], d = direction.map((x) => x / Math.hypot(...direction));
    side[(u + 1) % 3] = -d[(u + 2) % 3] - d[(u + 1) % 3] * 0.8;
    side[(u + 2) % 3] = d[(u + 1) % 3] - d[(u + 2) % 3] * 0.8;
    side[u] = 0.6;
    camera.lookAt(middle.map((m, a) => m + side[a] * span * 1.1), middle);
    retrace();
  }
  function rayFromAddress() {
    const text = new URLSearchParams(location.hash.slice(1)).get("ray");
    const ray = text && readRay(text);
    if (ray) pick(ray, true);
  }

  // Wiring.
  const resize = () => {
    const ratio = Math.min(devicePixelRatio || 1, 2), box = $("picture");
    for (const c of [canvas, $("lines")]) {
      c.width = Math.max(1, Math.round(box.clientWidth * ratio));
      c.height = Math.max(1, Math.round(box.clientHeight * ratio));
    }
    camera.aspect = canvas.width / canvas.height;
    showSelected();
    retrace();
  };
  const key = (code) => {
    const press = (id) => { $(id).click(); return true; };
    const choose = (shade) => { $("shade").value = shade; $("shade").onchange(); return true; };
    const level = (by) => { $("level").value = Number($("level").value) + by; $("level").oninput(); return true; };
    switch (code) {
      case "KeyP": return press("parent");
      case "Digit1": return press("first");
      case "Digit2": return press("second");
      case "KeyB": return press("boxes");
      case "KeyF": return press("look");
      case "KeyH": return press("home");
      case "KeyC": return choose("cost");
      case "KeyL": return choose("lit");
      case "BracketLeft": return level(-1);
      case "BracketRight": return level(1);
      default: return false;
    }
  };
  steer(canvas, camera, {
    moved: retrace, key,
    clicked: (x, y) => {
      const [origin, direction] = filmRay(camera.film(), 2 * x - 1, 1 - 2 * y);
      if (isPair && look().mode !== "difference") {
        state.active = look().mode === "b" || (look().mode === "split" && x >= $("split").value / 100) ? 1 : 0;
        $("active").value = state.active;
      }
      pick({ origin, direction }, false);
      showSelected();
    },
  });
  $("shade").onchange = () => view.recolour();
  $("order").onchange = retrace;
  $("brute").onchange = $("brute-most").oninput = () => {
    $("brute-row").hidden = !$("brute").checked;
    $("brute-count").textContent = figure(bruteCount());
    retrace();
  };
  $("mode").onchange = () => {
    if ($("mode").value === "difference" && !(SHADES[$("shade").value] >= SHADES.nodes)) $("shade").value = "cost";
    view.recolour();
  };
  $("split").oninput = () => view.recolour();
  $("active").onchange = () => { state.active = Number($("active").value); fileFacts(); showSelected(); drawLines(); };
  $("only").onchange = () => { showSelected(); retrace(); };
  $("boxes").onchange = $("level").oninput = () => { showSelected(); drawLines(); };
  $("home").onclick = () => { camera.whole(); retrace(); };
  $("look").onclick = () => {
    const { scene, selected } = active();
    if (!selected) return;
    camera.whole(spanned(worldCorners(scene, selected.node, selected.instance)));
    retrace();
  };
  $("up").onclick = () => {
    camera.upAxis = (camera.upAxis + 1) % 3;
    $("up-axis").textContent = "xyz"[camera.upAxis];
    camera.whole();
    retrace();
  };
  $("ray-form").onsubmit = (e) => {
    e.preventDefault();
    const ray = readRay($("ray-text").value);
    if (ray) pick(ray, true);
    $("ray-hint").hidden = ray !== null;
    if (!ray) $("ray-hint").textContent = "A ray is six numbers, separated by commas: origin, then a direction that is not zero.";
  };
  $("ray-clear").onclick = () => {
    state.ray = state.found = null;
    $("ray").hidden = true;
    $("ray-hint").hidden = false;
    history.replaceState(null, "", location.pathname + location.search);
    drawLines();
  };
  $("theme").onclick = () => setTheme(state.theme === "dark" ? "light" : "dark");
  const setTheme = (theme) => {
    state.theme = document.documentElement.dataset.theme = theme;
    $("theme").textContent = theme === "dark" ? "Light" : "Dark";
    view.recolour();
  };
  $("frame").oninput = async () => {
    shown = [await open(Number($("frame").value))];
    shown[0].loaded ??= renderer.load(shown[0].scene, shown[0].facts);
    titles();
    showSelected();
    if (state.ray) pick(state.ray, false);
    retrace();
  };

  function fileFacts() {
    const rows = fileRows(active(), head.version);
    $("file").replaceChildren(...rows.flatMap(([name, text]) => [element("dt", name), element("dd", text)]));
  }
  function titles() {
    $("title").textContent = isPair ? `${shown[0].head.name} (A) and ${shown[1].head.name} (B)` : shown[0].head.name;
    $("subtitle").textContent = isPair ? `A: ${lineOf(shown[0])} · B: ${lineOf(shown[1])}` : lineOf(shown[0]) + (shown[0].head.frame === null ? "" : `, frame ${shown[0].head.frame}`);
    $("frame-number").textContent = shown[0].head.frame ?? "";
    fileFacts();
  }

  $("pair").hidden = !isPair;
  if (isPair) ["left-name", "right-name"].forEach((id, i) => { $(id).textContent = `${"AB"[i]}: ${shown[i].head.name}`; });
  $("frames").hidden = isPair || head.scenes.length < 2;
  $("frame").max = head.scenes.length - 1;
  $("level").max = Math.max(...shown.map((one) => one.facts.deepest.trees + one.facts.deepest.top + (one.scene.twoLevel ? 1 : 0)), 1);
  for (const option of $("shade").options) if (option.value === "instance") option.disabled = !shown.some((one) => one.scene.twoLevel);
  setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  titles();
  if (head.camera) {
    camera.upAxis = head.camera.up;
    camera.fov = head.camera.fov;
    camera.lookAt(head.camera.eye, head.camera.target);
  }
  $("up-axis").textContent = "xyz"[camera.upAxis];
  resize();
  if (!head.camera) camera.whole();
  retrace();
  new ResizeObserver(resize).observe($("picture"));
  addEventListener("hashchange", rayFromAddress);
  rayFromAddress();

  // For tests and for the curious at the console.
  window.bvhc = {
    shown: () => shown, state, camera, view, renderer,
    rayText: (x, y) => rayText(camera.film(), x, y),
    follow: (text) => followed(active().scene, active().facts, readRay(text), { root: active().root, order: ORDERS.near, brute: 0 }),
    compared: (layer, most) => compared(view, layer, shown[layer], setting().roots[layer], most),
  };
}

function spanned(points) {
  return [Math.min, Math.max].map((f) => [0, 1, 2].map((a) => f(...points.map((p) => p[a]))));
}

function boundsOf({ scene, root }) {
  return root ? spanned(worldCorners(scene, root.node, root.instance)) : [[0, 0, 0], [1, 1, 1]];
}

if (typeof document === "undefined") {
  if (typeof postMessage === "function" && typeof self !== "undefined") serve(self);
} else {
  start().catch((error) => {
    $("message").textContent = `The page cannot be shown: ${error.message}.`;
    $("message").hidden = false;
    throw error;
  });
}
