// From the bytes of the page back to the records of the file, bit for bit: the other end of pack.rs.

/** Bytes that are taken one stream after the other. */
class Streams {
  constructor(bytes) {
    this.bytes = bytes;
    this.at = 0;
  }

  take(length) {
    const taken = this.bytes.subarray(this.at, this.at + length);
    if (taken.length < length) throw new Error("the data of the page ends too early");
    this.at += length;
    return taken;
  }

  /** Numbers from four planes of bytes. */
  words(count) {
    const planes = this.take(4 * count);
    const out = new Uint32Array(count);
    for (let i = 0; i < count; i++) {
      out[i] = (planes[i] | (planes[i + count] << 8) | (planes[i + 2 * count] << 16) | (planes[i + 3 * count] << 24)) >>> 0;
    }
    return out;
  }

  floats(count) {
    return new Float32Array(this.words(count).buffer);
  }

  /** Numbers from their differences. */
  running(count) {
    const out = this.words(count);
    let sum = 0;
    for (let i = 0; i < count; i++) out[i] = sum = (sum + unfolded(out[i])) >>> 0;
    return out;
  }
}

/** 0, 1, 2, 3, … as 0, −1, 1, −2, … */
const unfolded = (folded) => (folded >>> 1) ^ -(folded & 1);

/** The bits of the number that has this place in the order of all. */
const numbered = (place) => ((place | 0) >= 0 ? place : place ^ 0x7fffffff) >>> 0;

/** The place of a number in the order of all, from its bits. */
const ordered = (bits) => (bits >>> 31 ? bits ^ 0x7fffffff : bits) >>> 0;

/** The bytes behind base64 and zlib. */
export async function inflated(base64) {
  const packed = Uint8Array.from(atob(base64.trim()), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * The records of a scene. Nodes of all trees stand in one array, those of the top level behind them; children, references and instances
 * are numbered over all of it, so that traversal needs no offsets.
 *
 * box: f32[6 a node], min then max. first, count: u32[nodes]. corner: f32[9 a triangle]. prim, geom, flags: [triangles].
 */
export function unpacked(bytes, counts) {
  const from = new Streams(bytes);
  const { nodes, top_nodes: topNodes, triangles, vertices, planes, trees, instances, parts } = counts;
  const nodeCount = from.words(trees);
  const refCount = from.words(trees);
  const primCount = from.words(trees);
  const sah = from.floats(trees);
  const total = nodes + topNodes;
  const count = new Uint8Array(total);
  count.set(from.take(nodes), 0);
  count.set(from.take(topNodes), nodes);

  const axes = [0, 1, 2].map(() => {
    const places = from.running(vertices);
    for (let i = 0; i < vertices; i++) places[i] = numbered(places[i]);
    return new Float32Array(places.buffer);
  });
  const back = from.words(3 * triangles);
  const corner = new Float32Array(9 * triangles);
  for (let i = 0, next = 0; i < back.length; i++) {
    const at = back[i] ? next - back[i] : next++;
    for (let axis = 0; axis < 3; axis++) corner[3 * i + axis] = axes[axis][at];
  }
  const scene = {
    counts, nodes, total, count, corner, sah, nodeCount, refCount, primCount,
    prim: from.running(triangles),
    geom: from.running(triangles),
    flags: from.take(triangles),
    first: new Uint32Array(total),
    box: new Float32Array(6 * total),
    nodeOffset: new Uint32Array(trees),
    refOffset: new Uint32Array(trees),
    twoLevel: topNodes > 0 || instances > 0,
    topRoot: nodes,
    triangles, instances, parts, trees,
  };

  let nodeAt = 0, refAt = 0;
  for (let tree = 0; tree < trees; tree++) {
    scene.nodeOffset[tree] = nodeAt;
    scene.refOffset[tree] = refAt;
    link(scene, nodeAt, nodeCount[tree], refAt);
    nodeAt += nodeCount[tree];
    refAt += refCount[tree];
  }
  link(scene, nodes, topNodes, 0);

  const masks = from.take(total);
  const missing = from.words(planes);
  let at = 0;
  // Planes of a node lean on those of its children, so they are filled from the leaves up; each must know where its own begin.
  const start = new Uint32Array(total);
  for (let n = 0; n < total; n++) {
    start[n] = at;
    at += bits(masks[n]);
  }
  const box = scene.box;
  const boxBits = new Uint32Array(box.buffer);
  const unused = new Uint8Array(total);
  for (let tree = 0; tree < trees; tree++) if (nodeCount[tree]) unused[scene.nodeOffset[tree] + 1] = 1;
  if (topNodes) unused[nodes + 1] = 1;
  for (let n = total - 1; n >= 0; n--) {
    const b = 6 * n;
    if (!unused[n]) {
      if (!count[n]) unite(box, b, 6 * scene.first[n]);
      else if (n < nodes) hold(box, b, corner, 9 * scene.first[n], 9 * (scene.first[n] + count[n]));
    }
    for (let plane = 0, next = start[n]; plane < 6; plane++) {
      if (masks[n] & (1 << plane)) boxBits[b + plane] = numbered((ordered(boxBits[b + plane]) + unfolded(missing[next++])) >>> 0);
    }
  }

  // Twelve numbers of each map stand together, as traversal reads them.
  const matrices = new Float32Array(24 * instances);
  for (let word = 0; word < 24; word++) {
    const column = from.floats(instances);
    for (let i = 0; i < instances; i++) matrices[(word < 12 ? 0 : 12 * instances) + 12 * i + (word % 12)] = column[i];
  }
  scene.toWorld = matrices.subarray(0, 12 * instances);
  scene.toObject = matrices.subarray(12 * instances);
  scene.instanceTree = from.words(instances);
  scene.instanceId = from.words(instances);
  scene.instanceNode = from.words(instances);
  scene.partMesh = from.words(parts);
  scene.partNumber = from.words(parts);
  scene.partFirst = from.words(parts);
  scene.partKept = from.words(parts);
  return scene;
}

function bits(mask) {
  let n = 0;
  for (; mask; mask &= mask - 1) n++;
  return n;
}

/** Children and references of a tree, which follow from the order of its nodes: a pair, what is below its first node, then below its second. */
function link(scene, offset, nodeCount, reference) {
  if (!nodeCount) return;
  const pending = [offset];
  let pair = offset + 2;
  while (pending.length) {
    const n = pending.pop();
    if (scene.count[n]) {
      scene.first[n] = reference;
      reference += scene.count[n];
    } else {
      scene.first[n] = pair;
      pending.push(pair + 1, pair);
      pair += 2;
    }
  }
}

/** The smallest box around the two of a pair. */
function unite(box, at, child) {
  for (let axis = 0; axis < 3; axis++) {
    const low = box[child + axis], otherLow = box[child + 6 + axis];
    const high = box[child + 3 + axis], otherHigh = box[child + 9 + axis];
    box[at + axis] = otherLow < low ? otherLow : low;
    box[at + 3 + axis] = otherHigh > high ? otherHigh : high;
  }
}

/** The smallest box around corners. */
function hold(box, at, corner, from, end) {
  for (let axis = 0; axis < 3; axis++) {
    let low = Infinity, high = -Infinity;
    for (let i = from + axis; i < end; i += 3) {
      if (corner[i] < low) low = corner[i];
      if (corner[i] > high) high = corner[i];
    }
    box[at + axis] = low;
    box[at + 3 + axis] = high;
  }
}
