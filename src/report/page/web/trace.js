// Traversal on the CPU in double precision, as SPEC.md, section 10, says: hits are those of the program, ties included.

import { moveDirection, movePoint } from "./vector.js";

/** Which child is entered first. The key stands in the menus and in the shader. */
export const ORDERS = { near: 0, big: 1, origin: 2, stored: 3, far: 4 };
const INSTANCE = 0x80000000;
/** Box planes and distances are widened by this share of themselves, far more than double precision rounds. */
const SLACK = 1e-12;

/** Work of one ray, and its hit: `triangle` is -1 where it misses. */
export class Tracer {
  constructor(scene, facts) {
    this.scene = scene;
    this.facts = facts;
    const size = facts.deepest.trees + facts.deepest.top + facts.deepest.instancesInLeaf + 4;
    this.stack = new Uint32Array(size);
    this.nearOf = new Float64Array(size);
    this.o = [0, 0, 0];
    this.d = [0, 0, 0];
  }

  /**
   * Trace a ray. `options`: order, root (a place), brute (the number of triangles that are tried without the tree, 0 for none).
   * `log`, where given, gets every node that is entered: {node, instance, near}.
   */
  trace(origin, direction, options, log = null) {
    this.t = Infinity;
    this.u = this.v = 0;
    this.triangle = this.instance = -1;
    this.leaf = 0;
    this.inner = this.tests = this.entered = 0;
    this.usable = origin.every(Number.isFinite) && direction.every(Number.isFinite) && direction.some((x) => x !== 0);
    if (!this.usable) return this;
    this.world = [origin, direction];
    if (options.brute) this.everyTriangle(options.brute);
    else if (options.root) this.walk(options.root, options.order ?? 0, log);
    return this;
  }

  /** Make the ray ready for a space. */
  aim(o, d) {
    this.o = o;
    this.d = d;
    const size = d.map(Math.abs);
    const z = size[0] > size[1] ? (size[0] > size[2] ? 0 : 2) : size[1] > size[2] ? 1 : 2;
    this.z = z;
    this.x = (z + 1) % 3;
    this.y = (z + 2) % 3;
    this.sx = d[this.x] / d[z];
    this.sy = d[this.y] / d[z];
  }

  enter(instance) {
    const [o, d] = this.world;
    if (instance < 0) return this.aim(o, d);
    this.aim(movePoint(this.scene.toObject, 12 * instance, o), moveDirection(this.scene.toObject, 12 * instance, d));
  }

  /** Where the ray enters a node's box before the best hit, or Infinity. */
  near(node) {
    const box = this.scene.box, b = 6 * node, o = this.o, d = this.d;
    let t0 = 0, t1 = this.t;
    for (let a = 0; a < 3; a++) {
      let low = box[b + a], high = box[b + 3 + a];
      const slack = SLACK * Math.max(Math.abs(low), Math.abs(high), Math.abs(o[a]));
      low -= slack;
      high += slack;
      if (d[a] === 0) {
        if (o[a] < low || o[a] > high) return Infinity;
        continue;
      }
      let near = (low - o[a]) / d[a], far = (high - o[a]) / d[a];
      if (near > far) [near, far] = [far, near];
      if (near > t0) t0 = near;
      if (far < t1) t1 = far;
    }
    return t0 <= t1 * (1 + SLACK) ? t0 : Infinity;
  }

