"""Tracing a ray through a checked file, as section 10 of SPEC.md says: plain, slow, in double precision.

`file` is a still file, or a frame of a sequence: `File.frame(i)` of bvhc_reader.py.
"""

import math


def closest_hit(file, origin, direction, t_min=0.0, t_max=math.inf):
    """The nearest hit as {"t", "u", "v", "geom", "prim", "instance"}, or None. `instance` is None in a one-level file."""
    best = Best(t_min, t_max)
    if not file.two_level:
        for b in file.blas:
            trace_blas(file, b, origin, direction, None, best)
        return best.hit

    def instances(first, count):
        for i in file.inst[first:first + count]:
            m = [float(x) for x in i["world_to_object"]]
            o = [sum(m[4 * r + c] * origin[c] for c in range(3)) + m[4 * r + 3] for r in range(3)]
            d = [sum(m[4 * r + c] * direction[c] for c in range(3)) for r in range(3)]
            trace_blas(file, file.blas[int(i["blas"])], o, d, int(i["id"]), best)

    walk(file.tnod, origin, direction, best, instances)
    return best.hit


def trace_blas(file, b, origin, direction, instance, best):
    nodes, _ = file.tree(b)
    start = int(b["ref_offset"])

    def triangles(first, count):
        for t in file.tris[start + first:start + first + count]:
            hit = intersect(origin, direction, t["v0"].tolist(), t["v1"].tolist(), t["v2"].tolist())
            if hit:
                best.offer(hit, instance, int(t["geom"]), int(t["prim"]))

    walk(nodes, origin, direction, best, triangles)


class Best:
    """The nearest hit so far; of equal distances the smallest (instance, geom, prim)."""

    def __init__(self, t_min, t_max):
        self.t_min, self.t_max, self.key, self.hit = t_min, t_max, None, None

    def offer(self, hit, instance, geom, prim):
        t, u, v = hit
        key = (t, -1 if instance is None else instance, geom, prim)
        if self.t_min <= t <= self.t_max and (self.key is None or key < self.key):
            self.t_max, self.key = t, key
            self.hit = {"t": t, "u": u, "v": v, "instance": instance, "geom": geom, "prim": prim}


def walk(nodes, origin, direction, best, leaf):
    """Visit every leaf whose box the ray may enter before the best hit, nearer child first."""
    stack = [0] if len(nodes) else []
    while stack:
        n = nodes[stack.pop()]
        if entry(n, origin, direction, best) is None:
            continue
        first, count = int(n["first"]), int(n["count"])
        if count:
            leaf(first, count)
        else:
            near = [(entry(nodes[c], origin, direction, best), c) for c in (first, first + 1)]
            stack += [c for t, c in sorted(((t, c) for t, c in near if t is not None), reverse=True)]


def entry(n, origin, direction, best):
    """Where the ray enters the node's box, or None. Widened by far more than double precision rounds (conservative)."""
    t0, t1 = best.t_min, best.t_max
    for low, high, o, d in zip(n["min"].tolist(), n["max"].tolist(), origin, direction):
        slack = 1e-9 * max(abs(low), abs(high), abs(o))
        low, high = low - slack, high + slack
        if d == 0.0:
            if not low <= o <= high:
                return None
        else:
            near, far = sorted(((low - o) / d, (high - o) / d))
            t0, t1 = max(t0, near), min(t1, far)
    return t0 if t0 <= t1 * (1 + 1e-12) else None


def intersect(origin, direction, v0, v1, v2):
    """Watertight test after Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection" (2013): (t, u, v) or None.

    u and v weigh v1 and v2. Both sides are hit.
    """
    z = max(range(3), key=lambda axis: abs(direction[axis]))
    if direction[z] == 0.0:
        return None
    x, y = (z + 1) % 3, (z + 2) % 3
    sx, sy = direction[x] / direction[z], direction[y] / direction[z]
    a, b, c = ([corner[axis] - origin[axis] for axis in range(3)] for corner in (v0, v1, v2))
    ax, ay, bx, by, cx, cy = (p[s] - shear * p[z] for p in (a, b, c) for s, shear in ((x, sx), (y, sy)))
    u, v, w = cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax
    if min(u, v, w) < 0 < max(u, v, w):
        return None
    det = u + v + w
    if det == 0.0:
        return None
    t = (u * a[z] + v * b[z] + w * c[z]) / direction[z] / det
    return t, v / det, w / det
