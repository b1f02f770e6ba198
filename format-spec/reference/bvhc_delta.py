"""Codec 2, differences, as section 8.1 of SPEC.md says: from packed bytes to those of TRIX, VPOS and NODE. Plain and slow.

Numbers are IEEE binary64, one operation after the other: Python's own, and numpy's where many are worked on side by side.
"""

import math
import struct

import numpy as np

NODE = np.dtype([("min", "<f4", 3), ("first", "<u4"), ("max", "<f4", 3), ("count", "<u4")])
TRIX = np.dtype([("corners", "<u4", 3), ("prim", "<u4"), ("geom", "<u4"), ("flags", "<u4")])
BEFORE = 8  # vertices before one, from whose motion its own is expected


class Undecodable(ValueError):
    """Packed bytes that lead to nothing: E0205."""


def require(condition, rule):
    if not condition:
        raise Undecodable(rule)


class Differences:
    """The sections of a sequence, from checked rows of TOPO and POSE. TRIX comes first, then each VPOS, then each NODE, by their numbers.

    Poses lean on earlier ones, which may be stored with any codec: `learn` keeps what they need of every decoded section.
    """

    def __init__(self, topo, pose):
        self.topo, self.topology, self.block = topo, pose["topology"].astype(int), pose["block"].astype(int)
        self.poses = [np.flatnonzero(self.topology == t) for t in range(len(topo))]  # of each topology, in the order of rows
        self.points, self.weights, self.shapes = {}, {}, {}  # by pose, by topology, by topology

    def records(self, i, name):
        """How many a pose has."""
        return int(self.topo[{"VPOS": "vertex_count", "NODE": "node_count"}[name]][self.topology[i]])

    def in_block(self, block):
        return np.flatnonzero(self.block == block)

    def is_first(self, i):
        return self.poses[self.topology[i]][0] == i

    def packed_len(self, name, block, raw_len):
        if name == "VPOS":
            return sum(8 + 12 * self.records(i, name) for i in self.in_block(block))
        if name == "NODE":
            return sum(5 * self.records(i, name) for i in self.in_block(block) if self.is_first(i))
        return raw_len

    def decode(self, name, block, packed):
        if name == "TRIX":
            return triangles(packed)
        rest, out = Taken(packed), []
        for i in self.in_block(block):
            out.append(self.positions(i, rest) if name == "VPOS" else self.nodes(i, rest))
        return b"".join(out)

    def learn(self, name, block, raw):
        """Keep the corners of TRIX, the positions of VPOS, and of NODE the shape of each first pose."""
        if name == "TRIX":
            self.corners = np.frombuffer(raw, TRIX)["corners"]
        rest = Taken(raw)
        for i in self.in_block(block) if name in ("VPOS", "NODE") else []:
            if name == "VPOS":
                self.keep(i, np.frombuffer(rest.take(12 * self.records(i, name)), "<f4").reshape(-1, 3))
            else:
                nodes = np.frombuffer(rest.take(32 * self.records(i, name)), NODE)
                self.shapes.setdefault(self.topology[i], (nodes["first"], nodes["count"]))

    def positions(self, i, rest):
        """A pose's records of VPOS [8.1.3]."""
        n, t = self.records(i, "VPOS"), self.topology[i]
        scale, = struct.unpack("<d", rest.take(8))
        require(struct.pack("<d", scale) == bytes(8) or 2.0**-100 <= scale <= 2.0**100, "scale of pose %d" % i)
        differences = [unfold(numbers(rest.take(4 * n))).astype("<i4").tolist() for _ in range(3)]
        rank = int(np.searchsorted(self.poses[t], i))  # poses of the topology before this one
        base = self.points[self.poses[t][rank & (rank - 1)]].astype(float).T.tolist() if rank else [[0.0] * n] * 3
        if rank and t not in self.weights:
            self.weights[t] = [row[:v] for v, row in enumerate(weights(self.points[self.poses[t][0]]).tolist())]
        axes = [axis(d, b, scale, self.weights[t] if rank else None) for d, b in zip(differences, base)]
        self.keep(i, np.array(axes, "<f4").T)
        return self.points[i].tobytes()

    def keep(self, i, points):
        require(np.isfinite(points).all(), "a coordinate of pose %d is not finite" % i)  # no file may have it (E0417), and none leans on it
        self.points[i] = points

    def nodes(self, i, rest):
        """A pose's records of NODE [8.1.2]."""
        n, t = self.records(i, "NODE"), self.topology[i]
        if self.is_first(i):
            self.shapes[t] = shape(rest.take(5 * n), n)
        nodes = np.zeros(n, NODE)
        nodes["first"], nodes["count"] = self.shapes[t]
        start, count = int(self.topo["ref_offset"][t]), int(self.topo["ref_count"][t])
        corners = self.corners[start:start + count]
        require((corners < self.records(i, "VPOS")).all(), "a corner of topology %d is no vertex" % t)
        fit(nodes, self.points[i][corners])
        return nodes.tobytes()


