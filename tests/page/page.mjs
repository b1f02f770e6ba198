// The page of `bvhc view --html` in a headless Chromium: node page.mjs BVHC CHROMIUM FOLDER [--keep] [--only=WORDS]
//
// FOLDER gets the files and pages under test, unless it shall keep those of before, and pictures of them. Hits are held against `bvhc verify --ray`.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { Browser, pause } from "./browser.mjs";

const [tool, chromium, folder] = process.argv.slice(2).map((path) => resolve(path));
const samples = join(dirname(fileURLToPath(import.meta.url)), "../../samples");
const at = (name) => join(folder, name);
const bvhc = (...args) => execFileSync(tool, args, { encoding: "utf8", stdio: ["ignore", "pipe", "inherit"], maxBuffer: 1 << 28 });
const address = (name, more = "") => pathToFileURL(at(name)).href + more;

/** A bumpy sheet of so many squares each way, whose coordinates hold as many digits as those of a scan. */
function sheet(squares) {
  const lines = [];
  const height = (x, y) => Math.sin(x * 1.7) * Math.cos(y * 2.3) + 0.3 * Math.sin(12.9898 * x + 78.233 * y);
  for (let y = 0; y <= squares; y++) {
    for (let x = 0; x <= squares; x++) {
      const [a, b] = [(x * 10) / squares + 0.01 * Math.sin(91.7 * x + y), (y * 10) / squares + 0.01 * Math.sin(37.1 * y + x)];
      lines.push(`v ${a.toFixed(6)} ${height(a, b).toFixed(6)} ${b.toFixed(6)}`);
    }
  }
  for (let y = 0, row = squares + 1; y < squares; y++) {
    for (let x = 1; x <= squares; x++) {
      const k = y * row + x;
      lines.push(`f ${k} ${k + row} ${k + 1}`, `f ${k + 1} ${k + row} ${k + row + 1}`);
    }
  }
  return lines.join("\n") + "\n";
}

function make() {
  writeFileSync(at("sheet.obj"), sheet(174)); // 60,552 triangles
  bvhc("-q", "build", at("sheet.obj"), "-o", at("sheet.bvhc"), "--preset", "draft");
  bvhc("-q", "build", join(samples, "colonnade.obj"), "-o", at("split.bvhc"), "--method", "sbvh");
  bvhc("-q", "build", join(samples, "colonnade.obj"), "-o", at("whole.bvhc"), "--preset", "draft");
  bvhc("-q", "build", join(samples, "forest.gltf"), "-o", at("forest.bvhc"));
  bvhc("-q", "build", join(samples, "helicopter/heli.####.obj"), "--frames", "1-4", "-o", at("heli.bvhc"), "--preset", "draft");
  for (const name of ["sheet", "split", "forest", "heli"]) bvhc("view", at(`${name}.bvhc`), "--html", at(`${name}.html`));
  bvhc("view", "--compare", at("split.bvhc"), at("whole.bvhc"), "--html", at("pair.html"));
}

/** The ray of a place in the picture, as the address has it. */
const rayAt = (page, x, y) => page.run(`(() => { const f = bvhc.camera.film(); return bvhc.rayText(${x}, ${y}); })()`);

/** Hits and work of picked rays are those of the program. */
async function hitsAgree(page, file, count) {
  let hits = 0;
  for (let i = 0; i < count; i++) {
    const text = await rayAt(page, -0.4 + (0.8 * ((i * 7) % count)) / count, -0.35 + (0.7 * i) / count);
    const own = await page.run(`bvhc.follow("${text}")`);
    const [told] = JSON.parse(bvhc("verify", at(file), "--json", "--device", "cpu", `--ray=${text}`)).files;
    const { closest } = told.devices[0];
    assert.equal(own.inner, told.steps.filter((step) => step.step === "child").length / 2, `inner nodes of ray ${text}`);
    assert.ok(own.tests >= told.steps.filter((step) => step.step === "triangle").length, `tests of ray ${text}`);
    assert.equal(own.hit !== null, closest.answer === "hit", `whether ray ${text} meets something`);
    if (!own.hit) continue;
    hits++;
    for (const field of ["prim", "geom"]) assert.equal(own.hit[field], closest[field], `${field} of ray ${text}`);
    assert.equal(own.hit.id, closest.instance ?? null, `instance of ray ${text}`);
    for (const [mine, its] of [[own.hit.t, closest.t], [own.hit.u, closest.u], [own.hit.v, closest.v]]) {
      assert.ok(Math.abs(mine - its) <= 1e-6 * Math.max(1, Math.abs(its)), `${mine} and ${its} of ray ${text}`);
    }
  }
  assert.ok(hits > count / 4, `only ${hits} of ${count} rays met something`);
}

