"""The triangles of a glTF 2.0 scene where it shows them, at rest or at a moment. Numbers in brackets are sections of the specification.

At rest no animation runs; skins and morph targets apply with the weights and joints as the nodes give them.
"""

import numpy as np

import gltf_animation
from gltf_document import Document
from model import Part, Placement, Refused, Unsupported

TRIANGLES, STRIP, FAN = 4, 5, 6
IDENTITY = np.eye(4)


def read(path, moment=None):
    """`moment` is the number of an animation and a time in seconds."""
    document = Document(path)
    if moment is not None:
        gltf_animation.pose(document, *moment)
    scene = Scene(document)
    scene.place()
    return document.model


class Scene:
    def __init__(self, document):
        self.document, self.model = document, document.model
        self.meshes = {}
        self.locals, self.parents = {}, self.find_parents()
        self.globals = {}

    # Which nodes are shown [3.5.1].

    def roots(self):
        root = self.document.json
        scenes = self.document.list(root, "scenes")
        if "scene" in root:
            scene = self.document.item("scenes", root["scene"])
        elif scenes:
            # The specification leaves it to the reader. The first scene is what all readers take.
            scene = self.document.item("scenes", 0)
        else:
            # An asset without scenes is a library. All that nothing else contains is shown, so that its meshes can be built.
            return [n for n in range(len(self.document.list(root, "nodes"))) if n not in self.parents]
        return [self.document.integer(n, "a scene's node") for n in self.document.list(scene, "nodes")]

    def find_parents(self):
        parents = {}
        for n, node in enumerate(self.document.list(self.document.json, "nodes")):
            if not isinstance(node, dict):
                raise Refused("node %d is no object" % n)
            for child in self.document.list(node, "children"):
                child = self.document.integer(child, "a child")
                if child in parents:
                    self.model.fault("node %d has two parents" % child)
                parents.setdefault(child, n)
        return parents

    def place(self):
        seen, pending = set(), [(n, None) for n in reversed(self.roots())]
        while pending:
            n, parent = pending.pop()
            if n in seen:
                # Nodes form disjoint strict trees: a second way to a node is an error, and a loop is one.
                raise Refused("node %d is reached twice" % n)
            seen.add(n)
            node = self.document.item("nodes", n)
            if parent is None and n in self.parents:
                self.model.fault("node %d is a root of the scene and has a parent" % n)
            self.place_node(n, node)
            pending += [(self.document.integer(c, "a child"), n) for c in reversed(self.document.list(node, "children"))]

    # Transforms [3.5.2, 3.5.3].

    def local(self, n):
        """The node's matrix and the same over absolute values."""
        if n in self.locals:
            return self.locals[n]
        node = self.document.item("nodes", n)
        if "matrix" in node:
            if any(key in node for key in ("translation", "rotation", "scale")):
                self.model.fault("node %d has a matrix and more" % n)
            matrix = vector(node["matrix"], 16, "the matrix of node %d" % n).reshape(4, 4).T
            if (matrix[3] != [0, 0, 0, 1]).any():
                raise Refused("the matrix of node %d is not affine" % n)
            result = matrix, np.abs(matrix)
        else:
            move = vector(node.get("translation", [0, 0, 0]), 3, "the translation of node %d" % n)
            turn = vector(node.get("rotation", [0, 0, 0, 1]), 4, "the rotation of node %d" % n)
            scale = vector(node.get("scale", [1, 1, 1]), 3, "the scale of node %d" % n)
            if abs(np.linalg.norm(turn) - 1) > 1e-3:
                self.model.fault("the rotation of node %d is no unit quaternion" % n)
            result = from_trs(move, turn, scale)
        self.locals[n] = result
        return result

    def world(self, n):
        """The product from the root down [3.5.2]."""
        chain, at = [], n
        while at is not None and at not in self.globals:
            if at in chain:
                raise Refused("node %d is its own descendant" % at)
            chain.append(at)
            at = self.parents.get(at)
        for m in reversed(chain):
            local, magnitude = self.local(m)
            parent = self.parents.get(m)
            over, over_magnitude = (IDENTITY, IDENTITY) if parent is None else self.globals[parent]
            self.globals[m] = over @ local, over_magnitude @ magnitude
        return self.globals[n]

    # Meshes [3.7.2].

    def mesh(self, m):
        if m not in self.meshes:
            item = self.document.item("meshes", m)
            primitives = item.get("primitives")
            if not isinstance(primitives, list):
                raise Refused("mesh %d has no primitives" % m)
            self.meshes[m] = [self.primitive(p, "primitive %d of mesh %d" % (i, m)) for i, p in enumerate(primitives)]
        return self.meshes[m]

    def primitive(self, item, what):
        """(item, f64 positions, int corners), or None for what shows no triangle."""
        if not isinstance(item, dict):
            raise Refused("%s is no object" % what)
        mode = item.get("mode", TRIANGLES)
        attributes = item.get("attributes")
        if not isinstance(attributes, dict):
            raise Refused("%s has no attributes" % what)
        if mode not in (TRIANGLES, STRIP, FAN):
            if mode not in (0, 1, 2, 3):
                raise Refused("%s has the mode %r" % (what, mode))
            self.model.skipped += 1
            return None
        if attributes.get("POSITION") is None:
            # "When positions are not specified, client implementations SHOULD skip primitive's rendering."
            self.model.skipped += 1
            return None
        self.refuse_compressed(item, attributes["POSITION"], what)
        positions = self.document.floats(self.document.integer(attributes["POSITION"], "POSITION"), ("VEC3",))
        if item.get("indices") is None:
            order = np.arange(len(positions), dtype=np.int64)
            pieces = [order]
        else:
            order, highest = self.document.indices(self.document.integer(item["indices"], "indices"))
            pieces = self.pieces(order, highest, mode, what)
            order = order if len(pieces) == 1 else np.concatenate(pieces)
            if len(order) and order.max() >= len(positions):
                raise Refused("%s uses vertex %d of %d" % (what, order.max(), len(positions)))
        corners = np.concatenate([topology(piece, mode) for piece in pieces])
        if mode == TRIANGLES and len(order) % 3 or len(order) < 3:
            self.model.fault("%s has %d corners" % (what, len(order)))
        return item, positions, corners

    def pieces(self, order, highest, mode, what):
        """The largest index of a type must not stand there, since graphics interfaces begin a new strip or fan at it [3.7.2.1]."""
        at = np.flatnonzero(order == highest)
        if not len(at):
            return [order]
        self.model.fault("%s has the index %d, which restarts strips" % (what, highest))
        if mode == TRIANGLES:
            return [order]
        return [piece[piece != highest] for piece in np.split(order, at)]

    def refuse_compressed(self, item, position, what):
        """Compressed data may have plain ones beside them [KHR_draco_mesh_compression]; without those there is nothing to read."""
        extensions = item.get("extensions")
        compressed = isinstance(extensions, dict) and "KHR_draco_mesh_compression" in extensions
        if compressed and self.document.item("accessors", position).get("bufferView") is None:
            raise Unsupported("%s is compressed by KHR_draco_mesh_compression" % what)

    # What a node shows.

    def place_node(self, n, node):
        if node.get("mesh") is None:
            return
        m = self.document.integer(node["mesh"], "mesh")
        bodies = self.mesh(m)
        skin = node.get("skin")
        weights = self.morph_weights(node, m, bodies)
        matrix, magnitude = (IDENTITY, IDENTITY) if skin is not None else self.world(n)
        joints = None if skin is None else self.joints(self.document.integer(skin, "skin"))
        name = self.document.item("meshes", m).get("name")
        name = name.encode("utf-8", "replace") if isinstance(name, str) else b""
        parts, first_prim = [], 0
        for i, body in enumerate(bodies):
            if body is None:
                continue
            item, positions, corners = body
            extent = np.abs(positions)
            if weights is not None:
                positions, extent = self.morphed(item, positions, extent, weights)
            if joints is not None and "JOINTS_0" in item["attributes"]:
                positions, extent = self.skinned(item, positions, extent, joints)
            elif joints is not None:
                self.model.fault("node %d has a skin, and primitive %d of its mesh no joints" % (n, i))
            deformed = weights is not None or joints is not None
            parts.append(Part(i, first_prim, positions, corners, extent, name=name, deformed=deformed))
            first_prim += len(corners)
        instances = self.instances(node)
        if skin is not None and instances is not None:
            # The extension says nothing of skins, and loaders differ. Nothing of the node places a skinned mesh, and so neither
            # does this.
            self.model.fault("node %d has a skin and EXT_mesh_gpu_instancing" % n)
            instances = None
        for copy, (move, move_magnitude) in enumerate([(IDENTITY, IDENTITY)] if instances is None else instances):
            self.model.placements.append(Placement(m, n, copy, matrix @ move, magnitude @ move_magnitude, parts))

    def morph_weights(self, node, m, bodies):
        """[3.7.2.2, 3.7.4]: the node's weights, else the mesh's, else zeros; None without targets."""
        targets = max((len(self.document.list(body[0], "targets")) for body in bodies if body is not None), default=0)
        if targets == 0:
            return None
        weights = node.get("weights", self.document.item("meshes", m).get("weights"))
        if weights is None:
            return np.zeros(targets)
        if not isinstance(weights, list) or len(weights) != targets:
            self.model.fault("mesh %d has %d targets and other than so many weights" % (m, targets))
            weights = (list(weights) + [0.0] * targets)[:targets] if isinstance(weights, list) else [0.0] * targets
        return vector(weights, targets, "weights")

    def morphed(self, item, positions, extent, weights):
        targets = self.document.list(item, "targets")
        if len(targets) != len(weights):
            self.model.fault("primitives of one mesh have other numbers of targets")
        positions, extent = positions.copy(), extent.copy()
        for weight, target in zip(weights, targets):
            if not isinstance(target, dict):
                raise Refused("a morph target is no object")
            # A target without positions moves none.
            if weight == 0 or target.get("POSITION") is None:
                continue
            moves = self.document.floats(self.document.integer(target["POSITION"], "POSITION"), ("VEC3",))
            if len(moves) != len(positions):
                raise Refused("a morph target has %d vertices, its primitive %d" % (len(moves), len(positions)))
            positions += weight * moves
            extent += np.abs(weight * moves)
        return positions, extent

    def joints(self, s):
        """f64[j, 4, 4]: each joint's place times its inverse bind matrix [3.7.3.1], and the same over absolute values."""
        skin = self.document.item("skins", s)
        nodes = [self.document.integer(j, "a joint") for j in self.document.list(skin, "joints")]
        if not nodes:
            raise Refused("skin %d has no joints" % s)
        binds = np.broadcast_to(IDENTITY, (len(nodes), 4, 4))
        if skin.get("inverseBindMatrices") is not None:
            stored = self.document.floats(self.document.integer(skin["inverseBindMatrices"], "inverseBindMatrices"), ("MAT4",))
            if len(stored) < len(nodes):
                raise Refused("skin %d has %d joints and %d inverse bind matrices" % (s, len(nodes), len(stored)))
            binds = stored[:len(nodes)].reshape(-1, 4, 4).transpose(0, 2, 1)
            if (np.abs(binds[:, 3] - [0, 0, 0, 1]) > 0).any():
                self.model.fault("an inverse bind matrix of skin %d is not affine" % s)
        worlds = [self.world(j) for j in nodes]
        return (np.array([w @ b for (w, _), b in zip(worlds, binds)]), np.array([a @ np.abs(b) for (_, a), b in zip(worlds, binds)]))

    def skinned(self, item, positions, extent, joints):
        """[3.7.3.3]: the weighted sum of the joints' transforms, weights divided by their sum."""
        attributes, matrices = item["attributes"], joints[0]
        total = np.zeros((len(positions), 4, 4))
        absolute = np.zeros((len(positions), 4, 4))
        sums, first = np.zeros(len(positions)), None
        for k in range(len(attributes)):
            if attributes.get("JOINTS_%d" % k) is None and attributes.get("WEIGHTS_%d" % k) is None:
                break
            if attributes.get("JOINTS_%d" % k) is None or attributes.get("WEIGHTS_%d" % k) is None:
                raise Refused("set %d has joints or weights, not both" % k)
            ids, _ = self.document.stored(self.document.integer(attributes["JOINTS_%d" % k], "JOINTS"), ("VEC4",))
            weights = self.document.floats(self.document.integer(attributes["WEIGHTS_%d" % k], "WEIGHTS"), ("VEC4",))
            if len(ids) != len(positions) or len(weights) != len(positions):
                raise Refused("joints or weights of other than %d vertices" % len(positions))
            ids = ids.astype(np.int64)
            if ((ids >= len(matrices)) & (weights != 0)).any():
                raise Refused("a vertex is bound to a joint that the skin does not have")
            ids = np.minimum(ids, len(matrices) - 1)
            first = ids[:, 0] if first is None else first
            for c in range(4):
                total += weights[:, c, None, None] * matrices[ids[:, c]]
                absolute += np.abs(weights[:, c, None, None]) * joints[1][ids[:, c]]
                sums += weights[:, c]
        if (sums == 0).any():
            # The formula gives nothing: 0/0. Such a vertex follows its first joint, as in three.js and Blender.
            self.model.fault("a vertex has no weights")
            none = sums == 0
            total[none], absolute[none], sums[none] = matrices[first[none]], joints[1][first[none]], 1.0
        moved = np.einsum("vij,vj->vi", total[:, :3, :3], positions) + total[:, :3, 3]
        size = np.einsum("vij,vj->vi", absolute[:, :3, :3], extent) + absolute[:, :3, 3]
        return moved / sums[:, None], size / np.abs(sums)[:, None]

    def instances(self, node):
        """Transforms that EXT_mesh_gpu_instancing puts between the node and its mesh, or None without it."""
        extension = node.get("extensions", {}).get("EXT_mesh_gpu_instancing") if isinstance(node.get("extensions", {}), dict) else None
        if extension is None:
            return None
        attributes = extension.get("attributes", {})
        columns = {}
        for key, kind in (("TRANSLATION", "VEC3"), ("ROTATION", "VEC4"), ("SCALE", "VEC3")):
            if attributes.get(key) is not None:
                columns[key] = self.document.floats(self.document.integer(attributes[key], key), (kind,))
        others = [self.document.item("accessors", a).get("count") for key, a in attributes.items() if key not in columns]
        counts = {len(c) for c in columns.values()} | set(others)
        if len(counts) != 1:
            raise Refused("attributes of instances have %s elements" % " and ".join(map(str, sorted(counts))) or "no")
        count = counts.pop()
        moves = columns.get("TRANSLATION", np.zeros((count, 3)))
        turns = columns.get("ROTATION", np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)))
        scales = columns.get("SCALE", np.ones((count, 3)))
        return [from_trs(*row) for row in zip(moves, turns, scales)]


