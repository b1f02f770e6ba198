#!/usr/bin/env python3
"""Does a cache hold what the model says? The second reader of this folder judges, in f64.

    compare.py MODEL CACHE [--json]

Every triangle must be there under its mesh, part and number, each corner at most half a unit in the last place of the stored numbers away
from where the specification puts it; what is not there must be what the policy leaves out, and must have been counted.
Prints one line. Exit status: 0 they agree, 1 they differ, 2 usage, 3 a file cannot be read, 4 the second reader refuses the model.
"""

import argparse
import json
import os
import sys
from collections import Counter

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import gltf_scene  # noqa: E402
import obj_model  # noqa: E402
import polygons  # noqa: E402
import tree_origin  # noqa: E402
from blake3 import blake3  # noqa: E402
from arithmetic import F64_SLACK, half_ulp, rounded, without_area  # noqa: E402
from cache import Cache, bvhc_reader  # noqa: E402
from model import NO_NODE, Refused  # noqa: E402


def read_model(path, moment=None):
    """The model in a file, its format told by its name, or else by its content; a glTF perhaps at a moment of an animation."""
    lower = path.lower()
    if lower.endswith((".gltf", ".glb")):
        return gltf_scene.read(path, moment)
    with open(path, "rb") as file:
        data = file.read()
    if not lower.endswith(".obj") and (data[:4] == b"glTF" or data.lstrip()[:1] == b"{"):
        return gltf_scene.read(path, moment)
    if moment is not None:
        raise Refused("an OBJ has no animations")
    return obj_model.read(data)


