// A headless Chromium, driven over two pipes by its own protocol: no library, no network.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const FLAGS = ["--headless", "--no-sandbox", "--disable-gpu-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
  "--hide-scrollbars", "--disable-background-networking", "--no-first-run", "--remote-debugging-pipe", "--force-device-scale-factor=1"];

export class Browser {
  static start(program) {
    const folder = mkdtempSync(join(tmpdir(), "bvhc-page-"));
    const child = spawn(program, [...FLAGS, `--user-data-dir=${folder}`, "about:blank"], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
    return new Browser(child, folder);
  }

  constructor(child, folder) {
    Object.assign(this, { child, folder, next: 1, waiting: new Map(), told: [] });
    let rest = "";
    child.stdio[4].on("data", (bytes) => {
      const parts = (rest + bytes).split("\0");
      rest = parts.pop();
      parts.forEach((part) => this.take(JSON.parse(part)));
    });
    child.stdio[3].on("error", () => {});
  }

  take(message) {
    const waiting = this.waiting.get(message.id);
    if (!waiting) {
      this.told.push(message);
      return;
    }
    this.waiting.delete(message.id);
    if (message.error) waiting.reject(new Error(message.error.message));
    else waiting.resolve(message.result);
  }

  send(method, params = {}, sessionId = undefined) {
    const id = this.next++;
    this.child.stdio[3].write(JSON.stringify({ id, method, params, sessionId }) + "\0");
    return new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject }));
  }

  /** A page of this size, of which no request may go to a network. */
  async page(url, width, height, isTouch = false) {
    const { targetId } = await this.send("Target.createTarget", { url: "about:blank" });
    const { sessionId } = await this.send("Target.attachToTarget", { targetId, flatten: true });
    const page = new Page(this, sessionId, targetId);
    for (const domain of ["Page", "Runtime", "Network", "Log"]) await page.send(`${domain}.enable`);
    await page.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile: isTouch });
    await page.send("Emulation.setTouchEmulationEnabled", { enabled: isTouch });
    await page.send("Page.navigate", { url });
    await page.until(`location.href !== "about:blank" && document.readyState === "complete"`, "the page");
    return page;
  }

  async stop() {
    await this.send("Browser.close").catch(() => {});
    await new Promise((resolve) => (this.child.exitCode === null ? this.child.once("exit", resolve) : resolve()));
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 5 });
  }
}

class Page {
  constructor(browser, session, target) {
    Object.assign(this, { browser, session, target });
  }

  send(method, params) {
    return this.browser.send(method, params, this.session);
  }

  /** What a script says, as a value. Errors of the page are errors here. */
  async run(expression) {
    const { result, exceptionDetails } = await this.send("Runtime.evaluate", { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  async until(expression, what, seconds = 120) {
    const end = Date.now() + 1000 * seconds;
    while (Date.now() < end) {
      if (await this.run(expression).catch(() => false)) return;
      await pause(40);
    }
    throw new Error(`waited ${seconds} s for ${what}`);
  }

  /** Wait for a whole picture: the one that follows an action, or the first. */
  async settled(action = null) {
    const before = action ? Number(await this.run("document.documentElement.dataset.ready ?? 0")) : 0;
    await action?.();
    await this.until(`Number(document.documentElement.dataset.ready ?? 0) > ${before} && bvhc.view.whole !== null`, "a whole picture");
  }

  async click(x, y) {
    for (const type of ["mousePressed", "mouseReleased"]) await this.send("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons: type === "mousePressed" ? 1 : 0, clickCount: 1 });
  }

  async drag(from, to) {
    await this.send("Input.dispatchMouseEvent", { type: "mousePressed", x: from[0], y: from[1], button: "left", buttons: 1, clickCount: 1 });
    for (let i = 1; i <= 5; i++) {
      const [x, y] = [0, 1].map((a) => from[a] + ((to[a] - from[a]) * i) / 5);
      await this.send("Input.dispatchMouseEvent", { type: "mouseMoved", x, y, button: "left", buttons: 1 });
    }
    await this.send("Input.dispatchMouseEvent", { type: "mouseReleased", x: to[0], y: to[1], button: "left", buttons: 0, clickCount: 1 });
  }

  async touch(...points) {
    for (const [i, at] of points.entries()) {
      await this.send("Input.dispatchTouchEvent", { type: i ? "touchMove" : "touchStart", touchPoints: at.map(([x, y], id) => ({ x, y, id })) });
    }
    await this.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
  }

  async key(code, key, held = 0) {
    await this.send("Input.dispatchKeyEvent", { type: "keyDown", code, key });
    if (held) await pause(held);
    await this.send("Input.dispatchKeyEvent", { type: "keyUp", code, key });
  }

  /** The middle of an element, brought into sight. */
  async middle(id) {
    const [x, y] = await this.run(`(() => { const e = document.getElementById("${id}"); e.scrollIntoView({ block: "center" });
      const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2]; })()`);
    return [x, y];
  }

  async press(id) {
    await this.click(...(await this.middle(id)));
  }

  /** Choose an option or move a slider, as a hand does: with the events that follow. */
  set(id, value) {
    return this.run(`(() => { const e = document.getElementById("${id}"); e.value = ${JSON.stringify(value)};
      for (const kind of ["input", "change"]) e.dispatchEvent(new Event(kind, { bubbles: true })); })()`);
  }

  async picture(path) {
    const { data } = await this.send("Page.captureScreenshot", { format: "png", captureBeyondViewport: false });
    writeFileSync(path, Buffer.from(data, "base64"));
  }

  /** What the page complained of, and what it asked of a network. */
  complaints() {
    return this.browser.told.filter((m) => m.sessionId === this.session).flatMap(({ method, params }) => {
      if (method === "Runtime.exceptionThrown") return [params.exceptionDetails.exception?.description ?? params.exceptionDetails.text];
      if (method === "Runtime.consoleAPICalled" && params.type === "error") return [JSON.stringify(params.args.map((a) => a.value))];
      if (method === "Log.entryAdded" && params.entry.level === "error") return [params.entry.text];
      if (method === "Network.requestWillBeSent" && !/^(file|blob|data):/.test(params.request.url)) return [`asked for ${params.request.url}`];
      return [];
    });
  }

  async close() {
    await this.browser.send("Target.closeTarget", { targetId: this.target });
  }
}

export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
