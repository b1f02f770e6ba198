"""Trees and their records, SPEC.md 5.1 to 5.5: what rays are traced in. Used by bvhc_file.py."""

import numpy as np

from bvhc_exact import covers, exact_determinant, outward, undoes
from bvhc_records import DUP_REFS, MOST_COVERED, NODE, RECORDS, REFITTABLE, plain, require


class Trees:
    """What rays are traced in: the records of a still file, or those that a pose, a placement or a frame is made of [5.6].

    `node`, `tris`, `geom`, `blas`, `tnod` and `inst` are arrays of records. `called` is what messages call a tree.
    """

    called = "BLAS"

    def __init__(self, node, tris, geom, blas, tnod=None, inst=None, called="BLAS"):
        self.node, self.tris, self.geom, self.blas, self.called = node, tris, geom, blas, called
        self.two_level = tnod is not None
        self.tnod, self.inst = (np.zeros(0, NODE), np.zeros(0, RECORDS["INST"][1])) if tnod is None else (tnod, inst)

    def check_trees(self):
        """Records [5.2-5.4] and trees [5.1]; the deepest leaf's depth of each."""
        self.check_records()
        self.depths = [self.check_tree(*self.tree(b), "%s %d" % (self.called, i)) for i, b in enumerate(self.blas)]
        self.check_blases()
        return self.depths

    def check_top(self):
        """The top level [5.5]; the depth of its deepest leaf."""
        depth = self.check_tree(self.tnod, len(self.inst), "TLAS")
        self.check_instances()
        return depth

    def check_records(self):
        require(all(np.isfinite(self.tris[v]).all() for v in ("v0", "v1", "v2")), "a triangle's corner is not finite")
        require((self.tris["flags"] <= 1).all() and (self.tris["geom"] < len(self.geom)).all(), "flags or geom of TRIS")
        first, prims = (self.geom[f].astype(np.uint64) for f in ("first_prim", "prim_count"))
        require((first + prims < 1 << 32).all() and (self.geom["kept_count"] <= prims).all(), "counts of GEOM")
        require((np.diff(self.geom["blas"].astype(np.int64)) >= 0).all(), "GEOM rows are not in the order of their blas")
        require((self.geom["blas"] < len(self.blas)).all() and not self.geom["reserved"].any(), "blas or reserved of GEOM")
        self.check_numbers()
        row, prim = self.tris["geom"], self.tris["prim"]
        require(((prim >= first[row]) & (prim < first[row] + prims[row])).all(), "prim of TRIS is not in its part")

    def check_numbers(self):
        """Numbers of triangles in the parts of one mesh, in each tree [5.3]."""
        of_parts = {}
        for g in map(plain, self.geom):
            said = (g["first_prim"], g["prim_count"], bytes(g["name_hash"]))
            nodes = of_parts.setdefault((g["blas"], g["source_mesh"], g["source_part"]), (said, []))
            require(nodes[0] == said, "two rows of GEOM give one part different numbers or names")
            nodes[1].append(g["baked_node"])
        before, end = None, 0
        for key in sorted(of_parts):
            (first, count, _), nodes = of_parts[key]
            require(nodes.count(0xFFFFFFFF) <= 1, "two rows of GEOM are of one part without a node")
            require(before != key[:2] or first >= end, "parts of one mesh have numbers in common")
            before, end = key[:2], first + count

    def tree(self, b):
        return self.node[int(b["node_offset"]):][:int(b["node_count"])], int(b["ref_count"])

    @staticmethod
    def check_tree(nodes, refs, name):
        """Rules 1-7 of [5.1] in one walk in preorder; the deepest leaf's depth."""
        if len(nodes) == 0:
            require(refs == 0, "%s: references without a tree" % name)
            return 0
        require(len(nodes) % 2 == 0 and nodes[1:2].tobytes() == bytes(32), "%s: odd, or record 1 is not zero" % name)
        low, high = nodes["min"], nodes["max"]
        live = np.arange(len(nodes)) != 1
        require((np.isfinite(low) & np.isfinite(high) & (low <= high))[live].all(), "%s: a box is not finite or inverted" % name)
        first, count = nodes["first"].tolist(), nodes["count"].tolist()
        inner = np.flatnonzero(live & (nodes["count"] == 0))
        next_pair, next_ref, deepest, stack = 2, 0, 0, [(0, 0)]
        while stack:
            i, depth = stack.pop()
            require(depth <= 64, "%s: deeper than 64" % name)
            deepest = max(deepest, depth)
            if count[i]:
                require(first[i] == next_ref and count[i] <= 255, "%s: leaf %d breaks the tiling" % (name, i))
                next_ref += count[i]
            else:
                # In preorder each pair is the next unseen one: that makes it a tree, and each index in range.
                require(first[i] == next_pair < len(nodes), "%s: children of node %d are not the next pair" % (name, i))
                next_pair += 2
                stack += [(first[i] + 1, depth + 1), (first[i], depth + 1)]
        require(next_pair == len(nodes) and next_ref == refs, "%s: nodes or references without a parent" % name)
        for child in (nodes["first"][inner], nodes["first"][inner] + 1):
            inside = (low[child] >= low[inner]) & (high[child] <= high[inner])
            require(inside.all(), "%s: a child's box leaves its parent's" % name)
        return deepest

    def check_blases(self):
        for i, (b, depth) in enumerate(zip(self.blas, self.depths)):
            nodes, name = self.tree(b)[0], "%s %d" % (self.called, i)
            root = (nodes["min"][0], nodes["max"][0]) if len(nodes) else (np.zeros(3), np.zeros(3))
            require((b["min"] == root[0]).all() and (b["max"] == root[1]).all(), "%s: box is not the root's" % name)
            require(b["max_depth"] == depth and np.isfinite(b["sah"]) and b["sah"] >= 0, "%s: max_depth or sah" % name)
            require(b["flags"] in (REFITTABLE, DUP_REFS), "%s: flags" % name)
            kept = int(self.geom["kept_count"][self.geom["blas"] == i].sum(dtype=np.uint64))
            tris = self.tris[int(b["ref_offset"]):][:int(b["ref_count"])]
            require((self.geom["blas"][tris["geom"]] == i).all(), "%s: a triangle of another BLAS's part" % name)
            keys = tris["geom"].astype(np.uint64) << np.uint64(32) | tris["prim"]
            _, index, times = np.unique(keys, return_inverse=True, return_counts=True)
            require(len(times) == b["prim_count"] == kept, "%s: prim_count" % name)
            require(((times[index] > 1) == (tris["flags"] == 1)).all(), "%s: DUPLICATED is not set on the duplicates" % name)
            require((len(times) == len(tris)) or b["flags"] == DUP_REFS, "%s: duplicates without DUP_REFS" % name)
            # A triangle lies in its leaf's box; one that was cut touches the box of each of its leaves, and they cover it.
            if len(tris) == 0:
                continue
            leaf, corners = leaf_of_each_ref(nodes), np.stack([tris[v] for v in ("v0", "v1", "v2")], axis=1)
            inside = ((corners >= leaf["min"][:, None]) & (corners <= leaf["max"][:, None])).all(axis=(1, 2))
            touches = ((corners.min(axis=1) <= leaf["max"]) & (corners.max(axis=1) >= leaf["min"])).all(axis=1)
            require((inside | (tris["flags"] == 1) & touches).all(), "%s: a triangle leaves its leaf's box" % name)
            # Copies are equal, and each stands in a leaf of its own.
            order = np.argsort(keys, kind="stable")
            copy = keys[order][1:] == keys[order][:-1]
            require((leaf["first"][order][1:] != leaf["first"][order][:-1])[copy].all(), "%s: a triangle twice in a leaf" % name)
            shape = corners.view(np.uint32).reshape(-1, 9)[order]
            require((shape[1:] == shape[:-1])[copy].all(), "%s: copies of a triangle differ" % name)
            self.check_tight(nodes, corners.min(axis=1), corners.max(axis=1), name, whole=b["flags"] == REFITTABLE)
            groups = np.split(order, np.flatnonzero(~copy) + 1)
            groups = [g for g in groups if len(g) > 1]
            for g in groups[::len(groups) // MOST_COVERED + 1]:
                require(covers([(leaf["min"][i], leaf["max"][i]) for i in g], corners[g[0]]), "%s: leaves leave a hole" % name)
            x, y, z = (nodes["max"].astype(np.float64) - nodes["min"]).T
            area = x * y + y * z + z * x
            cost = np.where(nodes["count"] > 0, nodes["count"], 1.2) * area * (np.arange(len(nodes)) != 1)
            sah = np.float32(np.cumsum(cost)[-1] / area[0] if area[0] > 0 else 0.0)  # cumsum adds in record order
            require(b["sah"] == sah, "%s: sah is not that of its nodes" % name)

    @staticmethod
    def check_tight(nodes, low, high, name, whole):
        """No box is larger than what it holds: rule 9 of [5.1]. `low` and `high`: the boxes of the references; `whole`: leaves hold all of them."""
        live = np.arange(len(nodes)) != 1
        inner = np.flatnonzero(live & (nodes["count"] == 0))
        pairs = nodes["first"][inner][:, None] + [0, 1]
        tight = (nodes["min"][pairs].min(axis=1) == nodes["min"][inner]).all()
        tight &= (nodes["max"][pairs].max(axis=1) == nodes["max"][inner]).all()
        for n in nodes[live & (nodes["count"] > 0)]:
            of = slice(int(n["first"]), int(n["first"]) + int(n["count"]))
            least, most = low[of].min(axis=0), high[of].max(axis=0)
            tight &= (least <= n["min"]).all() and (n["max"] <= most).all()
            tight &= not whole or (least == n["min"]).all() and (n["max"] == most).all()
        require(tight, "%s: a box is larger than what it holds" % name)

    def check_instances(self):
        ids = self.inst["id"]
        require((np.sort(ids) == np.arange(len(ids))).all(), "ids of INST are not 0, 1, ...")
        require((self.inst["blas"] < len(self.blas)).all(), "blas of INST")
        require((self.inst["flags"] <= 1).all() and all(r.item() == bytes(12) for r in self.inst["reserved"]), "flags of INST")
        for m in self.inst:
            a, b = (np.vstack([m[f].reshape(3, 4).astype(np.float64), [0, 0, 0, 1]]) for f in ("object_to_world", "world_to_object"))
            require(np.isfinite(a).all() and np.isfinite(b).all(), "a matrix of INST is not finite")
            allowed = (np.abs(a) @ np.abs(b) + np.eye(4)) * 2.0**-22 + np.abs(a[:, :3]).sum(axis=1)[:, None] * 2.0**-149
            require((np.abs(a @ b - np.eye(4)) <= allowed).all(), "world_to_object is not the inverse of object_to_world")
            require(undoes(a, b), "world_to_object is not near the inverse of object_to_world")
            require(bool(m["flags"] & 1) == (exact_determinant(a) < 0), "MIRRORED of INST")
        low, high = np.zeros((len(self.inst), 3), np.float32), np.zeros((len(self.inst), 3), np.float32)
        for i, (m, box) in enumerate(zip(self.inst, leaf_of_each_ref(self.tnod))):
            b, a = self.blas[int(m["blas"])], m["object_to_world"].reshape(3, 4).astype(np.float64)
            ends = np.stack([a[:, :3] * b["min"].astype(np.float64), a[:, :3] * b["max"].astype(np.float64)])
            least, most = (np.cumsum(np.column_stack([a[:, 3], e]), axis=1)[:, 3] for e in (ends.min(axis=0), ends.max(axis=0)))
            slack = (np.abs(ends).max(axis=0).sum(axis=1) + np.abs(a[:, 3])) * 2.0**-50
            low[i], high[i] = outward(least - slack, -np.inf), outward(most + slack, np.inf)
            inside = (box["min"] <= low[i]).all() and (box["max"] >= high[i]).all()
            require(inside or not b["node_count"], "an instance leaves its leaf's box")
        if len(self.inst):
            self.check_tight(self.tnod, low, high, "TLAS", whole=False)

    def check_nodes(self):
        """Parts name the node of their instance, where both name one [5.5]."""
        nodes = {}
        for g in self.geom[self.geom["baked_node"] != 0xFFFFFFFF]:
            nodes.setdefault(int(g["blas"]), set()).add(int(g["baked_node"]))
        for m in self.inst[self.inst["node"] != 0xFFFFFFFF]:
            require(nodes.get(int(m["blas"]), {int(m["node"])}) == {int(m["node"])}, "node of INST is not that of the parts of its tree")

    def check_vertices(self, vertices):
        """VERT [10.3.1], a record for each of `tris`."""
        corners = (np.stack([self.tris[v] for v in ("v0", "v1", "v2")], axis=1) + np.float32(0)).view("<u4").reshape(-1, 3)
        # A vertex of a part stands in one place: equal pairs of part and vertex lie next to each other, with equal positions.
        keys = np.repeat(self.tris["geom"].astype(np.uint64), 3) << np.uint64(32) | vertices.reshape(-1)
        order = np.argsort(keys, kind="stable")
        same = keys[order][1:] == keys[order][:-1]
        require((corners[order][1:] == corners[order][:-1])[same].all(), "a vertex of a part stands in two places")
        keys = self.tris["geom"].astype(np.uint64) << np.uint64(32) | self.tris["prim"]
        order = np.argsort(keys, kind="stable")
        same = keys[order][1:] == keys[order][:-1]
        require((vertices[order][1:] == vertices[order][:-1])[same].all(), "copies of a triangle have different vertices")


def leaf_of_each_ref(nodes):
    """For each reference of a checked tree the node of the leaf that it stands in."""
    leaves = nodes[nodes["count"] > 0]  # record 1 is zero, so it is not among them
    leaves = leaves[np.argsort(leaves["first"])]
    return np.repeat(leaves, leaves["count"])