/** A section of a file, as SPEC.md, section 3, lays it out. */
function section(file, type) {
  const bytes = readFileSync(at(file));
  for (let entry = 256, left = bytes.readUInt32LE(40); left > 0; entry += 128, left--) {
    if (bytes.toString("latin1", entry, entry + 4) !== type) continue;
    const start = Number(bytes.readBigUInt64LE(entry + 16));
    return bytes.subarray(start, start + Number(bytes.readBigUInt64LE(entry + 24)));
  }
  return Buffer.alloc(0);
}

/** Boxes, links, corners and numbers in the page are those of the file, bit for bit. */
async function recordsAgree(page, file) {
  const taken = async (field) => Buffer.from(await page.run(`(() => { const a = bvhc.shown()[0].scene.${field}; let text = "";
    const bytes = new Uint8Array(a.buffer, a.byteOffset, a.byteLength);
    for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
    return btoa(text); })()`), "base64");
  const [box, first, count, corner, prim, geom] = await Promise.all(["box", "first", "count", "corner", "prim", "geom"].map(taken));
  const [toWorld, toObject] = await Promise.all(["toWorld", "toObject"].map(taken));
  const nodes = Buffer.concat([section(file, "NODE"), section(file, "TNOD")]), rows = section(file, "BLAS"), triangles = section(file, "TRIS");
  const bottom = section(file, "NODE").length / 32;
  let tree = 0;
  for (let n = 0; n < nodes.length / 32; n++) {
    const record = nodes.subarray(32 * n, 32 * n + 32), kind = record.readUInt32LE(28);
    while (tree + 1 < rows.length / 64 && Number(rows.readBigUInt64LE(64 * (tree + 1) + 32)) <= n) tree++;
    const offset = n >= bottom ? (kind ? 0 : bottom) : Number(rows.readBigUInt64LE(64 * tree + (kind ? 40 : 32)));
    assert.equal(box.subarray(24 * n, 24 * n + 24).toString("hex"), Buffer.concat([record.subarray(0, 12), record.subarray(16, 28)]).toString("hex"), `box of node ${n}`);
    assert.equal(count[n], kind, `count of node ${n}`);
    if (record.readUInt32LE(12) || kind) assert.equal(first.readUInt32LE(4 * n), record.readUInt32LE(12) + offset, `first of node ${n}`);
  }
  for (let i = 0; i < triangles.length / 48; i++) {
    const record = triangles.subarray(48 * i, 48 * i + 48), corners = [0, 16, 32].map((k) => record.subarray(k, k + 12));
    assert.ok(corner.subarray(36 * i, 36 * i + 36).equals(Buffer.concat(corners)), `corners of triangle ${i}`);
    assert.equal(prim.readUInt32LE(4 * i), record.readUInt32LE(12));
    assert.equal(geom.readUInt32LE(4 * i), record.readUInt32LE(28));
  }
  const instances = section(file, "INST");
  for (let i = 0; i < instances.length / 128; i++) {
    assert.ok(toWorld.subarray(48 * i, 48 * i + 48).equals(instances.subarray(128 * i, 128 * i + 48)));
    assert.ok(toObject.subarray(48 * i, 48 * i + 48).equals(instances.subarray(128 * i + 48, 128 * i + 96)));
  }
  assert.ok(nodes.length > 0 && triangles.length > 0);
}

/** What the renderer traced is what the traversal on the CPU finds, pixel by pixel, but for what single precision rounds. */
async function pixelsAgree(page, layer = 0, most = 0.02) {
  const differ = await page.run(`bvhc.compared(${layer}, 5000)`);
  assert.ok(differ.pixels > 500, "pixels that were compared");
  assert.ok(differ.hits <= differ.pixels * 0.004, `${differ.hits} of ${differ.pixels} pixels show another triangle`);
  assert.ok(Math.abs(differ.work - 1) < most, `the renderer's work is ${differ.work} of the CPU's`);
}

