"""Proofs in exact arithmetic: that a matrix undoes another, SPEC.md 5.5, and that boxes cover a triangle, 5.1 rule 8. Used by bvhc_trees.py."""

from fractions import Fraction

import numpy as np


def cofactor(m, r, c):
    """Of the first three columns, with the magnitude of its two products."""
    (r0, r1), (c0, c1) = ((r + 1) % 3, (r + 2) % 3), ((c + 1) % 3, (c + 2) % 3)
    p, q = m[r0][c0] * m[r1][c1], m[r0][c1] * m[r1][c0]
    return p - q, abs(p) + abs(q)


def exact_determinant(m):
    m = [[Fraction(float(v)) for v in row] for row in m]
    return sum(m[0][c] * cofactor(m, 0, c)[0] for c in range(3))


def undoes(a, b):
    """Whether b is the inverse of a, within what f64 loses, and f64 can tell the inverse [5.5]."""
    rows = [[float(v) for v in row] for row in a]  # the sums in f64, one after the other
    told, magnitudes = 0.0, 0.0
    for c in range(3):
        value, magnitude = cofactor(rows, 0, c)
        told, magnitudes = told + rows[0][c] * value, magnitudes + abs(rows[0][c] * magnitude)
    if not abs(told) > magnitudes * 2.0**-48:
        return False
    det = exact_determinant(a)
    m = [[Fraction(v) for v in row] for row in rows]
    terms = sum(abs(m[0][c]) * cofactor(m, 0, c)[1] for c in range(3))
    lost = Fraction(1, 2**48)
    for r in range(3):
        moved = slack = Fraction(0)
        for c in range(4):
            if c < 3:
                value, magnitude = cofactor(m, c, r)
                entry = value / det
                s = lost * (magnitude + abs(entry) * terms) / abs(det)
                moved, slack = moved - entry * m[c][3], slack + (s + lost * abs(entry)) * abs(m[c][3])
            else:
                entry, s = moved, slack
            # A little more, for a reader that computes the entry in f64.
            if abs(Fraction(float(b[r][c])) - entry) > (abs(entry) / 2**22 + s + Fraction(1, 2**149)) * Fraction(9, 8):
                return False
    return True


def covers(boxes, corners):
    """Whether the boxes cover the triangle, in exact arithmetic: cut each out, and see whether something is left [5.1, rule 8]."""
    def solid(part):  # an area; where the triangle has none, a length
        p = part[0] if part else None
        edges = [[a - b for a, b in zip(q, p)] for q in part[1:]]
        if flat:
            return any(any(e) for e in edges)
        return any(x[i] * y[j] != x[j] * y[i] for x, y in zip(edges, edges[1:]) for i, j in ((0, 1), (1, 2), (2, 0)))

    def keep(part, axis, plane, sign):  # what lies where sign * (x[axis] - plane) >= 0
        out = []
        for p, q in zip(part, part[1:] + part[:1]):
            d, e = sign * (p[axis] - plane), sign * (q[axis] - plane)
            out += [p] if d >= 0 else []
            if d * e < 0:
                out.append([a + (b - a) * d / (d - e) for a, b in zip(p, q)])
        return out

    whole, flat = [[Fraction(float(v)) for v in p] for p in corners], False
    flat = not solid(whole)
    if flat and not solid(whole):  # a point
        return any((low <= corners[0]).all() and (corners[0] <= high).all() for low, high in boxes)
    parts = [whole]
    for low, high in boxes:
        sides = [(k, Fraction(float(b[k])), sign) for k in range(3) for b, sign in ((low, 1), (high, -1))]
        left = []
        for part in parts:
            for axis, plane, sign in sides:
                if any(sign * (p[axis] - plane) < 0 for p in part):  # and not only in the side itself, which the box has
                    left.append(keep(part, axis, plane, -sign))
                part = keep(part, axis, plane, sign)
        parts = [part for part in left if solid(part)]
    return not parts


def outward(values, side):
    """The nearest numbers of f32 that are not inside."""
    rounded = values.astype(np.float32)
    inside = rounded.astype(np.float64) > values if side < 0 else rounded.astype(np.float64) < values
    return np.where(inside, np.nextafter(rounded, np.float32(side)), rounded)