class Comparison:
    """The differences between a model and a cache: one record a kind and place, with how many there are and the first of them."""

    def __init__(self, model, cache):
        self.model, self.cache = model, cache
        self.differences = []
        self.compared = self.left_out = 0
        # In the meshes, and where they are shown.
        self.dropped = {"degenerate": [0, 0], "non_finite": [0, 0], "out_of_range": [0, 0]}
        self.counted_meshes = set()
        self.unsure = 0  # triangles of polygons that are left out for one reason or another
        self.gone_with_place = 0  # triangles of placements of which nothing is left
        self.of_tree, self.origins = {}, {}
        self.copies = Counter(placement.mesh for placement in model.placements)
        self.keep = cache.options.get("degenerate") == "keep"

    def differ(self, kind, where, count=1, first=""):
        self.differences.append({"kind": kind, "where": where, "count": int(count), "first": first})

    def run(self):
        shown = self.by_place()
        self.find_instances(shown)
        for placement in self.model.placements:
            compared, left_out = self.compared, self.left_out
            for part in placement.parts:
                if len(part):
                    self.part(placement, part, shown.pop((placement.mesh, part.number, placement.node, placement.copy), None))
            if self.compared == compared:
                self.gone_with_place += self.left_out - left_out
        for key, extra in shown.items():
            if len(extra.body.prims):
                self.differ("extra part", place_name(*key), len(extra.body.prims))
        self.counts()
        return self

    def find_instances(self, shown):
        """What each tree holds where: triples of placement, part and instance."""
        for placement in self.model.placements:
            for part in placement.parts:
                there = shown.get((placement.mesh, part.number, placement.node, placement.copy))
                if there is not None and there.matrix is not None and ((there.body.prims - part.first_prim) < len(part)).all():
                    self.of_tree.setdefault(there.body.blas, []).append((placement, part, there))

    def by_place(self):
        """The cache's bodies under (mesh, part, node, copy): the n-th of one mesh, part and node is the n-th instance of that node."""
        places, out, copies = {}, {}, {}
        for placement in self.model.placements:
            places.setdefault(placement.mesh, []).append(placement)
        nodes = {mesh: {p.node for p in of_mesh} for mesh, of_mesh in places.items()}
        for shown in self.cache.shown():
            mesh, node = shown.body.mesh, shown.node
            own = nodes.get(mesh, set())
            if node == NO_NODE and len(own) > 1:
                own = {p.node for p in places[mesh] if not all(left_out(p, part).all() for part in p.parts)}
            if len(own) == 1 and (node == NO_NODE or NO_NODE in own):
                # A mesh that is shown once needs no name for its node in the file; nor does OBJ, which has no nodes.
                node = next(iter(own))
            key = (mesh, shown.body.part, node)
            copy = copies[key] = copies.get(key, -1) + 1
            out[key + (copy,)] = shown
        return out

    def part(self, placement, part, shown):
        where = place_name(placement.mesh, part.number, placement.node, placement.copy)
        if shown is None:
            return self.missing(placement, part, np.arange(len(part)), where)
        body = shown.body
        if (body.first_prim, body.prim_count) != (part.first_prim, len(part)):
            self.differ("range", where, 1, "first_prim, prim_count %d, %d; right: %d, %d"
                        % (body.first_prim, body.prim_count, part.first_prim, len(part)))
            return None
        # The name of a glTF mesh is stored as it stands; that of an OBJ part is put together of two.
        name = clipped(part.name if isinstance(part.name, bytes) else stored_name(*part.name))
        if body.name != name:
            self.differ("name", where, 1, "%r; right: %r" % (body.name, name))
        rows = body.prims - part.first_prim
        there = np.zeros(len(part), dtype=bool)
        there[rows] = True
        self.missing(placement, part, np.flatnonzero(~there), where)
        self.compared += len(rows)
        if len(rows):
            self.positions(placement, part, shown, rows, where)
        return None

    # Where corners are.

    def positions(self, placement, part, shown, rows, where):
        stored = shown.body.corners.astype(np.float64)
        if not self.keep and id(shown.body) not in self.counted_meshes:
            self.counted_meshes.add(id(shown.body))
            flat = without_area(shown.body.corners)
            if flat.any():
                self.differ("without area, and kept", where, flat.sum(), "triangle %d" % rows[np.argmax(flat)])
        cut = part.of_polygon(rows)
        right, size = part.positions[part.corners[rows]], part.magnitude[part.corners[rows]]
        matrix, magnitude = placement.matrix, placement.magnitude
        if shown.matrix is None:
            exact = transform(matrix, right)
            found = self.judge(exact, stored, transform(magnitude, size) * F64_SLACK, cut, rows)
        else:
            # What the matrix is says how the tree stands. Where several readings could be meant, one of them has to be right.
            readings = list(self.readings(placement, shown, right, size))
            judged = [self.judge(exact, stored, slack, cut, rows) for exact, slack in readings]
            found = min(judged, key=lambda found: sum(count for _, count, _ in found), default=None)
            if found is None:
                self.differ("matrix", where, 1, "it is %s; the node's: %s" % (numbers(shown.matrix), numbers(matrix[:3])))
        for kind, count, first in found or []:
            self.differ(kind, where, count, first)
        if part.polygons:
            polygons.compare(self, placement, part, shown, rows, where)

    def readings(self, placement, shown, right, size):
        """What the corners of an instance may be (SPEC.md, 10.6), with what f64 may be off: none if the matrix fits none of it."""
        matrix, magnitude = placement.matrix, placement.magnitude
        if (shown.matrix[:, :3] == np.eye(3)).all():
            # The node's transform is applied, but for a translation to an origin.
            yield transform(matrix, right) - shown.matrix[:, 3], transform(magnitude, size) * F64_SLACK
        if not (np.abs(shown.matrix - matrix[:3]) <= half_ulp(matrix[:3]) + magnitude[:3] * F64_SLACK)[:, :3].all():
            return
        if (np.abs(shown.matrix - matrix[:3]) <= half_ulp(matrix[:3]) + magnitude[:3] * F64_SLACK).all():
            # The node's matrix, each entry rounded once: the mesh stands in its own space.
            yield right, size * F64_SLACK
        if self.copies[placement.mesh] > 1:
            # A mesh of several places, which is moved in its own space.
            origin, missed = self.origin(shown.body.blas)
            if missed <= tree_origin.NEARLY:
                exact = right - origin
                yield exact, (size + np.abs(origin)) * F64_SLACK + (tree_origin.NEARLY - 1) * half_ulp(exact)

    def origin(self, blas):
        if blas not in self.origins:
            bodies, seen = [], set()
            for placement, part, shown in self.of_tree[blas]:
                if id(shown.body) not in seen and len(shown.body.prims):
                    seen.add(id(shown.body))
                    at = part.corners[shown.body.prims - part.first_prim].reshape(-1)
                    bodies.append((shown.body.corners.reshape(-1, 3).astype(np.float64), part.positions[at], part.magnitude[at]))
            instances = {(p.node, p.copy): (shown.matrix, p.matrix, p.magnitude) for p, _, shown in self.of_tree[blas]}
            self.origins[blas] = tree_origin.find(bodies, instances.values())
        return self.origins[blas]

    @staticmethod
    def judge(exact, got, slack, cut, rows):
        """Corners in their order, each the right one rounded once: a list of (kind, count, first) of what differs."""
        bound, out = half_ulp(exact) + slack, []

        def near(at, order):
            return (np.abs(got[at] - exact[at][:, order]) <= bound[at][:, order]).all(axis=(1, 2))

        with np.errstate(invalid="ignore", over="ignore"):
            bad = np.flatnonzero(~(near(slice(None), [0, 1, 2]) | cut))
            for kind, orders in (("corners turned", ([1, 2, 0], [2, 0, 1])), ("corners the other way round", ([2, 1, 0], [1, 0, 2], [0, 2, 1]))):
                these = np.zeros(len(bad), dtype=bool)
                for order in orders:
                    these |= near(bad, order)
                if these.any():
                    out.append((kind, these.sum(), "triangle %d" % rows[bad[np.argmax(these)]]))
                bad = bad[~these]
            if len(bad):
                off = np.abs(got[bad] - exact[bad])
                ulps = np.nan_to_num((off / (2 * half_ulp(exact[bad]))).max(axis=(1, 2)), nan=np.inf)
                i = int(np.argmax(ulps))
                out.append(("position", len(bad), "triangle %d is at %s; right: %s (off by %.3g, %.3g units in the last place)" % (
                    rows[bad[i]], triangle(got[bad[i]]), triangle(exact[bad[i]]), off[i].max(), ulps[i])))
        return out

    # What is not there.

    def missing(self, placement, part, rows, where):
        if not len(rows):
            return
        self.left_out += len(rows)
        finite, flat = reasons(placement, part, rows)
        # Of a polygon with a corner beyond f32, or that is no number, the cut decides how many triangles have that corner.
        unsure = self.of_polygon_beyond(part, rows)
        self.unsure += int(unsure.sum())
        # Two nodes may give a mesh the same pose, which is then one mesh.
        key = placement.mesh, part.number, blake3(part.positions.tobytes()).digest() if part.deformed else None
        first = key not in self.counted_meshes
        self.counted_meshes.add(key)
        # A number of the model that f32 cannot hold is told from what is no number. What a place moves so far counts with the latter.
        local = part.positions[part.corners[rows]]
        beyond = np.isfinite(local).all(axis=(1, 2)) & ~np.isfinite(rounded(local)).all(axis=(1, 2))
        for reason, these in (("non_finite", ~finite & ~beyond), ("out_of_range", beyond), ("degenerate", flat & finite)):
            self.dropped[reason][0] += int((these & ~unsure).sum()) * first
            self.dropped[reason][1] += int((these & ~unsure).sum())
        lost = finite & ~flat
        if self.keep and not (flat.all() and len(rows) == len(part)):
            # `keep` keeps what is flat in the model, not an instance that is scaled to nothing.
            lost = finite & ~unsure
        if lost.any():
            i = int(np.argmax(lost))
            world = transform(placement.matrix, part.positions[part.corners[rows[i]]])
            self.differ("missing", where, lost.sum(), "triangle %d at %s" % (rows[i], triangle(world)))

    @staticmethod
    def of_polygon_beyond(part, rows):
        beyond = np.zeros(len(part), dtype=bool)
        for polygon in part.polygons if not np.isfinite(rounded(part.positions)).all() else []:
            if not np.isfinite(rounded(part.positions[polygon.corners])).all():
                beyond[polygon.first:polygon.first + len(polygon.corners) - 2] = True
        return beyond[rows]

    def counts(self):
        """What was left out must have been counted: triangles once a mesh or once a place; a place of which nothing is left may count as one."""
        instances = any(count for name, count in self.cache.read_counts.items() if name.endswith("_instances"))
        for reason, right in self.dropped.items():
            told = self.cache.read_counts.get(reason + "_triangles", 0)
            if self.keep and reason == "degenerate":
                continue  # there it counts those that were found, and kept
            if not min(right) - (self.gone_with_place if instances else 0) <= told <= max(right) + self.unsure:
                self.differ("count", reason, 1, "the cache says that %d triangles were left out as %s; right: %s"
                            % (told, reason, " or ".join(map(str, sorted(set(right))))))


