"""The triangles of a .bvhc file, told apart by what they came from. The file is read with the format's plain reference reader."""

import os
import sys
from dataclasses import dataclass

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "format-spec", "reference"))
import bvhc_reader  # noqa: E402
from model import NO_NODE  # noqa: E402


class Records(bvhc_reader.File):
    """The records without a walk through the trees. Other tests prove trees, and a walk of millions of nodes takes too long here."""

    def check_tree(self, nodes, refs, name):
        return 0

    def check_blases(self):
        self.depths = [self.header["max_depth"]]

    def check_instances(self):
        pass


@dataclass
class Body:
    """The triangles of one row of GEOM: each once, in the order of their numbers in the source mesh."""

    mesh: int
    part: int
    node: int
    blas: int
    first_prim: int
    prim_count: int
    name: bytes
    prims: np.ndarray  # int64[k]
    corners: np.ndarray  # f32[k, 3, 3]


@dataclass
class Shown:
    """One body at one place. `matrix` f64[3, 4] holds the f32 numbers of the file; None where the positions are the world's."""

    body: Body
    node: int
    matrix: np.ndarray = None


class Cache:
    def __init__(self, path):
        with open(path, "rb") as file:
            self.file = Records(file.read())
        self.bodies = self.read_bodies()
        self.two_level = self.file.two_level
        self.read_counts = dict(self.file.meta.read_counts) if self.file.meta else {}
        self.options = dict(self.file.meta.options) if self.file.meta else {}

    def read_bodies(self):
        tris, bodies = self.file.tris, []
        order = np.lexsort((tris["prim"], tris["geom"]))
        geom, prim = tris["geom"][order], tris["prim"][order]
        first = np.ones(len(order), dtype=bool)
        # Copies of a triangle that was cut are equal byte for byte (the file's rule E0424).
        first[1:] = (geom[1:] != geom[:-1]) | (prim[1:] != prim[:-1])
        order, geom, prim = order[first], geom[first], prim[first]
        corners = np.stack([tris[v][order] for v in ("v0", "v1", "v2")], axis=1)
        ends = np.searchsorted(geom, np.arange(len(self.file.geom) + 1))
        names = self.names()
        for g, row in enumerate(self.file.geom):
            at = slice(ends[g], ends[g + 1])
            bodies.append(Body(*(int(row[f]) for f in ("source_mesh", "source_part", "baked_node", "blas", "first_prim", "prim_count")),
                               names[g], prim[at].astype(np.int64), corners[at]))
        return bodies

    def names(self):
        """One a row of GEOM: section 7 of the format."""
        body, count = self.file.body("NAMS"), len(self.file.geom)
        if body is None:
            return [b""] * count
        ends = np.frombuffer(body, "<u4", count, 8).tolist()
        text = body[8 + 4 * count:]
        return [text[start:end] for start, end in zip([0] + ends, ends)]

    def shown(self):
        """Every body at every place, in the scene's order."""
        if not self.two_level:
            return [Shown(body, body.node) for body in self.bodies]
        of_blas = {}
        for body in self.bodies:
            of_blas.setdefault(body.blas, []).append(body)
        out = []
        for row in self.file.inst[np.argsort(self.file.inst["id"], kind="stable")]:
            matrix = row["object_to_world"].reshape(3, 4).astype(np.float64)
            # A part that a node moved before the instance did says so itself: several nodes may be in one tree.
            out += [Shown(body, int(row["node"]) if body.node == NO_NODE else body.node, matrix) for body in of_blas.get(int(row["blas"]), [])]
        return out
