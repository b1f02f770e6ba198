#!/usr/bin/env python3
"""From hits back to models: what a cache alone says of each hit, held against the model as the second reader has it.

    origins.py --tool BVHC --hits PROGRAM [--count N] MODEL…

PROGRAM is the example `hits`. Each model is built with --vertices at one level and at two and is shot at. By VERT, MATS, SIDE and GEOM the
cache gives each hit's vertices, normal, texture coordinate, material and front side (SPEC.md, 10.2 to 10.5); the model gives the same by
its own indices, and by weights that are computed from the point in space. Without models it judges small ones that it writes itself.

Exit status: 0 all agree, 1 some differ.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import gltf_scene  # noqa: E402
import obj_model  # noqa: E402
from cache import Cache  # noqa: E402
from gltf_document import Document  # noqa: E402
from model import NO_NODE  # noqa: E402


class GltfSource:
    """A glTF model's triangles, vertex attributes and material names."""

    def __init__(self, path):
        self.document = Document(path)
        self.scene = gltf_scene.Scene(self.document)
        self.scene.place()
        self.placements = {(p.mesh, p.node, p.copy): p for p in self.document.model.placements}
        only = self.document.model.placements
        self.only = only[0] if len(only) == 1 else None
        self.read = {}

    def part(self, mesh, part):
        """The primitive's own triangles as vertex numbers, its attributes, and its material's name."""
        if (mesh, part) not in self.read:
            item, _, corners = self.scene.mesh(mesh)[part]
            attributes = {}
            for name, types in (("NORMAL", ("VEC3",)), ("TEXCOORD_0", ("VEC2",))):
                index = item["attributes"].get(name)
                if index is not None:
                    attributes[name] = self.document.floats(index, types)
            material = item.get("material")
            name = "" if material is None else self.document.item("materials", material).get("name", "")
            self.read[mesh, part] = corners, attributes, name
        return self.read[mesh, part]

    def check(self, hit, row, node, copy, counted):
        """Compare one hit; a list of what differs, and the world corners of the triangle."""
        mesh, part = int(row["source_mesh"]), int(row["source_part"])
        corners, attributes, material = self.part(mesh, part)
        own = corners[hit["prim"] - int(row["first_prim"])]
        placement = self.placements.get((mesh, node, copy)) or (self.only if node == NO_NODE else None)
        if placement is None:
            return ["no node %d shows mesh %d so often" % (node, mesh)], None
        body = next(p for p in placement.parts if p.number == part)
        matrix = placement.matrix
        world = body.positions[own] @ matrix[:3, :3].T + matrix[:3, 3]
        wrong = []
        if hit["vertices"] != own.tolist():
            wrong.append("vertices %s, the model has %s" % (hit["vertices"], own.tolist()))
        if hit["material"] != material:
            wrong.append("material %r, the model has %r" % (hit["material"], material))
        weights, allowed = own_weights(hit, world)
        for name, values in attributes.items():
            counted[name] = counted.get(name, 0) + 1
            by_cache = stored_weights(hit) @ values[hit["vertices"]]
            by_model = weights @ values[own]
            spread = np.ptp(values[own], axis=0).max()
            if np.abs(by_cache - by_model).max() > allowed * spread + 1e-9:
                wrong.append("%s %s, the model has %s" % (name, by_cache, by_model))
        # A skin says nothing of sides; a node that mirrors turns the corners around, and not the front.
        front = None
        if not body.deformed:
            front = np.cross(world[1] - world[0], world[2] - world[0]) * np.sign(np.linalg.det(matrix[:3, :3]))
        return wrong + check_front(hit, front), world


