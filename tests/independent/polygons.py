"""Is a polygon that was cut into triangles still that polygon? Which diagonals a reader takes is its own affair.

Each triangle's corners must be corners of the polygon. Where all n - 2 triangles are there, their edges must cancel out but for the
polygon's own: then they are a cut of it. Where some are left out as flat, their area vectors must add up to the polygon's. And where a cut
without overlap exists, no triangle may lie the wrong way round.
"""

import numpy as np

from arithmetic import F64_SLACK, half_ulp, rounded

# Above this many corners the test for crossing edges, which is quadratic, is left out.
MOST_TO_PROVE_SIMPLE = 400


def compare(comparison, placement, part, shown, rows, where):
    """Judge all polygons of one part. `rows` are the numbers of its triangles in the cache."""
    stored = shown.body.corners.astype(np.float64)
    place = np.full(len(part), -1)
    place[rows] = np.arange(len(rows))
    sizes = np.array([len(p.corners) for p in part.polygons])
    for size in np.unique(sizes):
        of_size = [part.polygons[i] for i in np.flatnonzero(sizes == size)]
        # A batch holds a table of corners by corners for each polygon.
        step = max(1, 4_000_000 // int(size * size))
        for i in range(0, len(of_size), step):
            judge(comparison, part, of_size[i:i + step], int(size), placement, shown, stored, place, where)


@np.errstate(invalid="ignore", over="ignore")
def judge(comparison, part, batch, size, placement, shown, stored, place, where):
    corners = np.array([p.corners for p in batch])
    first = np.array([p.first for p in batch])
    exact = part.positions[corners]
    at = place[first[:, None] + np.arange(size - 2)]
    there = at >= 0
    got = stored[np.maximum(at, 0)]
    slack = np.abs(exact) * F64_SLACK
    if shown.matrix is not None:
        # An OBJ model stands where it is: an instance of it can only give back an origin that was taken away.
        exact = exact - shown.matrix[:, 3]
    bound = half_ulp(exact) + slack

    standing = stored_corners(exact, bound, got, there)
    number, found = match(standing, got)
    lost = there & ~found.all(axis=2)
    if lost.any():
        i = int(np.argmax(lost.any(axis=1)))
        comparison.differ("polygon's corner", where, lost.sum(), "a triangle of the polygon at triangle %d has a corner that the polygon has not" % first[i])
    whole = there.all(axis=1) & found.all(axis=(1, 2))
    edges_wrong = whole & ~boundary_is_right(number, size, corner_names(standing))
    areas = np.where(there[:, :, None], np.cross(got[:, :, 1] - got[:, :, 0], got[:, :, 2] - got[:, :, 0]), 0.0)
    wanted = newell(exact)
    tolerance = 8 * area_error(exact, bound)
    sum_wrong = ~lost.any(axis=1) & ~there.all(axis=1) & (np.abs(areas.sum(axis=1) - wanted) > tolerance[:, None]).any(axis=1)
    for wrong, kind in ((edges_wrong, "polygon's edges"), (sum_wrong, "polygon's area")):
        if wrong.any():
            comparison.differ(kind, where, wrong.sum(), "the polygon at triangle %d" % first[np.argmax(wrong)])
    against = (np.einsum("pti,pi->pt", areas, wanted) < -(tolerance * np.linalg.norm(wanted, axis=1))[:, None]) & there
    for i in np.flatnonzero(against.any(axis=1)):
        if size <= MOST_TO_PROVE_SIMPLE and is_flat_and_simple(exact[i], wanted[i], bound[i].max()):
            comparison.differ("polygon folded over", where, 1, "the polygon at triangle %d, its triangle %d" % (first[i], np.argmax(against[i])))


def stored_corners(exact, bound, got, there):
    """f64[p, n, 3]: where the cache has each corner. That is the nearest of its numbers, or, where two are as near, the one that it took.

    Corners that are less than a rounding apart may become one, or may not: only the stored numbers tell.
    """
    standing = rounded(exact).astype(np.float64)
    _, known = match(standing, got)
    for p, t, v in zip(*np.nonzero(there[:, :, None] & ~known)):
        near = (np.abs(got[p, t, v] - exact[p]) <= bound[p]).all(axis=1)
        standing[p, near] = got[p, t, v]
    return standing


def match(standing, got):
    """For each corner of each triangle the first corner of its polygon that it is: (int[p, t, 3], bool[p, t, 3])."""
    number = np.zeros(got.shape[:3], dtype=np.int64)
    found = np.zeros(got.shape[:3], dtype=bool)
    for j in reversed(range(standing.shape[1])):
        same = (got == standing[:, None, None, j]).all(axis=3)
        number[same] = j
        found |= same
    return number, found


def corner_names(standing):
    """int[p, n]: corners of a polygon that stand at one place get the number of the first of them."""
    names = np.zeros(standing.shape[:2], dtype=np.int64)
    for j in reversed(range(standing.shape[1])):
        names[(standing == standing[:, None, j]).all(axis=2)] = j
    return names


def boundary_is_right(number, size, names):
    """Do the directed edges of the triangles cancel out but for those of the polygon?"""
    count = len(number)
    net = np.zeros((count, size, size), dtype=np.int32)
    rows = np.arange(count)
    for t in range(number.shape[1]):
        for a, b in ((0, 1), (1, 2), (2, 0)):
            np.add.at(net, (rows, number[:, t, a], number[:, t, b]), 1)
    for j in range(size):
        np.add.at(net, (rows, names[:, j], names[:, (j + 1) % size]), -1)
    return (net == net.transpose(0, 2, 1)).all(axis=(1, 2))


def newell(points):
    """Twice the area vector of closed polygons f64[p, n, 3]."""
    moved = points - points[:, :1]
    return np.cross(moved, np.roll(moved, -1, axis=1)).sum(axis=1)


def area_error(exact, bound):
    """What the rounding of corners can change in an area vector."""
    moved = np.abs(exact - exact[:, :1]).max(axis=(1, 2))
    return exact.shape[1] * (bound.max(axis=(1, 2)) * moved * 4 + moved * moved * 2.0**-50)


def is_flat_and_simple(points, normal, bound):
    """Does the polygon lie in a plane, and do its edges meet at its corners alone?"""
    length = np.linalg.norm(normal)
    if length == 0:
        return False
    n = normal / length
    moved = points - points[0]
    extent = np.abs(moved).max()
    if (np.abs(moved @ n) > 1e-5 * extent + 4 * bound).any():
        return False
    keep = [i for i in range(3) if i != int(np.argmax(np.abs(n)))]
    flat = moved[:, keep]
    a, b = flat, np.roll(flat, -1, axis=0)

    def side(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    edge = b - a
    slack = 1e-9 * extent * extent + 8 * bound * extent
    if (np.abs(edge).max(axis=1) <= 8 * bound).any():
        return False  # corners that fall together: too close to call
    p, q, r, s = a[:, None], b[:, None], a[None], b[None]
    apart = (side(p, q, r) > slack) & (side(p, q, s) > slack) | (side(p, q, r) < -slack) & (side(p, q, s) < -slack)
    apart |= (side(r, s, p) > slack) & (side(r, s, q) > slack) | (side(r, s, p) < -slack) & (side(r, s, q) < -slack)
    i = np.arange(len(points))
    gap = (i[:, None] - i[None]) % len(points)
    # Neighbouring edges share a corner; they must not fold back onto each other.
    neighbour = (gap <= 1) | (gap == len(points) - 1)
    turn = side(a, b, np.roll(b, -1, axis=0))
    return bool((apart | neighbour).all()) and bool((np.abs(turn) > slack).all())
