"""What f32 can hold of a number, and whether a triangle has an area: decided exactly where f64 does not suffice."""

from fractions import Fraction

import numpy as np

# What sums and products of f64 in the second reader may be off, relative to the sum of their terms' magnitudes. A chain of some
# dozen matrices stays far below; half a unit in the last place of f32 is a million times as much.
F64_SLACK = 2.0**-44


def half_ulp(values):
    """Half of the distance between the f32 numbers around each f64 number: the most that one rounding moves it."""
    _, exponent = np.frexp(values)
    # frexp gives [0.5, 1) times a power of two, and 0 for zero; below 2**-126 the distance stays that of the smallest numbers.
    exponent = np.where(values == 0, -149, np.maximum(exponent - 24, -149))
    return np.ldexp(0.5, exponent)


def rounded(values):
    """f32 numbers nearest to f64 ones; what is beyond them becomes infinite."""
    with np.errstate(over="ignore", invalid="ignore"):
        return values.astype(np.float32)


def without_area(corners):
    """bool[n] for f32 or f64 corners [n, 3, 3], all finite: is the area of the triangle exactly zero?"""
    corners = np.asarray(corners, dtype=np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        left = np.stack([a[:, 1] * b[:, 2], a[:, 2] * b[:, 0], a[:, 0] * b[:, 1]], axis=1)
        right = np.stack([a[:, 2] * b[:, 1], a[:, 0] * b[:, 2], a[:, 1] * b[:, 0]], axis=1)
        # A difference, a product and their difference are off by 2**-53 of themselves each. One entry of the cross product that is
        # surely not zero is enough; products too small for f64 prove nothing.
        size = np.abs(left) + np.abs(right)
        certain = ((np.abs(left - right) > 2.0**-48 * size) & (size > 1e-290) & np.isfinite(size)).any(axis=1)
    out = np.zeros(len(corners), dtype=bool)
    for i in np.flatnonzero(~certain):
        out[i] = exactly_without_area(corners[i])
    return out


def exactly_without_area(corners):
    p = [[Fraction(float(x)) for x in corner] for corner in corners]
    a, b = [y - x for x, y in zip(p[0], p[1])], [y - x for x, y in zip(p[0], p[2])]
    return all(a[i] * b[j] == a[j] * b[i] for i, j in ((0, 1), (1, 2), (2, 0)))