def reasons(placement, part, rows):
    """(bool[k], bool[k]): can f32 hold the triangles, and may they be left out as flat?"""
    local = part.positions[part.corners[rows]]
    world = transform(placement.matrix, local)
    finite = np.isfinite(rounded(local)).all(axis=(1, 2)) & np.isfinite(rounded(world)).all(axis=(1, 2))
    # What is missing of a polygon is judged with what is there of it.
    flat = part.of_polygon(rows)
    # Without area in the model, in the numbers that a mesh would be stored in, or in those of its place.
    for corners in (local, rounded(local), rounded(world)):
        unsure = np.flatnonzero(finite & ~flat)
        if len(unsure):
            flat[unsure] = without_area(corners[unsure])
    return finite, flat | finite & lost_in_place(placement.matrix, local, world)


def lost_in_place(matrix, local, world):
    """bool[k]: does a transform without inverse leave no area but the rounding of f64? SPEC 10.5."""
    linear = matrix[:3, :3]
    with np.errstate(invalid="ignore", over="ignore"):
        columns = np.sqrt((linear * linear).sum(axis=0))
        # A matrix whose columns lie in a plane, up to what composing it rounds.
        if not abs(np.linalg.det(linear)) <= 2.0 ** -40 * np.prod(np.where(columns > 0, columns, 1)):
            return np.zeros(len(local), dtype=bool)
        u, v = world[:, 1] - world[:, 0], world[:, 2] - world[:, 0]
        area, edges = (np.sqrt((x * x).sum(axis=1)) for x in (np.cross(u, v), np.concatenate([u, v], axis=1)))
        reach = transform(np.abs(matrix), np.abs(local)).max(axis=(1, 2))
        return area <= 2.0 ** -43 * reach * edges