/** Texts do not overlap, and nothing reaches beyond the right edge. */
async function isLaidOut(page) {
  const faults = await page.run(`(() => {
    const faults = [];
    if (document.scrollingElement.scrollWidth > innerWidth) faults.push("the page is wider than its window");
    const texts = [...document.querySelectorAll("h1, p, label > span, legend, button, dt, dd, select, figcaption, #labels span, #swatches li, output, code")]
      .filter((e) => e.checkVisibility() && (e.textContent.trim() || e.tagName === "SELECT"))
      .map((e) => ({ e, r: e.getBoundingClientRect() })).filter(({ r }) => r.width && r.height);
    const clips = (e) => e.closest("#crumbs, #ray-nodes");
    for (const [i, a] of texts.entries()) for (const b of texts.slice(i + 1)) {
      if (a.e.contains(b.e) || b.e.contains(a.e) || clips(a.e) || clips(b.e)) continue;
      const w = Math.min(a.r.right, b.r.right) - Math.max(a.r.left, b.r.left), h = Math.min(a.r.bottom, b.r.bottom) - Math.max(a.r.top, b.r.top);
      if (w > 1 && h > 1) faults.push(a.e.textContent.trim().slice(0, 40) + " overlaps " + b.e.textContent.trim().slice(0, 40));
    }
    return faults;
  })()`);
  assert.deepEqual(faults, []);
}

/** A few numbers of what the film shows: brightness in a grid, and how many colours. */
const seen = (page) => page.run(`(() => {
  const small = document.createElement("canvas"), film = document.getElementById("film");
  [small.width, small.height] = [24, 15];
  const c = small.getContext("2d");
  c.drawImage(film, 0, 0, 24, 15);
  const d = c.getImageData(0, 0, 24, 15).data, grid = [], colours = new Set();
  for (let i = 0; i < d.length; i += 4) { grid.push((d[i] + d[i + 1] + d[i + 2]) / 3); colours.add((d[i] >> 4) * 256 + (d[i + 1] >> 4) * 16 + (d[i + 2] >> 4)); }
  return { grid, colours: colours.size };
})()`);
const apart = (a, b) => a.grid.reduce((sum, x, i) => sum + Math.abs(x - b.grid[i]), 0) / a.grid.length;

const linesDrawn = (page) => page.run(`(() => { const e = document.getElementById("lines");
  return e.getContext("2d").getImageData(0, 0, e.width, e.height).data.reduce((n, x, i) => n + (i % 4 === 3 && x > 0), 0); })()`);

