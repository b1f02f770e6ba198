// Mouse, touch and keys. A drag circles, a second finger or another button moves, a click picks.

const CLICK = 5; // pixels that a finger may slip in a click
const MOVES = { KeyW: [0, 0, 1], KeyS: [0, 0, -1], KeyA: [-1, 0, 0], KeyD: [1, 0, 0], KeyE: [0, 1, 0], KeyQ: [0, -1, 0] };
const TURNS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** `told`: moved() after each change of the camera, clicked(x, y) in shares of the picture, key(code) for keys that steer nothing. */
export function steer(element, camera, told) {
  const fingers = new Map();
  let slipped = false, pinch = 0;

  element.addEventListener("pointerdown", (e) => {
    element.focus({ preventScroll: true });
    element.setPointerCapture?.(e.pointerId);
    fingers.set(e.pointerId, [e.clientX, e.clientY]);
    if (fingers.size === 1) slipped = false;
    else slipped = true;
    pinch = 0;
    fingers.start = [e.clientX, e.clientY];
  });
  element.addEventListener("pointermove", (e) => {
    const before = fingers.get(e.pointerId);
    if (!before) return;
    const dx = e.clientX - before[0], dy = e.clientY - before[1];
    if (Math.hypot(e.clientX - fingers.start[0], e.clientY - fingers.start[1]) > CLICK) slipped = true;
    if (!slipped) return;
    fingers.set(e.pointerId, [e.clientX, e.clientY]);
    const pixel = (2 * camera.reach * camera.halves()[1]) / element.clientHeight;
    if (fingers.size === 2) {
      const [a, b] = [...fingers.values()];
      const apart = Math.hypot(a[0] - b[0], a[1] - b[1]);
      if (pinch) camera.zoom(pinch / Math.max(apart, 1));
      pinch = apart;
      camera.move((-dx * pixel) / 2, (dy * pixel) / 2, 0);
    } else if (e.buttons & 6 || e.shiftKey) camera.move(-dx * pixel, dy * pixel, 0);
    else camera.circle(dx * 0.007, -dy * 0.007);
    told.moved();
  });
  const lift = (e) => {
    if (!fingers.delete(e.pointerId)) return;
    pinch = 0;
    if (slipped || fingers.size || e.type === "pointercancel" || e.button > 0) return;
    const at = element.getBoundingClientRect();
    told.clicked((e.clientX - at.left) / at.width, (e.clientY - at.top) / at.height);
  };
  element.addEventListener("pointerup", lift);
  element.addEventListener("pointercancel", lift);
  element.addEventListener("contextmenu", (e) => e.preventDefault());
  element.addEventListener("wheel", (e) => {
    e.preventDefault();
    camera.zoom(Math.exp(Math.min(Math.max(e.deltaY, -200), 200) * 0.0015));
    told.moved();
  }, { passive: false });

  const held = new Set();
  let last = 0;
  const go = (code, time) => {
    const pace = camera.size * 0.25 * time * (held.has("fast") ? 4 : 1);
    if (MOVES[code]) camera.move(...MOVES[code].map((x) => x * pace));
    if (TURNS[code]) camera.turn(...TURNS[code].map((x) => x * time * 1.2));
    told.moved();
  };
  const fly = (now) => {
    if (!held.size) return;
    const time = Math.min((now - last) / 1000, 0.1);
    last = now;
    for (const code of held) go(code, time);
    requestAnimationFrame(fly);
  };
  element.addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey) return;
    if (e.shiftKey) held.add("fast");
    if (MOVES[e.code] || TURNS[e.code]) {
      e.preventDefault();
      if (held.size === (held.has("fast") ? 1 : 0)) {
        last = performance.now();
        requestAnimationFrame(fly);
      }
      held.add(e.code);
      // Keys that are let go before the next frame move as well.
      if (!e.repeat) go(e.code, 0.03);
    } else if (told.key(e.code)) e.preventDefault();
  });
  element.addEventListener("keyup", (e) => {
    held.delete(e.code);
    if (!e.shiftKey) held.delete("fast");
  });
  element.addEventListener("blur", () => held.clear());
}
