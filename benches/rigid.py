#!/usr/bin/env python3
"""Do parts of OBJ frames move as rigid bodies, to the last bit?

    benches/rigid.py FRAME.obj…      the frames of one sequence in their order; needs nothing but Python

Each part (a run of faces of one object and group) of each frame is compared with the first frame. It stands *still* if all its vertices have the same f32 bits. It is
*moved* or *turned* if a translation, or the rigid motion that fits best (least squares, by Horn's quaternions), as a matrix of f32 gives the very bits of all its
vertices, evaluated in f64 and rounded once. Otherwise it is *other*; then the share of vertices that the best fit hits to the bit, and its worst distance as a
share of the part's size, say how far from rigid it is.
"""

import struct
import sys
from pathlib import Path


def f32(x):
    return struct.unpack("f", struct.pack("f", x))[0]


def read(path):
    """Positions as f32, and for each part the vertices that it uses, in the order of first use."""
    positions, parts, current, names = [], [], None, ["", ""]
    for line in path.read_text(errors="replace").splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            positions.append(tuple(f32(float(w)) for w in words[1:4]))
        elif words[0] in ("o", "g"):
            names[words[0] == "g"] = " ".join(words[1:])
            current = None
        elif words[0] == "f":
            if current is None:
                current = {}
                parts.append((" ".join(filter(None, names)), current))
            for word in words[1:]:
                index = int(word.split("/")[0])
                current.setdefault(index - 1 if index > 0 else len(positions) + index)
    return positions, [(name, list(used)) for name, used in parts]


def centroid(points):
    return [sum(p[k] for p in points) / len(points) for k in range(3)]


def largest_eigenvector(m):
    """Of a symmetric 4 by 4 matrix, by Jacobi's rotations."""
    m = [row[:] for row in m]
    v = [[float(i == j) for j in range(4)] for i in range(4)]
    for _ in range(60):
        p, q = max(((i, j) for i in range(4) for j in range(i + 1, 4)), key=lambda ij: abs(m[ij[0]][ij[1]]))
        if abs(m[p][q]) <= 1e-300:
            break
        theta = (m[q][q] - m[p][p]) / (2 * m[p][q])
        t = (1 if theta >= 0 else -1) / (abs(theta) + (theta * theta + 1) ** 0.5)
        c = 1 / (t * t + 1) ** 0.5
        s = t * c
        for k in range(4):
            a, b = m[k][p], m[k][q]
            m[k][p], m[k][q] = c * a - s * b, s * a + c * b
        for k in range(4):
            a, b = m[p][k], m[q][k]
            m[p][k], m[q][k] = c * a - s * b, s * a + c * b
        for k in range(4):
            a, b = v[k][p], v[k][q]
            v[k][p], v[k][q] = c * a - s * b, s * a + c * b
    best = max(range(4), key=lambda i: m[i][i])
    return [v[k][best] for k in range(4)]


def rigid_fit(before, after):
    """The rows of the rigid motion that brings some points nearest to others (Horn, 1987)."""
    a, b = centroid(before), centroid(after)
    s = [[sum((p[i] - a[i]) * (q[j] - b[j]) for p, q in zip(before, after)) for j in range(3)] for i in range(3)]
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = s
    w, x, y, z = largest_eigenvector([
        [xx + yy + zz, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy],
    ])
    turn = [
        [w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return [row + [b[k] - sum(row[i] * a[i] for i in range(3))] for k, row in enumerate(turn)]


def place(rows, p):
    return tuple(f32(row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]) for row in rows)


def compare(before, after):
    """What became of a part, the share of vertices that the best fit hits, and its worst distance over the part's size."""
    if before == after:
        return "still", 1.0, 0.0
    one = [float(i == k) for k in range(3) for i in range(3)]
    shift = [f32(after[0][k] - before[0][k]) for k in range(3)]
    moved = [one[3 * k : 3 * k + 3] + [shift[k]] for k in range(3)]
    if all(place(moved, p) == q for p, q in zip(before, after)):
        return "moved", 1.0, 0.0
    rows = [[f32(x) for x in row] for row in rigid_fit(before, after)]
    placed = [place(rows, p) for p in before]
    hit = sum(p == q for p, q in zip(placed, after)) / len(after)
    size = max(max(p[k] for p in before) - min(p[k] for p in before) for k in range(3)) or 1.0
    worst = max(max(abs(p[k] - q[k]) for k in range(3)) for p, q in zip(placed, after)) / size
    return ("turned" if hit == 1.0 else "other"), hit, worst


def main(paths):
    first, parts = read(paths[0])
    totals = dict.fromkeys(("still", "moved", "turned", "other"), 0)
    rows = {}
    for path in paths[1:]:
        positions, _ = read(path)
        for number, (name, used) in enumerate(parts):
            if len(positions) != len(first):
                what, hit, worst = "other", 0.0, float("inf")
            else:
                what, hit, worst = compare([first[v] for v in used], [positions[v] for v in used])
            totals[what] += 1
            row = rows.setdefault((number, name, len(used)), [dict.fromkeys(totals, 0), 0.0, float("inf"), 0.0])
            row[0][what] += 1
            if what == "other":
                row[1], row[2], row[3] = max(row[1], hit), min(row[2], worst), max(row[3], worst)
    print("| part | vertices | still | moved | turned | other | most hit | nearest, of the size | farthest |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|--:|")
    for (_, name, count), (what, hit, near, far) in rows.items():
        rest = f"{hit:.1%} | {near:.1e} | {far:.1e}" if what["other"] else "| |"
        print(f"| {name} | {count} | {what['still']} | {what['moved']} | {what['turned']} | {what['other']} | {rest} |")
    print(f"| *together* | | {totals['still']} | {totals['moved']} | {totals['turned']} | {totals['other']} | | | |")


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main([Path(name) for name in sys.argv[1:]])