def topology(order, mode):
    """Triangles by [3.7.2.1]: p_i of strips is {v_i, v_i+(1+i%2), v_i+(2-i%2)}, of fans {v_i+1, v_i+2, v_0}."""
    if mode == TRIANGLES:
        return order[:len(order) // 3 * 3].reshape(-1, 3)
    i = np.arange(max(len(order) - 2, 0))
    if mode == STRIP:
        return np.stack([order[i], order[i + 1 + i % 2], order[i + 2 - i % 2]], axis=1)
    return np.stack([order[i + 1], order[i + 2], order[np.zeros_like(i)]], axis=1) if len(i) else np.empty((0, 3), np.int64)


def vector(values, length, what):
    if not isinstance(values, list) or len(values) != length:
        raise Refused("%s is not %d numbers" % (what, length))
    if any(isinstance(v, bool) or not isinstance(v, (int, float)) for v in values):
        raise Refused("%s is not %d numbers" % (what, length))
    try:
        out = np.array(values, dtype=np.float64)
    except OverflowError:
        raise Refused("%s is beyond f64" % what)
    if not np.isfinite(out).all():
        raise Refused("%s is not finite" % what)
    return out


def from_trs(move, turn, scale):
    """T * R * S [3.5.3]. The quaternion stands for a turn, so that its length is taken out."""
    length = np.linalg.norm(turn)
    x, y, z, w = turn / length if length > 0 else (0.0, 0.0, 0.0, 1.0)
    rotation = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ])
    matrix, magnitude = np.eye(4), np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation * scale, move
    # A turn's entries are sums of terms of at most 2.
    magnitude[:3, :3], magnitude[:3, 3] = 2.0 * np.abs(scale), np.abs(move)
    return matrix, magnitude
