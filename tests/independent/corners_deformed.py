"""Small models with skins and morph targets at rest. See `corners`."""

import numpy as np

from gltf_writer import TRIANGLE, Gltf

TURN = [0.18257418583505536, 0.3651483716701107, 0.5477225575051661, 0.7302967433402214]
QUAD, FACES = [[-1, 0, 0], [1, 0, 0], [-1, 2, 0], [1, 2, 0]], [0, 1, 2, 2, 1, 3]


def moved(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def binds(g, *matrices):
    """Columns first, as glTF stores matrices."""
    return g.accessor(np.array([m.T.reshape(-1) for m in matrices]))


def strip(g, joints, weights, kind="u1", weight_kind="f4", **more):
    attributes = {"JOINTS_0": g.accessor(joints, kind), "WEIGHTS_0": g.accessor(weights, weight_kind, weight_kind != "f4"), **more}
    return g.primitive(QUAD, FACES, attributes=attributes)


HALF_BENT = [[0, 0, 0, 0], [0, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0]]
ONE = [[1, 0, 0, 0], [1, 0, 0, 0], [0.25, 0.75, 0, 0], [1, 0, 0, 0]]


def skeleton(g, inverse=True, **root):
    """Two joints, the second a bent one: (skin, root node)."""
    tip = g.node(translation=[0, 1, 0], rotation=TURN)
    base = g.node(translation=[0.1, 0, 0.3], children=[tip])
    top = g.node(children=[base], **root)
    skin = {"joints": [base, tip]}
    if inverse:
        skin["inverseBindMatrices"] = binds(g, moved(-0.1, 0, -0.3), moved(-0.1, -1, -0.3))
    g.root.setdefault("skins", []).append(skin)
    return len(g.root["skins"]) - 1, top


def skinned(joints=HALF_BENT, weights=ONE, node=None, inverse=True, root=None, **how):
    g = Gltf()
    skin, top = skeleton(g, inverse, **(root or {}))
    body = g.node(mesh=g.mesh(strip(g, joints, weights, **how)), skin=skin, **(node or {}))
    return g.show(top, body)


def models():
    yield from skins()
    yield from morphs()


def skins():
    yield "skin", skinned()
    yield "skin_node_moved", skinned(node={"translation": [9, 9, 9], "scale": [3, 3, 3]})
    yield "skin_above_root", skinned(root={"scale": [0.01, 0.02, 0.03], "rotation": TURN})
    yield "skin_no_binds", skinned(inverse=False)
    yield "skin_weights_u8", skinned(weights=[[255, 0, 0, 0], [255, 0, 0, 0], [64, 191, 0, 0], [255, 0, 0, 0]], weight_kind="u1")
    yield "skin_weights_u16", skinned(weights=[[65535, 0, 0, 0], [65535, 0, 0, 0], [16384, 49151, 0, 0], [65535, 0, 0, 0]], weight_kind="u2", kind="u2")
    yield "skin_weights_half", skinned(weights=[[0.5, 0, 0, 0], [0.5, 0, 0, 0], [0.2, 0.1, 0, 0], [0.3, 0, 0, 0]])
    yield "skin_weights_none", skinned(weights=[[0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]])
    yield "skin_unused_joint", skinned(joints=[[0, 200, 0, 0], [0, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0]])
    g = Gltf()
    skin, top = skeleton(g)
    more = {"JOINTS_1": g.accessor([[1, 0, 0, 0]] * 4, "u2"), "WEIGHTS_1": g.accessor([[0.5, 0, 0, 0]] * 4)}
    half = [[0.5, 0, 0, 0], [0.25, 0.25, 0, 0], [0.5, 0, 0, 0], [0.5, 0, 0, 0]]
    yield "skin_two_sets", g.show(top, g.node(mesh=g.mesh(strip(g, HALF_BENT, half, **more)), skin=skin))
    g = Gltf()
    (first, top), (second, other) = skeleton(g), skeleton(g, translation=[5, 0, 0], rotation=TURN)
    mesh = g.mesh(strip(g, HALF_BENT, ONE))
    yield "skin_two_skins_one_mesh", g.show(top, other, g.node(mesh=mesh, skin=first), g.node(mesh=mesh, skin=second))
    g = Gltf()
    skin, top = skeleton(g)
    mesh, plain = g.mesh(strip(g, HALF_BENT, ONE)), g.mesh()
    yield "skin_shared", g.show(top, g.node(mesh=mesh, skin=skin), g.node(mesh=mesh, skin=skin, translation=[4, 0, 0]), g.node(mesh=mesh, translation=[7, 0, 0]), g.node(mesh=plain, translation=[0, 0, 3]))
    g = Gltf()
    mesh = g.mesh(strip(g, [[0, 0, 0, 0]] * 4, [[1, 0, 0, 0]] * 4))
    node = g.node(mesh=mesh, skin=0, translation=[1, 2, 3], rotation=TURN)
    g.root["skins"] = [{"joints": [node], "inverseBindMatrices": binds(g, np.diag([2.0, 2.0, 2.0, 1.0]))}]
    yield "skin_is_its_own_joint", g.show(node)
    g = Gltf()
    skin, top = skeleton(g)
    body = strip(g, HALF_BENT, ONE)
    body["targets"] = [{"POSITION": g.accessor([[0, 0, 1], [0, 0, 2], [0.1, 0.2, 0.3], [0, 0, 0]])}]
    yield "skin_and_morph", g.show(top, g.node(mesh=g.mesh(body, weights=[0.7]), skin=skin))
    g = Gltf()
    skin, top = skeleton(g)
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": g.accessor([[0, 0, 0], [3, 0, 0]])}}}
    yield "skin_instances", g.show(top, g.node(mesh=g.mesh(strip(g, HALF_BENT, ONE)), skin=skin, extensions=extension)).require("EXT_mesh_gpu_instancing")
    g = Gltf()
    skin, top = skeleton(g, scale=[1, 1, 0])
    yield "skin_flattened", g.show(top, g.node(mesh=g.mesh(strip(g, HALF_BENT, ONE)), skin=skin))


def morphs():
    up, out = [[0, 0, 1], [0, 0, 2], [0, 0, 0.1]], [[1, 0, 0], [0, 1 / 3, 0], [0, 0, 0]]

    def body(g, *targets):
        return g.primitive(TRIANGLE, targets=[{"POSITION": t if isinstance(t, int) else g.accessor(t)} for t in targets])

    g = Gltf()
    mesh = g.mesh(body(g, up, out), weights=[0.5, 0.1])
    nodes = [g.node(mesh=mesh, weights=[0.25, 2.0]), g.node(mesh=mesh, translation=[5, 0, 0]), g.node(mesh=mesh, weights=[0, 0], rotation=TURN), g.node(mesh=mesh, translation=[0, 0, 8])]
    yield "morph_weights", g.show(*nodes)
    g = Gltf()
    yield "morph_no_weights", g.show(g.node(mesh=g.mesh(body(g, up, out))))
    g = Gltf()
    yield "morph_sparse", g.show(g.node(mesh=g.mesh(body(g, g.sparse(3, [1], [[0, 5, 0]]), g.accessor(np.zeros((3, 3)), bare=True)), weights=[0.3, 1])))
    g = Gltf()
    yield "morph_quantized", g.show(g.node(mesh=g.mesh(body(g, g.accessor([[127, -128, 3], [0, 64, 0], [0, 0, 0]], "i1", True)), weights=[1]))).require("KHR_mesh_quantization")
    g = Gltf()
    first = body(g, up)
    first["targets"].append({"NORMAL": g.accessor(out)})
    yield "morph_target_without_position", g.show(g.node(mesh=g.mesh(first, weights=[0.5, 1])))
    g = Gltf()
    yield "morph_two_primitives", g.show(g.node(mesh=g.mesh(body(g, up), body(g, out), weights=[-0.5]), scale=[1, 2, 3]))
    g = Gltf()
    mesh = g.mesh(body(g, [[0, 0, 0], [-1, 0, 0], [0, -1, 0]]), g.primitive(), weights=[1])
    g.root["meshes"][mesh]["primitives"][1]["targets"] = [{"POSITION": g.accessor([[0, 0, 1]] * 3)}]
    yield "morph_flattened_in_two_places", g.show(g.node(mesh=mesh), g.node(mesh=mesh, translation=[0, 0, 5]), g.node(mesh=mesh, weights=[0.5]))
    g = Gltf()
    yield "morph_flattened", g.show(g.node(mesh=g.mesh(body(g, [[0, 0, 0], [-1, 0, 0], [0, -1, 0]]), weights=[1])), g.node(mesh=0, weights=[0]))
    g = Gltf()
    extension = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": g.accessor([[0, 0, 0], [3, 0, 0]])}}}
    yield "morph_instances", g.show(g.node(mesh=g.mesh(body(g, up), weights=[1]), rotation=TURN, extensions=extension)).require("EXT_mesh_gpu_instancing")