class ObjSource:
    """The corners of an OBJ model's faces, counted through the file, and the material of each run of faces."""

    def __init__(self, data):
        self.v, self.vt, self.vn = [], [], []
        self.corners, self.faces, self.materials = [], [], []
        state, run = [0, b"", b"", b""], None
        for line in obj_model.statements(data):
            words = line.split(None, 1)
            key, rest = words if len(words) == 2 else (line, b"")
            if key in (b"v", b"vt", b"vn"):
                numbers = [obj_model.odd_number(n) for n in rest.split()[:3]]
                {b"v": self.v, b"vt": self.vt, b"vn": self.vn}[key].append(numbers)
            elif key == b"o":
                state[0], state[1] = state[0] + 1, rest
            elif key == b"g":
                state[2] = rest
            elif key == b"usemtl":
                state[3] = rest
            elif key in (b"f", b"fo"):
                tokens = rest.split()
                if len(tokens) > 2:
                    if run != state:
                        run = list(state)
                        self.materials.append(escaped(state[3]))
                    self.faces.append((len(self.corners), len(tokens), len(self.materials) - 1))
                # Corners of lines and points are counted, too.
                self.corners += [self.corner(token) for token in tokens]
        counts = np.array([n - 2 for _, n, _ in self.faces], dtype=np.int64)
        self.first_prims = np.cumsum(counts) - counts

    def corner(self, token):
        """Rows of v, vt, vn; None for what the corner does not say."""
        out = []
        for text, rows in zip((token.split(b"/") + [b"", b""])[:3], (self.v, self.vt, self.vn)):
            number = int(text) if text else 0
            out.append(None if number == 0 else number - 1 if number > 0 else len(rows) + number)
        return out

    def check(self, hit, row, node, copy, counted):
        numbers = hit["vertices"]
        face = int(np.searchsorted(self.first_prims, hit["prim"], side="right")) - 1
        start, size, run = self.faces[face]
        wrong = []
        if not (len(set(numbers)) == 3 and all(start <= n < start + size for n in numbers)):
            return ["vertices %s are not of face %d, which has %d to %d" % (numbers, face, start, start + size - 1)], None
        # The winding of the face: its corners in order, from one of them on. A face of three has one triangle, as it is.
        turned = [n - start for n in numbers]
        first = turned.index(min(turned))
        if turned[first:] + turned[:first] != sorted(turned) or (size == 3 and turned != [0, 1, 2]):
            wrong.append("vertices %s are not in the order of face %d" % (numbers, face))
        if run != int(row["source_part"]) or hit["material"] != self.materials[run]:
            wrong.append("part %d and material %r, the model has %d and %r" % (row["source_part"], hit["material"], run, self.materials[run]))
        rows = [self.corners[n] for n in numbers]
        world = np.array([self.v[r[0]] for r in rows], dtype=np.float64)
        weights, allowed = own_weights(hit, world)
        for which, values, name in ((1, self.vt, "vt"), (2, self.vn, "vn")):
            if any(r[which] is None for r in rows):
                continue
            counted[name] = counted.get(name, 0) + 1
            at = np.array([values[r[which]] for r in rows], dtype=np.float64)
            by_cache, by_model = stored_weights(hit) @ at, weights @ at
            if np.abs(by_cache - by_model).max() > allowed * np.ptp(at, axis=0).max() + 1e-9:
                wrong.append("%s %s, the model has %s" % (name, by_cache, by_model))
        front = np.cross(world[1] - world[0], world[2] - world[0])
        return wrong + check_front(hit, front), world


def escaped(name):
    """As SPEC.md 10.4 writes bytes as text: % and two digits for % itself and for what is not UTF-8."""
    out = name.replace(b"%", b"%25").decode("utf-8", "surrogateescape")
    return "".join("%%%02X" % (ord(c) - 0xDC00) if 0xDC80 <= ord(c) <= 0xDCFF else c for c in out)


def stored_weights(hit):
    return np.array([1.0 - hit["u"] - hit["v"], hit["u"], hit["v"]])


def point(hit):
    return np.array(hit["origin"]) + hit["t"] * np.array(hit["direction"])


