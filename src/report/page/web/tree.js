// What follows from the records of a scene: parents, depths, and what each subtree costs by the surface area heuristic.

import { movePoint } from "./vector.js";

/** What entering an inner node costs, in tests of triangles: the constant of SPEC.md, section 5.4. */
export const NODE_COST = 1.2;
export const NONE = 0xffffffff;

export function area(box, node) {
  const b = 6 * node;
  const x = box[b + 3] - box[b], y = box[b + 4] - box[b + 1], z = box[b + 5] - box[b + 2];
  return 2 * (x * y + y * z + z * x);
}

/**
 * parent, depth: of each node in its own tree. cost: the area of each node of a subtree times what a visit costs, summed. below: references of a
 * subtree. leafOf: for each instance the leaf of the top level. deepest: of the trees of triangles and of the top level.
 */
export function factsOf(scene) {
  const { total, nodes, count, first, box } = scene;
  const parent = new Uint32Array(total).fill(NONE);
  const depth = new Uint8Array(total);
  const treeOf = new Uint32Array(total).fill(NONE);
  const cost = new Float64Array(total);
  const below = new Uint32Array(total);
  const leafOf = new Uint32Array(scene.instances).fill(NONE);
  const deepest = { trees: 0, top: 0, instancesInLeaf: 1 };
  for (let tree = 0; tree < scene.trees; tree++) {
    treeOf.fill(tree, scene.nodeOffset[tree], scene.nodeOffset[tree] + scene.nodeCount[tree]);
  }
  const isUnused = (n) => first[n] === 0 && count[n] === 0 && n % 2 === 1;
  for (let n = 0; n < total; n++) {
    if (isUnused(n)) continue;
    const level = n < nodes ? "trees" : "top";
    deepest[level] = Math.max(deepest[level], depth[n]);
    if (count[n]) continue;
    for (const child of [first[n], first[n] + 1]) {
      parent[child] = n;
      depth[child] = depth[n] + 1;
    }
  }
  // Trees first, then the top level, whose leaves cost what their trees do.
  for (let step = 0; step < total; step++) {
    const n = step < nodes ? nodes - 1 - step : total - 1 - (step - nodes);
    if (isUnused(n)) continue;
    if (!count[n]) {
      cost[n] = NODE_COST * area(box, n) + cost[first[n]] + cost[first[n] + 1];
      below[n] = below[first[n]] + below[first[n] + 1];
    } else if (n < nodes) {
      cost[n] = count[n] * area(box, n);
      below[n] = count[n];
    } else {
      deepest.instancesInLeaf = Math.max(deepest.instancesInLeaf, count[n]);
      for (let i = first[n]; i < first[n] + count[n]; i++) {
        leafOf[i] = n;
        const tree = scene.instanceTree[i];
        cost[n] += worldArea(scene, i) * relativeCost(scene, cost, tree);
        below[n] += scene.refCount[tree];
      }
    }
  }
  return { parent, depth, treeOf, cost, below, leafOf, deepest };
}

/** The SAH of a tree over the area of its root. */
export function relativeCost(scene, cost, tree) {
  if (!scene.nodeCount[tree]) return 0;
  const root = scene.nodeOffset[tree], whole = area(scene.box, root);
  return whole > 0 ? cost[root] / whole : 0;
}

/** The surface of the box around the moved root of an instance's tree. */
export function worldArea(scene, instance) {
  const points = worldCorners(scene, scene.nodeOffset[scene.instanceTree[instance]], instance);
  const size = [0, 1, 2].map((a) => Math.max(...points.map((p) => p[a])) - Math.min(...points.map((p) => p[a])));
  return 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
}

/** The eight corners of a node's box in world space; `instance` is -1 for nodes that stand there. */
export function worldCorners(scene, node, instance) {
  const b = 6 * node, box = scene.box, points = [];
  for (let k = 0; k < 8; k++) {
    const p = [box[b + (k & 1 ? 3 : 0)], box[b + (k & 2 ? 4 : 1)], box[b + (k & 4 ? 5 : 2)]];
    points.push(instance >= 0 && node < scene.nodes ? movePoint(scene.toWorld, 12 * instance, p) : p);
  }
  return points;
}

/** Where rays begin: the top level's root, or that of the one tree. Null for a scene without triangles. */
export function rootOf(scene) {
  if (scene.twoLevel) return scene.total > scene.nodes ? { node: scene.topRoot, instance: -1 } : null;
  return scene.nodes ? { node: 0, instance: -1 } : null;
}

/** The children of a place in the hierarchy. Below a leaf of the top level stand the roots of its instances. */
export function childrenOf(scene, { node, instance }) {
  const { first, count } = scene;
  if (!count[node]) return [0, 1].map((side) => ({ node: first[node] + side, instance }));
  if (node < scene.nodes) return [];
  const out = [];
  for (let i = first[node]; i < first[node] + count[node]; i++) {
    const tree = scene.instanceTree[i];
    if (scene.nodeCount[tree]) out.push({ node: scene.nodeOffset[tree], instance: i });
  }
  return out;
}

/** The places from the root down to one. */
export function pathTo(scene, facts, { node, instance }) {
  const path = [];
  for (let n = node; n !== NONE; n = facts.parent[n]) path.unshift({ node: n, instance: n < scene.nodes ? instance : -1 });
  if (node < scene.nodes && instance >= 0) {
    for (let n = facts.leafOf[instance]; n !== NONE; n = facts.parent[n]) path.unshift({ node: n, instance: -1 });
  }
  return path;
}

/** A node as a person finds it in the file: its number in its own tree. */
export function nodeName(scene, facts, { node, instance }) {
  if (node >= scene.nodes) return `top-level node ${node - scene.nodes}`;
  const tree = facts.treeOf[node];
  const own = node - scene.nodeOffset[tree];
  if (instance >= 0) return `node ${own} of tree ${tree} in instance ${scene.instanceId[instance]}`;
  return scene.trees > 1 ? `node ${own} of tree ${tree}` : `node ${own}`;
}

/**
 * The places that lie `level` steps below a place, and leaves above that level, at most so many. Which are left out is told by `all`.
 */
export function cutAt(scene, from, level, most) {
  let row = [from], done = [];
  for (let step = 0; step < level && row.length; step++) {
    const next = [];
    for (const place of row) {
      const children = childrenOf(scene, place);
      if (children.length) next.push(...children);
      else done.push(place);
    }
    row = next;
    if (row.length + done.length > 8 * most) break;
  }
  const places = done.concat(row);
  return { places: places.slice(0, most), all: places.length <= most };
}