class Taken:
    """Bytes that are taken one piece after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, length):
        self.at += length
        return self.data[self.at - length:self.at]


def numbers(planes):
    """Unsigned integers of 32 bits from four planes."""
    return np.ascontiguousarray(np.frombuffer(planes, "u1").reshape(4, -1).T).view("<u4").reshape(-1)


def unfold(folded):
    """0, 1, 2, 3, ... to 0, -1, 1, -2, ..., modulo 2**32."""
    return folded >> np.uint32(1) ^ np.uint32(0) - (folded & np.uint32(1))


def triangles(packed):
    """TRIX [8.1.1]."""
    words = [unfold(numbers(packed[k:k + len(packed) // 6])) for k in range(0, len(packed), len(packed) // 6 or 1)]
    out = np.zeros(len(packed) // 24, TRIX)
    if len(out):
        corners = np.stack(words[:3], axis=1).reshape(-1)
        met = corners == 0  # the corner is the expected one, and the next is expected to be larger by one
        out["corners"] = (corners + running(met) - met).reshape(-1, 3)
        out["prim"], out["geom"], out["flags"] = running(words[3]), running(words[4]), words[5]
    return out.tobytes()


def shape(packed, n):
    """`first` and `count` of a tree's nodes."""
    count = np.frombuffer(packed, "u1", n, 4 * n).astype("<u4")
    first, leaf = numbers(packed[:4 * n]).copy(), count > 0
    first[~leaf] = running(first[~leaf])
    first[leaf] = running(first[leaf]) + running(count[leaf]) - count[leaf]
    return first, count


def running(differences):
    """Their sums from the first to each, modulo 2**32."""
    return np.cumsum(differences, dtype="<u4")


def fit(nodes, corners):
    """Give each node the smallest box around what it holds; `corners` are those of the references, f32[references, 3, 3]."""
    first, count = nodes["first"].astype(int), nodes["count"].astype(int)
    leaf = np.flatnonzero((count > 0) & (np.arange(len(nodes)) != 1))
    require((first[leaf] + count[leaf] <= len(corners)).all(), "a leaf holds a triangle that is not there")
    for n in leaf:
        held = corners[first[n]:first[n] + count[n]].reshape(-1, 3)
        nodes["min"][n], nodes["max"][n] = last(np.argmin, held), last(np.argmax, held)
    for n in np.flatnonzero(count == 0)[::-1]:
        if n != 1:
            require(n < first[n] < len(nodes) - 1, "the children of node %d do not stand behind it" % n)
            pair = slice(first[n], first[n] + 2)
            nodes["min"][n], nodes["max"][n] = last(np.argmin, nodes["min"][pair]), last(np.argmax, nodes["max"][pair])


def last(which, points):
    """The smallest or largest coordinate along each axis, of equal ones the last: 0.0 and -0.0 are equal."""
    points = points[::-1]  # numpy tells the first
    return points[which(points, axis=0), [0, 1, 2]]


def weights(points):
    """What the motion of the eight vertices before each vertex says of its own, f64[vertices, 8], in the steps of [8.1.3].

    Every step is taken for all vertices at once. A vertex that is not there has a factor of 0, which changes no sum.
    """
    points, n = points.astype(np.float64), len(points)
    there = [np.arange(n) >= k for k in range(1, BEFORE + 1)]
    d = [np.zeros((n, 3)) for _ in there]
    for k in range(1, min(BEFORE, n - 1) + 1):
        d[k - 1][k:] = points[:-k] - points[k:]
    q = [x * x + y * y + z * z for x, y, z in (of.T for of in d)]
    largest = np.max(q, axis=0)
    flat = largest == 0
    a = [np.where(flat, 1.0, 1.0 / np.where(flat, 1.0, of + 2.0**-40 * largest)) * here for of, here in zip(q, there)]
    total = added(a)
    total[:1] = 1.0  # the first vertex has none before it
    c = added([f[:, None] * of for f, of in zip(a, d)]) / total[:, None]
    e = [(of - c).T for of in d]
    xx, xy, xz, yy, yz, zz = (added([f * of[i] * of[j] for f, of in zip(a, e)]) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))
    t = (xx + yy + zz) * 2.0**-10 + 2.0**-24
    xx, yy, zz = xx + t, yy + t, zz + t
    cx, cy, cz = c.T
    l1, l2 = xy / xx, xz / xx
    d1, u = yy - l1 * xy, yz - l1 * xz
    l3 = u / d1
    d2 = zz - l2 * xz - l3 * u
    y1 = cy - l1 * cx
    y2 = cz - l2 * cx - l3 * y1
    gz = y2 / d2
    gy = y1 / d1 - l3 * gz
    gx = cx / xx - l1 * gy - l2 * gz
    return np.stack([f * (1.0 / total - (x * gx + y * gy + z * gz)) for f, (x, y, z) in zip(a, e)], axis=1)


def added(terms):
    """Their sum from left to right."""
    total = terms[0].copy()
    for term in terms[1:]:
        total += term
    return total


def axis(differences, base, scale, weights):
    """The coordinates of a pose along one axis, vertex after vertex; without `weights` those of the first pose."""
    out, motion = [], []
    for v, (difference, before) in enumerate(zip(differences, base)):
        p = 0.0
        if weights is None:
            p = motion[-1] if motion else 0.0
        else:
            for k, w in enumerate(weights[v], 1):
                p += w * motion[v - k]
        if scale == 0:
            start = before
            x = numbered(signed(number(start + p) + difference))
            motion.append(x - start)
        else:
            start = float(math.floor(before * scale + 0.5))
            expected = min(max(math.floor(start + p + 0.5), -2**31), 2**31 - 1)
            i = signed(expected + difference)
            x = rounded(i / scale)
            motion.append(i - start)
        out.append(x)
        require(math.isfinite(x), "a coordinate is not finite")  # E0417
    return out


def signed(i):
    return (i + 2**31) % 2**32 - 2**31


def rounded(x):
    """The nearest binary32, as a float."""
    with np.errstate(over="ignore"):
        return float(np.float32(x))


def number(x):
    """The place of the nearest binary32 in the order of them all."""
    with np.errstate(over="ignore"):
        bits = int(np.float32(x).view(np.int32))
    return bits if bits >= 0 else bits ^ 0x7FFFFFFF


def numbered(i):
    return float(np.int32(i if i >= 0 else i ^ 0x7FFFFFFF).view(np.float32))