const tests = {
  async "a page of 60,000 triangles is small and shows its first picture soon"(browser) {
    assert.ok(statSync(at("sheet.html")).size < 2e6, `the page has ${statSync(at("sheet.html")).size} bytes`);
    const page = await browser.page(address("sheet.html"), 1280, 900);
    await page.settled();
    assert.equal(await page.run("bvhc.shown()[0].scene.triangles"), 60552);
    await hitsAgree(page, "sheet.bvhc", 12);
    await pixelsAgree(page);
    await page.picture(at("sheet.png"));
    return page;
  },

  async "clicks and keys on a tree with split triangles"(browser) {
    const page = await browser.page(address("split.html"), 1280, 900);
    await page.settled();
    await isLaidOut(page);
    await recordsAgree(page, "split.bvhc");
    await hitsAgree(page, "split.bvhc", 12);
    await pixelsAgree(page);
    const lit = await seen(page);
    assert.ok(lit.colours > 3, "the surface has shades");

    // A click picks a ray, lists its nodes and selects the leaf that it meets.
    await page.click(...(await page.middle("film")));
    await page.until(`location.hash.startsWith("#ray=") && document.querySelectorAll("#ray-nodes li").length > 3`, "the nodes of a ray");
    assert.match(await page.run(`document.getElementById("ray-facts").textContent`), /triangle .*tested/);
    const deep = await page.run(`document.querySelectorAll("#crumbs button").length`);
    assert.ok(deep > 4, "breadcrumbs lead from the root to the leaf");
    assert.match(await page.run(`document.getElementById("node-facts").textContent`), /leaf of/);
    await page.run(`document.querySelector("#crumbs button").click()`);
    assert.equal(await page.run(`document.querySelectorAll("#crumbs button").length`), 1);
    await page.run(`document.querySelectorAll("#ray-nodes button")[2].click()`);
    assert.ok((await page.run(`document.querySelectorAll("#crumbs button").length`)) > 1, "a listed node is selected by a click");

    // Keys: boxes, levels, parents, flying.
    await page.run(`document.getElementById("film").focus({ preventScroll: true })`);
    const before = await linesDrawn(page);
    await page.key("KeyH", "h");
    await page.key("KeyP", "p");
    await page.key("KeyB", "b");
    await page.until(`document.getElementById("boxes").checked && /box/.test(document.getElementById("box-count").textContent)`, "boxes");
    assert.ok((await linesDrawn(page)) > before, "boxes are drawn");
    const level = await page.run(`Number(document.getElementById("level").value)`);
    await page.key("BracketRight", "]");
    assert.equal(await page.run(`Number(document.getElementById("level").value)`), level + 1);
    const eye = await page.run("bvhc.camera.eye");
    await page.settled(() => page.key("KeyW", "w", 250));
    assert.notDeepEqual(await page.run("bvhc.camera.eye"), eye, "W flies");
    await page.settled(async () => page.drag(await page.middle("film"), (await page.middle("film")).map((x) => x + 60)));

    // Cost: a scale in numbers, a histogram, and another order of children costs something else.
    await page.settled(() => page.press("home"));
    await page.settled(() => page.set("shade", "cost"));
    const numbers = await page.run(`[...document.querySelectorAll("#labels span")].map((e) => parseFloat(e.textContent.replaceAll(",", "")))`);
    assert.ok(numbers.length === 5 && numbers[0] === 0 && numbers.every((x, i) => !i || x > numbers[i - 1]), `the scale ${numbers}`);
    await isLaidOut(page);
    await page.picture(at("split-cost.png"));
    const mean = () => page.run("bvhc.view.figures[0].mean");
    const near = await mean();
    await page.settled(() => page.set("order", "far"));
    assert.ok((await mean()) > 1.2 * near, "the farther child first costs more");
    await pixelsAgree(page);
    for (const order of ["big", "origin", "stored"]) {
      await page.settled(() => page.set("order", order));
      // Children of equal size are told apart by rounding alone.
      await pixelsAgree(page, 0, order === "big" ? 0.2 : 0.02);
    }
    await page.settled(() => page.set("order", "near"));

    // The map of the tree.
    await page.click(...(await page.middle("map")));
    assert.ok((await page.run(`document.querySelectorAll("#crumbs button").length`)) > 3, "a click in the map selects a small subtree");
    await page.settled(() => page.press("only"));
    assert.ok((await mean()) < near || (await page.run("bvhc.view.values.length")) === 0, "a subtree alone costs less");
    await page.settled(() => page.press("only"));

    // Without the tree each ray tests as many triangles as were asked for.
    await page.set("brute-most", 40);
    await page.settled(() => page.press("brute"));
    assert.equal(await page.run("bvhc.view.figures[0].most"), Number((await page.run(`document.getElementById("brute-count").textContent`)).replaceAll(",", "")));
    await pixelsAgree(page);
    return page;
  },

  async "two levels, by the GPU and by workers"(browser) {
    const page = await browser.page(address("forest.html"), 1280, 900);
    await page.settled();
    await recordsAgree(page, "forest.bvhc");
    await hitsAgree(page, "forest.bvhc", 16);
    await pixelsAgree(page);
    await page.settled(() => page.set("shade", "instance"));
    assert.ok((await page.run(`document.querySelectorAll("#swatches li").length`)) > 3, "instances are told by colour");
    await isLaidOut(page);
    await page.picture(at("forest.png"));
    const gpu = await seen(page);
    assert.match(await page.run("bvhc.renderer.name"), /GPU/);
    await page.close();

    const other = await browser.page(address("forest.html", "?renderer=cpu"), 1280, 900);
    await other.settled();
    assert.match(await other.run("bvhc.renderer.name"), /CPU/);
    await other.settled(() => other.set("shade", "instance"));
    await pixelsAgree(other);
    const far = apart(gpu, await seen(other));
    assert.ok(far < 6, `pictures of GPU and CPU are ${far} shades of 255 apart`);
    return other;
  },

  async "a ray in the address is traced"(browser) {
    const text = "0,9,0,0.1,-1,0.2";
    const page = await browser.page(address("forest.html", `#ray=${text}`), 1280, 900);
    await page.settled();
    assert.equal(await page.run(`document.getElementById("ray-text").value`), text);
    assert.match(await page.run(`document.getElementById("ray-command").textContent`), new RegExp(`--ray[= ]${text}`));
    assert.ok((await linesDrawn(page)) > 50, "the ray is drawn");
    assert.match(await page.run(`[...document.querySelectorAll("#crumbs button")].map((e) => e.textContent).join(" ")`), /instance/);
    await page.picture(at("ray.png"));
    return page;
  },

  async "two trees, side by side and their difference"(browser) {
    const page = await browser.page(address("pair.html"), 1280, 900);
    await page.settled();
    for (const layer of [0, 1]) await pixelsAgree(page, layer);
    await page.settled(() => page.set("shade", "cost"));
    await page.picture(at("pair.png"));
    const even = await seen(page);
    await page.settled(() => page.set("split", 90));
    assert.ok(apart(even, await seen(page)) > 1, "the slider shows more of A");
    await page.settled(() => page.set("mode", "difference"));
    assert.match(await page.run(`document.getElementById("spread-title").textContent`), /B less A/);
    const ends = await page.run(`[...document.querySelectorAll("#labels span")].map((e) => parseFloat(e.textContent.replaceAll(",", "")))`);
    assert.ok(ends[0] < 0 && ends[2] === 0 && ends[4] === -ends[0], `the scale ${ends}`);
    await isLaidOut(page);
    await page.picture(at("difference.png"));
    return page;
  },

  async "frames of a sequence"(browser) {
    const page = await browser.page(address("heli.html"), 1280, 900);
    await page.settled();
    const first = await seen(page), title = await page.run(`document.getElementById("subtitle").textContent`);
    assert.match(title, /frame 1$/);
    await pixelsAgree(page);
    await page.settled(() => page.set("frame", 3));
    assert.match(await page.run(`document.getElementById("subtitle").textContent`), /frame 4$/);
    assert.ok(apart(first, await seen(page)) > 0.01, "another frame is another picture");
    await pixelsAgree(page);
    await isLaidOut(page);
    await page.picture(at("heli.png"));
    return page;
  },

  async "a telephone: touch, no overlap, no sideways scrolling"(browser) {
    const page = await browser.page(address("split.html"), 390, 844, true);
    await page.settled();
    await page.settled(() => page.set("shade", "cost"));
    await isLaidOut(page);
    await page.picture(at("phone.png"));
    const [x, y] = await page.middle("film");
    const reach = await page.run("bvhc.camera.reach"), yaw = await page.run("bvhc.camera.yaw");
    await page.settled(() => page.touch([[x, y]], [[x + 30, y]], [[x + 60, y]]));
    assert.notEqual(await page.run("bvhc.camera.yaw"), yaw, "one finger turns");
    await page.settled(() => page.touch([[x - 20, y], [x + 20, y]], [[x - 40, y], [x + 40, y]], [[x - 60, y], [x + 60, y]]));
    assert.ok((await page.run("bvhc.camera.reach")) < reach, "two fingers go nearer");
    await page.settled(() => page.press("home"));
    await page.touch([await page.middle("film")]);
    await page.until(`document.querySelectorAll("#ray-nodes li").length > 3`, "the nodes of a ray that a finger picked");
    await isLaidOut(page);
    await page.press("theme");
    await pause(300);
    await page.run(`document.getElementById("crumbs").scrollIntoView()`);
    await page.picture(at("phone-dark.png"));
    return page;
  },
};

if (!process.argv.includes("--keep")) make();
const only = process.argv.find((word) => word.startsWith("--only="))?.slice(7) ?? "";
const browser = Browser.start(chromium);
let failed = 0;
for (const [name, test] of Object.entries(tests)) {
  if (!name.includes(only)) continue;
  const began = Date.now();
  try {
    const page = await test(browser);
    assert.deepEqual(page.complaints(), []);
    await page.close();
    console.log(`ok   ${name} (${((Date.now() - began) / 1000).toFixed(1)} s)`);
  } catch (error) {
    failed++;
    console.log(`FAIL ${name}: ${error.stack}`);
  }
}
await browser.stop();
process.exitCode = failed ? 1 : 0;
