// One ray: what it meets, which nodes it visits, and the words for the program that trace it again.

import { Tracer } from "./trace.js";
import { normalOf } from "./colour.js";
import { nodeName } from "./tree.js";
import { counted, figure } from "./vector.js";

const MOST_LISTED = 400;

/** The shortest decimals that single precision reads back as the same number. */
export function short(x) {
  for (let digits = 6; digits < 10; digits++) {
    const text = String(Number(x.toPrecision(digits)));
    if (Math.fround(Number(text)) === Math.fround(x)) return text;
  }
  return String(x);
}

/** "ox,oy,oz,dx,dy,dz" as origin and direction in single precision, or null. */
export function readRay(text) {
  const numbers = text.trim().split(/\s*[,\s]\s*/).map(Number);
  if (numbers.length !== 6 || !numbers.every(Number.isFinite)) return null;
  const [origin, direction] = [numbers.slice(0, 3).map(Math.fround), numbers.slice(3).map(Math.fround)];
  return direction.some((x) => x !== 0) ? { origin, direction } : null;
}

export const writeRay = ({ origin, direction }) => [...origin, ...direction].map(short).join(",");

/** Trace a ray and keep every node that it enters. */
export function followed(scene, facts, ray, options) {
  const tracer = new Tracer(scene, facts), visited = [];
  tracer.trace(ray.origin, ray.direction, options, (visit) => visited.push(visit));
  const { t, u, v, triangle, instance, leaf, inner, tests, entered } = tracer;
  const hit = triangle < 0 ? null : {
    t, u, v, triangle, instance, leaf,
    geom: scene.geom[triangle], prim: scene.prim[triangle], id: instance < 0 ? null : scene.instanceId[instance],
  };
  return { hit, inner, tests, entered, visited };
}

export function showRay(parts, scene, head, facts, ray, found, told) {
  const { hit, visited } = found;
  const lines = [];
  if (hit) {
    const part = head.parts[hit.geom], n = normalOf(scene, hit.triangle, hit.instance);
    lines.push(["Meets", `triangle ${figure(hit.prim)} of ${part ? `part “${part}”` : `part ${hit.geom}`}` + (hit.id === null ? "" : `, instance ${hit.id}`)]);
    lines.push(["Distance", `${figure(Number(hit.t.toPrecision(7)))} lengths of its direction`]);
    lines.push(["Point", ray.origin.map((o, a) => short(o + hit.t * ray.direction[a])).join(", ")]);
    lines.push(["Normal", n.map((x) => x.toFixed(3)).join(", ")]);
  } else lines.push(["Meets", "nothing"]);
  const leaves = visited.filter((visit) => scene.count[visit.node]).length;
  lines.push(["Work", `${counted(found.inner, "inner node")} and ${counted(leaves, "leaf", "leaves")} entered, ${counted(found.tests, "triangle")} tested`
    + (scene.twoLevel ? `, ${counted(found.entered, "instance")} entered` : "")]);
  parts.facts.replaceChildren(...lines.flatMap(([name, text]) => [element("dt", name), element("dd", text)]));
  parts.command.textContent = `bvhc verify ${head.name} --ray ${writeRay(ray)}` + (head.frame === null ? "" : ` --frame ${head.frame}`);
  const items = visited.slice(0, MOST_LISTED).map((visit) => {
    const item = element("li"), button = element("button", nodeName(scene, facts, visit));
    button.onclick = () => told.selected(visit);
    const kind = !scene.count[visit.node] ? "" : visit.node < scene.nodes ? `, leaf of ${counted(scene.count[visit.node], "triangle")}`
      : `, leaf of ${counted(scene.count[visit.node], "instance")}`;
    item.append(button, ` from ${figure(visit.near)}${kind}`);
    if (hit && visit.node === hit.leaf && visit.instance === hit.instance) item.append(element("b", " hit"));
    return item;
  });
  parts.list.replaceChildren(...items);
  parts.count.textContent = visited.length > MOST_LISTED
    ? `The first ${MOST_LISTED} of ${figure(visited.length)} nodes, in the order in which the ray enters them`
    : `${counted(visited.length, "node")}, in the order in which the ray enters them`;
}

export function element(name, text = "", attributes = {}) {
  const made = document.createElement(name);
  made.textContent = text;
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}
