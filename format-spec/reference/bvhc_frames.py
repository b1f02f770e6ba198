"""Sequences, SPEC.md 5.6. Used by bvhc_file.py."""

import struct

import numpy as np

from bvhc_records import HELD, KEY, RECORDS, TIMED, plain, require
from bvhc_trees import Trees


class Frames:
    """What is special about a sequence [5.6]: rows of topologies, poses and frames, and the trees that a frame is put together of."""

    def check_sequence(self):
        """Each pose and each placement [5.6]; the depths of all trees."""
        self.trix = self.rows("TRIX")
        self.blocks = [tuple(self.rows(n, k) for n in ("NODE", "VPOS")) for k in range(len(self.stated("NODE")))]
        self.placements = [tuple(self.rows(n, k) for n in ("TNOD", "INST")) for k in range(len(self.stated("TNOD")))]
        tops = [top for top, _ in self.placements]
        self.check_header_counts(self.topo, self.topo["node_count"][self.pose["topology"]], tops)
        require((self.trix["geom"] < len(self.geom)).all(), "geom of TRIX")
        for t in range(len(self.topo)):
            corners = self.slots(t)["corners"]
            require((corners < self.topo["vertex_count"][t]).all(), "topology %d: a corner is no vertex" % t)
            require(len(np.unique(corners)) == self.topo["vertex_count"][t], "topology %d: a vertex is no corner" % t)
        depths = []
        for i, pose in enumerate(self.pose):
            posed = self.posed([i])
            depths += posed.check_trees()
            first = self.posed([int(np.flatnonzero(self.pose["topology"] == pose["topology"])[0])]).node
            require(all((posed.node[f] == first[f]).all() for f in ("first", "count")), "pose %d has another shape than its topology" % i)
        rows = self.posed(range(len(self.pose))).blas
        for tnod, inst in self.placements:
            depths.append(Trees(None, None, self.geom, rows, tnod, inst).check_top())
        self.check_bounds(tops)
        return depths

    def check_sequence_rows(self):
        """The rows of a sequence, held against each other and against what the table says of the other sections [11]."""
        self.topo, self.pose, self.fram, self.geom = (self.rows(n) for n in ("TOPO", "POSE", "FRAM", "GEOM"))
        self.check_topologies()
        self.check_poses()
        self.check_frames()

    def stated(self, name):
        """The numbers of records that the table states for the sections of a type, in the order of their own numbers."""
        found = [e for e in self.table if e["type"] == name.encode() and self.understood(e)]
        return [e["elem_count"] for e in sorted(found, key=lambda e: e["ordinal"])]

    def check_topologies(self):
        at, records = 0, self.stated("TRIX")[0]
        for t, row in enumerate(map(plain, self.topo)):
            most, parts = 255 * (row["node_count"] // 2), int((self.geom["blas"] == t).sum())
            require(row["ref_offset"] == at and at + row["ref_count"] <= records, "TOPO rows do not tile TRIX")
            at += row["ref_count"]
            require(row["node_count"] % 2 == 0 and 1 <= row["ref_count"] <= most and 1 <= parts <= most, "the size of topology %d" % t)
            require(row["reserved"] == bytes(32), "reserved bytes of TOPO")
            require((self.pose["topology"] == t).any(), "topology %d has no pose" % t)
        require(at == records, "TOPO rows do not end with TRIX")
        require((np.diff(self.geom["blas"].astype(np.int64)) >= 0).all() and (self.geom["blas"] < len(self.topo)).all(), "blas of GEOM")

    def check_poses(self):
        block, at = 0, (0, 0)
        ends = list(zip(self.stated("NODE"), self.stated("VPOS")))
        for pose in map(plain, self.pose):
            require(pose["topology"] < len(self.topo) and pose["flags"] & ~KEY == 0 and pose["reserved"] == bytes(8), "a row of POSE")
            if pose["block"] == block + 1 and at == ends[block] != (0, 0):
                block, at = block + 1, (0, 0)
            starts, topology = (pose["node_offset"], pose["vertex_offset"]), plain(self.topo[pose["topology"]])
            require(pose["block"] == block < len(ends) and starts == at, "POSE rows do not tile the blocks")
            at = (at[0] + topology["node_count"], at[1] + topology["vertex_count"])
            require(at[0] <= ends[block][0] and at[1] <= ends[block][1], "a pose reaches beyond its block")
        require(block == len(ends) - 1 and at == ends[block], "POSE rows do not end with the blocks")

    def check_frames(self):
        require(len(self.fram) > 0, "a sequence without frames")
        before, placements = None, len(self.stated("TNOD"))
        for f in map(plain, self.fram):
            require(f["flags"] & ~(TIMED | HELD) == 0 and f["reserved"] == bytes(16), "flags or reserved bytes of FRAM")
            require(before is None or f["number"] > before["number"], "the numbers of FRAM do not ascend")
            require(f["placement"] < placements, "placement of FRAM")
            require(not f["flags"] & HELD or (before and before["placement"] == f["placement"]), "a frame that holds another than the one before")
            time = struct.pack("<f", f["time"])
            require(np.isfinite(f["time"]) and (f["flags"] & TIMED or time == bytes(4)), "time of FRAM")
            before = f

    def slots(self, t):
        """A topology's records of TRIX."""
        return self.trix[int(self.topo["ref_offset"][t]):][:int(self.topo["ref_count"][t])]

    def posed(self, poses):
        """Some poses as the trees of a still file [5.6.5, 5.6.6], of one level."""
        node, tris, geom, blas, node_at, ref_at, part_at = [], [], [], [], 0, 0, 0
        for number, i in enumerate(poses):
            pose = self.pose[i]
            t = int(pose["topology"])
            topology, slots, (nodes, points) = self.topo[t], self.slots(t), self.blocks[int(pose["block"])]
            nodes = nodes[int(pose["node_offset"]):][:int(topology["node_count"])]
            points = points[int(pose["vertex_offset"]):][:int(topology["vertex_count"])].view("<f4").reshape(-1, 3)
            parts = np.flatnonzero(self.geom["blas"] == t)
            require(((slots["geom"] >= parts[0]) & (slots["geom"] <= parts[-1])).all(), "a triangle of another topology's part")
            rows = np.zeros(len(slots), RECORDS["TRIS"][1])
            for k, corner in enumerate(("v0", "v1", "v2")):
                rows[corner] = points[slots["corners"][:, k]]
            rows["prim"], rows["flags"], rows["geom"] = slots["prim"], slots["flags"], slots["geom"] - parts[0] + part_at
            mine = self.geom[parts].copy()
            mine["blas"] = number
            row = np.zeros(1, RECORDS["BLAS"][1])
            for field in ("min", "max", "sah"):
                row[field] = pose[field]
            for field in ("node_count", "ref_count", "prim_count", "max_depth", "flags"):
                row[field] = topology[field]
            row["node_offset"], row["ref_offset"] = node_at, ref_at
            node, tris, geom, blas = node + [nodes], tris + [rows], geom + [mine], blas + [row]
            node_at, ref_at, part_at = node_at + len(nodes), ref_at + len(rows), part_at + len(mine)
        joined = (np.concatenate([np.zeros(0, RECORDS[n][1])] + some) for n, some in zip(("NODE", "TRIS", "GEOM", "BLAS"), (node, tris, geom, blas)))
        return Trees(*joined, called="tree")

    def frame(self, index):
        """The trees of a frame, counted from 0 [5.6.6]; `poses` are their rows of POSE, `parts` the rows of GEOM of the file."""
        tnod, inst = self.placements[int(self.fram["placement"][index])]
        poses = np.unique(inst["blas"])
        trees = self.posed(poses)
        trees.poses, trees.two_level, trees.tnod, trees.inst = poses, True, tnod, inst.copy()
        trees.inst["blas"] = np.searchsorted(poses, inst["blas"])
        trees.parts = np.concatenate([np.zeros(0, int)] + [np.flatnonzero(self.geom["blas"] == self.pose["topology"][p]) for p in poses])
        return trees

    def numbered(self, number):
        """The index of the frame that has this number in the source, or None."""
        found = np.flatnonzero(self.fram["number"] == number) if self.sequence else []
        return int(found[0]) if len(found) else None