def left_out(placement, part):
    """bool[t]: the triangles that the policy `drop` leaves out."""
    finite, flat = reasons(placement, part, np.arange(len(part)))
    return ~finite | flat


def transform(matrix, points, w=1.0):
    with np.errstate(invalid="ignore", over="ignore"):
        return points @ matrix[:3, :3].T + matrix[:3, 3] * w


def stored_name(object_, group):
    """The name of an OBJ part, as section 10.4 of the format writes it: no byte of the model is lost."""
    def escaped(text, special):
        out = ""
        # Bytes that are no UTF-8 come as U+DC80 and on.
        for c in text.decode("utf-8", "surrogateescape"):
            byte = ord(c) - 0xDC00 if 0xDC80 <= ord(c) <= 0xDCFF else ord(c)
            out += "%%%02X" % byte if byte != ord(c) or c in special else c
        return out

    return (escaped(object_, "%/") + ("/" + escaped(group, "%") if group else "")).encode("utf-8")


def clipped(name):
    """A name's bytes as a file has them: of a long one the start, between two characters, and half of its hash."""
    if len(name) <= 4096:
        return name
    return name[:4063].decode("utf-8", "ignore").encode("utf-8") + b"~" + blake3(name).hexdigest()[:32].encode()


def place_name(mesh, part, node, copy):
    return "mesh %d part %d" % (mesh, part) + (" at node %d" % node if node != NO_NODE else "") + (" copy %d" % copy if copy else "")


def numbers(matrix):
    return " ".join("%.9g" % x for x in matrix.reshape(-1))


def triangle(corners):
    return " ".join("(%s)" % ",".join("%.9g" % x for x in corner) for corner in corners)


def compare(model_path, cache_path):
    """(model, comparison). Raises Refused where the second reader cannot read the model, Invalid or Unsupported for the cache."""
    model = read_model(model_path)
    return model, Comparison(model, Cache(cache_path)).run()


def line(name, comparison):
    if not comparison.differences:
        out = "%s: %d triangles agree" % (name, comparison.compared)
        return out + (", %d left out" % comparison.left_out if comparison.left_out else "")
    first = comparison.differences[0]
    kinds = {}
    for d in comparison.differences:
        kinds[d["kind"]] = kinds.get(d["kind"], 0) + d["count"]
    return "%s: DIFFERS (%s); %s: %s" % (name, ", ".join("%d %s" % (n, k) for k, n in kinds.items()), first["where"], first["first"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model")
    parser.add_argument("cache")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    arguments = parser.parse_args()
    try:
        model, comparison = compare(arguments.model, arguments.cache)
    except OSError as error:
        print("error: %s" % error, file=sys.stderr)
        return 3
    except Refused as error:
        print("error: the second reader refuses %s: %s" % (arguments.model, error), file=sys.stderr)
        return 4
    except (bvhc_reader.Invalid, bvhc_reader.Unsupported) as error:
        print("error: %s: %s" % (arguments.cache, error), file=sys.stderr)
        return 3
    if arguments.json:
        print(json.dumps({
            "schema": "bvhc.independent.v1", "model": arguments.model, "cache": arguments.cache, "agree": not comparison.differences,
            "compared": comparison.compared, "left_out": comparison.left_out, "faults": model.faults,
            "differences": comparison.differences,
        }, indent=2))
    else:
        print(line(arguments.model, comparison))
    return 1 if comparison.differences else 0


if __name__ == "__main__":
    sys.exit(main())