def own_weights(hit, world):
    """Weights of the corners at the point in space, and how far rounding may move them: by the error of the point over the height."""
    a, b = world[1] - world[0], world[2] - world[0]
    normal = np.cross(a, b)
    square = normal @ normal
    if square == 0:
        return stored_weights(hit), np.inf
    p = point(hit) - world[0]
    u, v = np.cross(p, b) @ normal / square, np.cross(a, p) @ normal / square
    longest = max(np.linalg.norm(a), np.linalg.norm(b), np.linalg.norm(a - b))
    # A ray that grazes the triangle slides along it by more than the point is off.
    direction = np.array(hit["direction"])
    slant = abs(direction @ normal) / (np.linalg.norm(direction) * np.sqrt(square))
    size = np.abs(np.concatenate([world.ravel(), np.array(hit["origin"]), hit["t"] * direction])).max()
    return np.array([1 - u - v, u, v]), 1e-5 + 2.0**-21 * size * longest / np.sqrt(square) / max(slant, 1e-9)


def check_front(hit, front):
    """The cache's normal stands on the triangle, on the side that is the front."""
    if front is None:
        return []
    normal = np.array(hit["normal"])
    lengths = np.linalg.norm(normal) * np.linalg.norm(front)
    # Rounded corners turn the normal of a sliver anywhere.
    if lengths == 0 or normal @ front > 0:
        return []
    return ["the normal %s points away from the front %s" % (normal, front)]


def judge(path, arguments, scratch):
    """Both levels of one model: how many hits were compared, and what differs."""
    name = os.path.basename(path)
    if path.lower().endswith("obj"):
        with open(path, "rb") as file:
            source = ObjSource(file.read())
    else:
        source = GltfSource(path)
    differences = []
    for levels in ("one", "two"):
        cache_path = os.path.join(scratch, "origins.bvhc")
        # The quickest recipe with spatial splits, so that there are copies.
        command = [arguments.tool, "build", path, "-o", cache_path, "--force", "--vertices", "--levels", levels, "--method", "sbvh", "-q"]
        subprocess.run(command, check=True)
        cache = Cache(cache_path)
        if any(cache.read_counts.get(k, 0) for k in ("singular_instances", "out_of_range_instances")):
            raise SystemExit("%s: elements cannot be told where instances were left out" % name)
        lines = subprocess.run([arguments.hits, cache_path, str(arguments.count)], check=True, capture_output=True).stdout.splitlines()
        hits, counted, bad = [json.loads(line) for line in lines], {}, []
        copies = Copies(cache)
        for hit in hits:
            row = cache.file.geom[hit["geom"]]
            wrong = copies.wrong(hit)
            if not wrong:
                wrong, _ = source.check(hit, row, *copies.place(hit), counted)
            if wrong:
                bad.append("%s: %s" % ({k: hit[k] for k in ("instance", "geom", "prim")}, "; ".join(wrong)))
        told = ", ".join("%d %s" % (n, k) for k, n in sorted(counted.items())) or "no attributes"
        materials = len({hit["material"] for hit in hits})
        print("%-6s %-4s %s: %d hits of %d asked for, %d materials, %s; %d mirrored parts" % (
            "FAIL" if bad else "agrees", levels, name, len(hits), arguments.count, materials, told, cache.file.mirrored.sum()))
        if len(hits) < arguments.count:
            bad.append("only %d hits" % len(hits))
        for line in bad[:5]:
            print("       " + line)
        differences += bad
    return differences


class Copies:
    """Which element of its node a hit shows (SPEC.md, 10.5), and whether the program read the same sections as the reference reader."""

    def __init__(self, cache):
        self.file = cache.file
        self.instances = {int(row["id"]): row for row in self.file.inst}
        self.element, seen = {}, {}
        if self.file.two_level:
            for number in sorted(self.instances):
                node = int(self.instances[number]["node"])
                self.element[number] = seen.get(node, 0)
                seen[node] = self.element[number] + 1
        else:
            for g, row in enumerate(self.file.geom):
                key = tuple(int(row[k]) for k in ("baked_node", "source_mesh", "source_part"))
                self.element[g] = seen.get(key, 0)
                seen[key] = self.element[g] + 1

    def place(self, hit):
        node = int(self.file.geom[hit["geom"]]["baked_node"])
        if not self.file.two_level:
            return node, self.element[hit["geom"]]
        row = self.instances[hit["instance"]]
        return (int(row["node"]) if node == NO_NODE else node), self.element[hit["instance"]]

    def wrong(self, hit):
        file, slot, g = self.file, hit["triangle"], hit["geom"]
        material = file.materials[g].decode() if file.materials else ""
        said = (file.vertices[slot].tolist(), int(file.tris["geom"][slot]), int(file.tris["prim"][slot]), material)
        mine = (hit["vertices"], g, hit["prim"], hit["material"])
        return [] if said == mine else ["the program says %s and the file %s" % (mine, said)]


