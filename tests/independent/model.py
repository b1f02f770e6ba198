"""What a model says, as the second reader tells it: placed parts of triangles in f64, and what is wrong with the file.

Both readers (`gltf_scene`, `obj_model`) fill these records from the published specifications alone. They share nothing with the tool.
"""

from dataclasses import dataclass, field

import numpy as np

# `node` of a part that no node places, as the cache writes it.
NO_NODE = 0xFFFFFFFF


class Refused(Exception):
    """The file says nothing that could be built, or says it in a way that no reader may guess at."""


class Unsupported(Refused):
    """The file may be fine, and needs what neither reader knows."""


@dataclass
class Part:
    """Triangles of one primitive (glTF) or of one run of faces (OBJ), in the space of their mesh.

    positions: f64[v, 3]; corners: int64[t, 3], rows of positions. `magnitude` f64[v, 3] bounds the terms that each position was summed
    from: what f64 arithmetic may be off grows with them. `first_prim` counts the triangles of the parts before it.
    """

    number: int
    first_prim: int
    positions: np.ndarray
    corners: np.ndarray
    magnitude: np.ndarray
    name: tuple = (b"", b"")  # of object and group
    deformed: bool = False  # by a skin or by morph targets of one node
    polygons: list = field(default_factory=list)
    is_cut: np.ndarray = None  # bool[t]: the triangle is of a polygon, which another reader may cut otherwise

    def __len__(self):
        return len(self.corners)

    def of_polygon(self, rows):
        return np.zeros(len(rows), dtype=bool) if self.is_cut is None else self.is_cut[rows]


@dataclass
class Polygon:
    """A face of more than three corners: rows of the part's positions, and the first of its triangles in the part."""

    first: int
    corners: np.ndarray


@dataclass
class Placement:
    """One mesh where one node puts it. `copy` counts the instances that one node makes of it."""

    mesh: int
    node: int
    copy: int
    matrix: np.ndarray  # f64[4, 4], column vectors
    magnitude: np.ndarray  # f64[4, 4]: the same product over absolute values
    parts: list


@dataclass
class Model:
    placements: list = field(default_factory=list)
    faults: list = field(default_factory=list)  # breaches of the specification that another reader may refuse
    skipped: int = 0  # primitives or elements that are no triangles

    def fault(self, text):
        if text not in self.faults:
            self.faults.append(text)

    def triangle_count(self):
        return sum(len(part) for placement in self.placements for part in placement.parts)
