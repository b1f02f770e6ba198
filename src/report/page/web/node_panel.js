// The selected node: the way from the root, what it holds and costs.

import { area, childrenOf, nodeName, pathTo, rootOf } from "./tree.js";
import { counted, percent } from "./vector.js";
import { element, short } from "./ray_panel.js";
import { isSame } from "./treemap.js";

/** What is said of a place. `weight` is the cost of a place, as the map of the tree has it. */
export function nodeLines(scene, facts, place, weight) {
  const { node, instance } = place, count = scene.count[node];
  const root = rootOf(scene), b = 6 * node;
  const low = Array.from(scene.box.subarray(b, b + 3)), high = Array.from(scene.box.subarray(b + 3, b + 6));
  const own = node < scene.nodes ? scene.nodeOffset[facts.treeOf[node]] : scene.topRoot;
  const inside = node < scene.nodes && instance >= 0;
  return [
    ["Kind", !count ? "inner node" : node < scene.nodes ? `leaf of ${counted(count, "triangle")}` : `leaf of ${counted(count, "instance")}`],
    ["Depth", `${facts.depth[node]}${inside ? " in its tree" : ""}`],
    ["Below", `${counted(facts.below[node], "reference")} to triangles`],
    ["Area", `${percent(area(scene.box, node) / area(scene.box, own))} of the root of its tree`],
    ["SAH cost", `${percent(weight(place) / weight(root))} of the whole`],
    ["Box from", low.map(short).join(", ")],
    ["to", high.map(short).join(", ") + (inside ? " (space of the mesh)" : "")],
  ];
}

export function showNode(parts, scene, facts, place, weight, told) {
  const path = pathTo(scene, facts, place);
  const crumbs = path.map((at, i) => {
    const sameTree = i > 0 && at.instance === path[i - 1].instance;
    const siblings = i > 0 && sameTree ? childrenOf(scene, path[i - 1]) : [];
    const side = siblings.length === 2 && !scene.count[path[i - 1].node] ? (isSame(siblings[0], at) ? "1st" : "2nd") : "";
    const text = i === 0 ? "root" : !sameTree ? `instance ${scene.instanceId[at.instance]}` : side;
    const button = element("button", text, { title: nodeName(scene, facts, at) });
    if (isSame(at, place)) button.setAttribute("aria-current", "true");
    button.onclick = () => told.selected(at);
    return button;
  });
  parts.crumbs.replaceChildren(...crumbs);
  parts.crumbs.scrollLeft = parts.crumbs.scrollWidth;
  parts.name.textContent = nodeName(scene, facts, place);
  const lines = nodeLines(scene, facts, place, weight);
  parts.facts.replaceChildren(...lines.flatMap(([name, text]) => [element("dt", name), element("dd", text)]));
  const children = childrenOf(scene, place);
  parts.parent.disabled = path.length < 2;
  parts.first.disabled = !children[0];
  parts.second.disabled = !children[1];
  parts.parent.onclick = () => told.selected(path[path.length - 2]);
  parts.first.onclick = () => told.selected(children[0]);
  parts.second.onclick = () => told.selected(children[1]);
}