  walk(root, order, log) {
    const { first, count, nodes } = this.scene;
    const { stack, nearOf } = this;
    let instance = root.instance, depth = 0, base = -1;
    this.enter(instance);
    let node = root.node, near = this.near(node);
    if (near === Infinity) return;
    for (;;) {
      log?.({ node, instance, near });
      let next = -1;
      if (!count[node]) {
        this.inner++;
        const a = first[node], nearA = this.near(a), nearB = this.near(a + 1);
        const hitA = nearA !== Infinity, hitB = nearB !== Infinity;
        if (hitA && hitB) {
          const second = this.secondFirst(a, nearA, nearB, order);
          stack[depth] = second ? a : a + 1;
          nearOf[depth++] = second ? nearA : nearB;
          next = second ? a + 1 : a;
          near = second ? nearB : nearA;
        } else if (hitA || hitB) {
          next = hitA ? a : a + 1;
          near = hitA ? nearA : nearB;
        }
      } else if (node < nodes) {
        for (let i = first[node]; i < first[node] + count[node]; i++) this.test(i, instance, node);
      } else {
        for (let i = first[node] + count[node] - 1; i >= first[node]; i--) {
          stack[depth] = (INSTANCE | i) >>> 0;
          nearOf[depth++] = near;
        }
      }

      // Take up what was put off and does not lie behind the best hit.
      while (next < 0) {
        if (depth === base) {
          instance = base = -1;
          this.enter(-1);
        }
        if (depth === 0) return;
        near = nearOf[--depth];
        if (near > this.t * (1 + SLACK)) continue;
        if (stack[depth] < INSTANCE) {
          next = stack[depth];
          continue;
        }
        const i = stack[depth] & ~INSTANCE, tree = this.scene.instanceTree[i];
        if (!this.scene.nodeCount[tree]) continue;
        this.entered++;
        this.enter(i);
        near = this.near(this.scene.nodeOffset[tree]);
        if (near === Infinity) {
          this.enter(-1);
          continue;
        }
        instance = i;
        base = depth;
        next = this.scene.nodeOffset[tree];
      }
      node = next;
    }
  }

  /** Of two children that the ray meets, whether the second is entered first. */
  secondFirst(a, nearA, nearB, order) {
    switch (order) {
      case ORDERS.near: return nearB < nearA;
      case ORDERS.far: return nearB > nearA;
      case ORDERS.big: return this.surface(a + 1) > this.surface(a);
      case ORDERS.origin: return !this.holds(a) && this.holds(a + 1);
      default: return false;
    }
  }

  surface(node) {
    const box = this.scene.box, b = 6 * node;
    const x = box[b + 3] - box[b], y = box[b + 4] - box[b + 1], z = box[b + 5] - box[b + 2];
    return x * y + y * z + z * x;
  }

  holds(node) {
    const box = this.scene.box, b = 6 * node, o = this.o;
    return [0, 1, 2].every((a) => box[b + a] <= o[a] && o[a] <= box[b + 3 + a]);
  }

  /** The first so many triangles, instance after instance, without any box. */
  everyTriangle(most) {
    const scene = this.scene;
    if (!scene.twoLevel) {
      this.enter(-1);
      for (let i = 0; i < Math.min(most, scene.triangles); i++) this.test(i, -1, 0);
      return;
    }
    for (let instance = 0; instance < scene.instances && this.tests < most; instance++) {
      this.enter(instance);
      const start = scene.refOffset[scene.instanceTree[instance]], end = start + scene.refCount[scene.instanceTree[instance]];
      for (let i = start; i < end && this.tests < most; i++) this.test(i, instance, 0);
    }
  }

  /** The watertight test of Woop, Benthin and Wald (2013), both sides. */
  test(triangle, instance, leaf) {
    this.tests++;
    const c = this.scene.corner, p = 9 * triangle, { x, y, z, sx, sy, o, d } = this;
    const az = c[p + z] - o[z], bz = c[p + 3 + z] - o[z], cz = c[p + 6 + z] - o[z];
    const ax = c[p + x] - o[x] - sx * az, ay = c[p + y] - o[y] - sy * az;
    const bx = c[p + 3 + x] - o[x] - sx * bz, by = c[p + 3 + y] - o[y] - sy * bz;
    const cx = c[p + 6 + x] - o[x] - sx * cz, cy = c[p + 6 + y] - o[y] - sy * cz;
    const u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return;
    const det = u + v + w;
    if (det === 0) return;
    const t = (u * az + v * bz + w * cz) / d[z] / det;
    if (!(t >= 0) || t > this.t || (t === this.t && !this.comesFirst(triangle, instance))) return;
    this.t = t;
    this.u = v / det;
    this.v = w / det;
    this.triangle = triangle;
    this.instance = instance;
    this.leaf = leaf;
  }

  /** Of equal distances the smaller instance, part and triangle. */
  comesFirst(triangle, instance) {
    if (this.triangle < 0) return true;
    const { instanceId, geom, prim } = this.scene;
    const id = (i) => (i < 0 ? -1 : instanceId[i]);
    const other = this.triangle;
    return (id(instance) - id(this.instance) || geom[triangle] - geom[other] || prim[triangle] - prim[other] || triangle - other) < 0;
  }
}