def small_models(folder):
    """A ground of polygons of every kind, and a mesh with a mirroring node, with texture coordinates, normals and materials."""
    points, faces = [], []

    def face(keyword, corners):
        words = []
        for x, y in corners:
            points.append("v %g %g %g\nvt %g %g\nvn %g %g 1" % (x, y, 0.1 * x * x, x / 7, y / 3, 0.2 * x, -0.1 * y))
            words.append("%d/%d/%d" % (3 * (len(points),)))
        faces.append(keyword + " " + " ".join(words))

    for i in range(40):
        x, y = i % 8, i // 8 * 3
        faces.append("usemtl m%d%%" % (i % 5))
        face("f", [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)])
        face("f", [(x, y), (x + 1, y)])
        face("fo", [(x, y + 1), (x + 0.5, y + 1.7), (x + 1, y + 1), (x + 1, y + 2), (x, y + 2)])
        face("f", [(x, y + 2), (x + 1, y + 2), (x, y + 3)])
    with open(os.path.join(folder, "ground.obj"), "w") as file:
        file.write("\n".join(points + faces) + "\n")

    side = 9
    grid = np.array([(x, y, 0.3 * ((x * y) % 3)) for y in range(side) for x in range(side)], dtype="<f4")
    normals = np.array([(0.1 * x, 0.1 * y, 1) for x, y, _ in grid], dtype="<f4")
    texture = np.array([(x / side, y * y / side) for x, y, _ in grid], dtype="<f4")
    cells = [y * side + x for y in range(side - 1) for x in range(side - 1)]
    indices = np.array([(a, a + 1, a + side + 1, a, a + side + 1, a + side) for a in cells], dtype="<u2")
    half = len(indices) // 2
    chunks, views = b"", []
    for array in (grid, normals, texture, indices[:half], indices[half:]):
        views.append({"buffer": 0, "byteOffset": len(chunks), "byteLength": array.nbytes})
        chunks += array.tobytes() + bytes(-array.nbytes % 4)
    accessors = [{"bufferView": i, "componentType": 5126, "count": len(grid), "type": "VEC%d" % n} for i, n in ((0, 3), (1, 3), (2, 2))]
    accessors += [{"bufferView": i, "componentType": 5123, "count": 6 * n, "type": "SCALAR"} for i, n in ((3, half), (4, len(indices) - half))]
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    document = {
        "asset": {"version": "2.0"}, "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(chunks), "uri": "grid.bin"}],
        "materials": [{"name": "oak"}, {"name": "a/b% é"}], "scene": 0, "scenes": [{"nodes": [0, 1, 2]}],
        "meshes": [{"name": "grid", "primitives": [{"attributes": attributes, "indices": 3 + i, "material": i} for i in (0, 1)]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [20, 0, 0], "scale": [-1, 2, 1]},
                  {"translation": [0, 20, 0], "scale": [-1, -1, 1], "children": [3]}, {"mesh": 0, "rotation": [0.6, 0, 0, 0.8], "scale": [1, 1, -2]}],
    }
    with open(os.path.join(folder, "grid.bin"), "wb") as file:
        file.write(chunks)
    with open(os.path.join(folder, "grid.gltf"), "w") as file:
        json.dump(document, file)
    return [os.path.join(folder, name) for name in ("ground.obj", "grid.gltf")]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*")
    parser.add_argument("--tool", required=True, help="the program bvhc")
    parser.add_argument("--hits", required=True, help="the example hits")
    parser.add_argument("--count", type=int, default=20000, help="hits for each level")
    arguments = parser.parse_args()
    failures = 0
    with tempfile.TemporaryDirectory() as scratch:
        for path in arguments.models or small_models(scratch):
            failures += len(judge(path, arguments, scratch))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
