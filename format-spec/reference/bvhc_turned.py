"""Turned subtrees, SPEC.md 5.8: whether each is what lies below a node of the tree, in boxes that hold what is there. Used by bvhc_reader.py."""

import numpy as np

from bvhc_records import NEST, plain


def check(rows, turned, nodes, tris, require):
    """Hold turned subtrees against the tree, whose rules were checked. Of triangles that are cut, the boxes' upper bound alone is asked."""
    inner = lambda i: nodes["count"][i] == 0
    ends = {}  # by first child, behind the last record below its parent
    for i in reversed([i for i in range(len(nodes)) if i != 1 and inner(i)]):
        first = int(nodes["first"][i])
        ends[first] = max([first + 2] + [ends[int(nodes["first"][c])] for c in (first, first + 1) if inner(c)])
    around, at, last = [], 0, 0
    for row in map(plain, rows):
        while around and around[-1]["end"] <= row["first"]:
            around.pop()
        require(row["first"] > last and ends.get(row["first"]) == row["end"], "a row of OROW is not what lies below a node")
        offset = around[-1]["node_offset"] + row["first"] - around[-1]["first"] if around else at
        require(row["node_offset"] == offset and not any(row["reserved"]) and len(around) < NEST, "node_offset, reserved or nesting of OROW")
        at, last = at if around else at + row["end"] - row["first"], row["first"]
        around.append(row)
    require(at == len(turned), "OROW rows do not end with ONOD")
    for i, row in enumerate(map(plain, rows)):
        axes = np.asarray(row["axes"], float).reshape(3, 3)
        require(np.isfinite(axes).all() and (abs(axes @ axes.T - np.eye(3)) <= 2.0**-20).all(), "axes of OROW")
        within = [r for r in map(plain, rows[i + 1:]) if r["end"] <= row["end"]]
        own = lambda k: not any(r["first"] <= k < r["end"] for r in within)
        check_boxes(row, axes, own, turned[row["node_offset"]:], nodes, tris, require)


def check_boxes(row, axes, own, turned, nodes, tris, require):
    """The boxes of one subtree but of those within it, from the last to the first."""
    whole, least = {}, {}  # what leaves hold with whole triangles, and of triangles that lie in them
    for i in range(row["end"] - 1, row["first"] - 1, -1):
        node, mine = plain(nodes[i]), plain(turned[i - row["first"]])
        if node["count"]:
            held = [extent(axes, t) for t in tris[node["first"]:node["first"] + node["count"]]]
            uncut = [e for e, t in zip(held, tris[node["first"]:node["first"] + node["count"]]) if inside(t, node)]
        else:
            children = (node["first"], node["first"] + 1)
            held, uncut = [whole[c] for c in children], [least[c] for c in children if least[c] is not None]
        whole[i] = union(held)
        least[i] = union(uncut) if uncut else None
        require((mine["first"], mine["count"]) == (node["first"], node["count"]), "links of ONOD")
        if not own(i):
            continue
        low, high = (np.asarray(mine[k], float) for k in ("min", "max"))
        require((low <= high).all(), "a box of ONOD is none")
        if least[i] is not None:
            require((low <= least[i][0]).all() and (high >= least[i][1]).all(), "a box of ONOD does not hold what is below it")
        require((low >= outward(whole[i][0], -1)).all() and (high <= outward(whole[i][1], 1)).all(), "a box of ONOD is too large")


def extent(axes, triangle):
    corners = np.asarray([triangle[v] for v in ("v0", "v1", "v2")], float)
    most = abs(corners).max(axis=0)
    weigh = lambda a, p: (a[:, 0] * p[0] + a[:, 1] * p[1]) + a[:, 2] * p[2]
    along, slack = np.asarray([weigh(axes, p) for p in corners]), 2.0**-45 * weigh(abs(axes), most)
    return along.min(axis=0) - slack, along.max(axis=0) + slack


def inside(triangle, node):
    corners = np.asarray([triangle[v] for v in ("v0", "v1", "v2")])
    return (corners >= node["min"]).all() and (corners <= node["max"]).all()


def union(some):
    return np.minimum.reduce([low for low, _ in some]), np.maximum.reduce([high for _, high in some])


def outward(values, direction):
    """The nearest f32 that is not inside."""
    near = values.astype("<f4")
    short = near.astype(float) > values if direction < 0 else near.astype(float) < values
    return np.where(short, np.nextafter(near, np.float32(direction * np.inf)), near).astype(float)
