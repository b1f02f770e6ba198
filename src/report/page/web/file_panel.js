// What a file holds, in words and in rows.

import { counted, figure } from "./vector.js";

const sum = (numbers) => numbers.reduce((a, b) => a + b, 0);

/** Triangles that a ray without the tree tests: those of every instance. */
export function testedOf({ scene }) {
  return scene.twoLevel ? sum(Array.from(scene.instanceTree, (tree) => scene.refCount[tree])) : scene.triangles;
}

/** Records of nodes but the second of each tree, which is unused. */
export const nodesOf = ({ scene }) => sum(Array.from(scene.nodeCount, (n) => Math.max(n - 1, 0))) + Math.max(scene.counts.top_nodes - 1, 0);

/** A file in one line. */
export function lineOf(one) {
  const { scene } = one, shown = sum(Array.from(scene.instanceTree, (tree) => scene.primCount[tree]));
  return `${counted(sum(scene.primCount), "triangle")}, ${counted(nodesOf(one), "node")}`
    + (scene.twoLevel ? `; ${counted(scene.instances, "instance")} of ${counted(scene.trees, "tree")} show ${counted(shown, "triangle")}` : "");
}

export function fileRows(one, version) {
  const { head, scene } = one;
  return [
    ["Name", head.name], ...(head.frame === null ? [] : [["Frame", String(head.frame)]]), ...head.facts,
    ["Triangles", figure(sum(scene.primCount))], ["References", `${figure(scene.triangles)} in leaves`], ["Nodes", figure(nodesOf(one))],
    ["Trees", figure(scene.trees)], ["Instances", figure(scene.instances)], ["Parts", figure(scene.parts)], ["Page by", `bvhc ${version}`],
  ];
}

/** How many pixels show which part or instance, the most first: [number, name, share of the picture]. */
export function sharesOf(shade, { hit }, { scene, head }) {
  const seen = new Map();
  for (let at = 0; at < hit.length; at += 4) {
    if (!hit[at]) continue;
    const key = shade === "part" ? scene.geom[hit[at] - 1] : hit[at + 1] ? scene.instanceId[hit[at + 1] - 1] : 0;
    seen.set(key, (seen.get(key) ?? 0) + 1);
  }
  const name = (key) => (shade === "part" ? head.parts[key] || `part ${key}` : `instance ${key}`);
  return [...seen].sort((a, b) => b[1] - a[1] || a[0] - b[0]).map(([key, pixels]) => [key, name(key), (4 * pixels) / hit.length]);
}
