#!/usr/bin/env python3
"""Write small models, one for each thing that readers get wrong, into a folder: corners.py DIR.

Nothing here says what is right: the second reader does, and `selftest.py` holds it against answers that were worked out by hand.
"""

import base64
import json
import os
import sys

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import corners_deformed  # noqa: E402
import corners_obj  # noqa: E402
from gltf_writer import TRIANGLE, Gltf  # noqa: E402

TURN = [0.18257418583505536, 0.3651483716701107, 0.5477225575051661, 0.7302967433402214]
HALF_TURN = [0.0, 0.7071067811865476, 0.0, 0.7071067811865476]


def one(**node):
    g = Gltf()
    return g.show(g.node(mesh=g.mesh(), **node))


def patch(g, at, size=2.0, cells=8):
    """A wavy square of triangles, first corner at `at`."""
    line = np.linspace(0.0, size, cells + 1)
    x, z = np.meshgrid(line, line)
    points = np.stack([x, 0.02 * np.sin(3 * x + 5 * z), z], axis=2).reshape(-1, 3) + at
    i = np.arange(cells * cells) // cells * (cells + 1) + np.arange(cells * cells) % cells
    faces = np.stack([i, i + 1, i + cells + 2, i, i + cells + 2, i + cells + 1], axis=1).reshape(-1)
    return g.primitive(points, faces)


def transforms():
    """Chains of nodes: every number of a node is a double, and so is their product."""
    g = Gltf()
    mesh, at = g.mesh(patch(g, [0.1, 0.2, 0.3])), None
    for i in range(14):
        at = g.node(translation=[0.1 + i, -7.3, 1.0 / 3], rotation=TURN, scale=[1.1, 0.9, 1.0 / 1.1], **({"mesh": mesh} if at is None else {"children": [at]}))
    yield "chain_trs", g.show(at)
    g, at = Gltf(), None
    mesh = g.mesh(patch(g, [0.1, 0.2, 0.3]))
    for i in range(6):
        matrix = [1.01, 0.1, -0.2, 0, 0.05, 0.99, 0.3, 0, 0.2, -0.1, 1.0 / 3, 0, 10.1, -0.7, 3.3, 1]
        at = g.node(matrix=matrix, **({"mesh": mesh} if at is None else {"children": [at]}))
    yield "chain_matrix", g.show(at)
    for name, node in {
        "mirrored": {"scale": [-1, 1, 1]}, "mirrored_matrix": {"matrix": [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1]},
        "scale_zero_one": {"scale": [1, 1, 0]}, "scale_zero_edge_on": {"scale": [0, 1, 1]}, "scale_zero_two": {"scale": [0, 0, 1]},
        "scale_zero_all": {"scale": [0, 0, 0]}, "beyond_f32": {"translation": [1e39, 0, 0]}, "largest_f32": {"scale": [3.4e38, 3.4e38, 3.4e38]},
        "smallest_f32": {"scale": [1e-44, 1e-44, 1e-44]}, "below_f32": {"scale": [1e-60, 1e-60, 1e-60]}, "third": {"translation": [1 / 3, 1e-9, -2e9]},
        "rotation_f32": {"rotation": [float(np.float32(x)) for x in TURN], "translation": [100.7, 0.3, -55.1]},
        "shear": {"matrix": [1, 0, 0, 0, 0.7, 1, 0, 0, 0.1, 0.2, 1, 0, 0, 0, 0, 1]},
    }.items():
        yield name, one(**node)
    g = Gltf()
    mesh = g.mesh()
    root = g.node(scale=[1, 2, 3], children=[g.node(mesh=mesh, rotation=TURN), g.node(mesh=mesh, rotation=HALF_TURN, translation=[5, 5, 5])])
    yield "shear_by_nodes", g.show(root)
    for copies in (1, 2):
        g = Gltf()
        mesh = g.mesh(patch(g, [0, 0, 0]))
        yield "far_%d" % copies, g.show(*(g.node(mesh=mesh, translation=[500123.25 + 7 * i, 102.5, -4649776.75]) for i in range(copies)))
    g = Gltf()
    mesh = g.mesh(patch(g, [400000.25, 90.5, -4649776.5]))
    yield "far_and_back", g.show(g.node(mesh=mesh, translation=[-400000.25, -90.5, 4649776.5]))
    # Of a shared mesh the file may put the origin elsewhere: here by less than the corners are rounded by, but on one axis.
    g = Gltf()
    mesh = g.mesh(g.primitive([[102713.4453125, -50760.56640625, -0.610138475894928], [102713.8125, -50760.26953125, -0.4935392439365387], [102713.546875, -50760.13671875, 0.5879867076873779]]))
    turns = ([-0.5082144532582895, -0.8050305139293337, -0.13110165231579324, 0.2765073197984453], [-0.01751228189536302, -0.6863430984535072, 0.5638012470331264, 0.4590801945542286],
             [0.3483804168518959, 0.9218135906807288, 0.08788845301960631, -0.14548680014427956])
    away = [-43788.178219082474, -113102.01476561176, -73236.71769340847]
    yield "shared_far_turned", g.show(*(g.node(mesh=mesh, rotation=turn) for turn in turns[:2]), g.node(mesh=mesh, rotation=turns[2], translation=away))
    g = Gltf()
    mesh = g.mesh(patch(g, [61926.5, -50108.5, 36743.25], 0.5, 3))
    yield "shared_far_back", g.show(*(g.node(mesh=mesh, rotation=turn, translation=[-61926.5 + i, 50108.5, -36743.25]) for i, turn in enumerate(turns)))


def accessors():
    """How positions and indices may be stored."""
    square = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.25], [2, 0, 0], [2, 1.5, 0], [3, 0, 1]]
    for kind in ("u1", "u2", "u4"):
        g = Gltf()
        yield "indices_" + kind, g.show(g.node(mesh=g.mesh(g.primitive(square, [0, 1, 2, 2, 1, 3, 4, 5, 1], kind=kind))))
    for name, mode in (("strip", 5), ("fan", 6)):
        for indices in (None, [6, 2, 3, 1, 0, 4, 4, 5]):
            g = Gltf()
            yield name + ("" if indices is None else "_indexed"), g.show(g.node(mesh=g.mesh(g.primitive(square, indices, mode))))
        g = Gltf()
        g.show(g.node(mesh=g.mesh(g.primitive(square, [0, 1, 2, 3, 255, 4, 255, 255, 6, 5, 1, 0, 2], mode, "u1"), g.primitive(square))))
        yield name + "_restarted", g
        yield name + "_restart_required", g.require("KHR_mesh_primitive_restart")
    g = Gltf()
    yield "not_indexed", g.show(g.node(mesh=g.mesh(g.primitive(square[:6]))))
    g = Gltf()
    yield "strided", g.show(g.node(mesh=g.mesh(g.primitive(g.accessor(square, stride=28, lead=8), [0, 1, 2, 2, 1, 3]))))
    g = Gltf()
    yield "sparse_alone", g.show(g.node(mesh=g.mesh(g.primitive(g.sparse(4, [1, 3], [[1, 0, 0], [0, 1, 0]], index="u1"), [0, 1, 3, 0, 1, 2]))))
    g = Gltf()
    yield "sparse_over", g.show(g.node(mesh=g.mesh(g.primitive(g.sparse(7, [0, 6], [[9, 9, 9], [-1, -1, -1]], square, "u4"), [0, 1, 2, 4, 5, 6]))))
    for kind, values in (("i1", [[-128, 127, 0], [-127, 1, 64], [13, -77, 5]]), ("u1", [[255, 0, 1], [254, 128, 3], [1, 7, 200]]),
                         ("i2", [[-32768, 32767, 0], [-32767, 1, 5000], [77, -9, 1234]]), ("u2", [[65535, 0, 1], [65534, 32768, 3], [1, 7, 60001]])):
        for normalized in (True, False):
            g = Gltf()
            mesh = g.mesh(g.primitive(g.accessor(values, kind, normalized)))
            yield "quantized_%s%s" % (kind, "_normalized" if normalized else ""), \
                g.show(g.node(mesh=mesh), g.node(mesh=mesh, rotation=TURN, scale=[0.37] * 3)).require("KHR_mesh_quantization")
    g = Gltf()
    flat = [[0, 0, 0], [1, 1, 1], [2, 2, 2], [1, 0, 0], [float("nan"), 0, 0], [0, float("inf"), 0], [1 + 2.0**-23, 1, 1]]
    yield "flat_and_not_finite", g.show(g.node(mesh=g.mesh(g.primitive(flat, [0, 1, 2, 0, 1, 3, 3, 3, 1, 0, 4, 3, 5, 1, 3, 0, 1, 6, 2, 1, 3])), rotation=TURN))


def scenes():
    """Which meshes are shown, and under which numbers."""
    g = Gltf()
    mesh = g.mesh(g.primitive(TRIANGLE, mode=0), g.primitive(), {"attributes": {}}, g.primitive([[5, 0, 0], [6, 0, 0], [5, 1, 0]], mode=1),
                  g.primitive([[0, 0, 1], [1, 0, 1], [0, 1, 1], [0, 0, 2], [1, 0, 2], [0, 1, 2]]))
    g.mesh()
    yield "parts_of_other_kinds", g.show(g.node(mesh=mesh), g.node(translation=[4, 0, 0], children=[g.node(mesh=mesh)]))
    g = Gltf()
    mesh = g.mesh()
    a, b = g.node(mesh=mesh, translation=[1, 0, 0]), g.node(mesh=mesh, translation=[2, 0, 0])
    g.root["scenes"] = [{"nodes": [a]}, {"nodes": [b]}]
    g.root["scene"] = 1
    yield "second_scene", g
    g = Gltf()
    g.node(mesh=g.mesh(), translation=[1, 0, 0])
    g.root["scenes"] = [{"nodes": [0]}]
    yield "no_default_scene", g
    columns = {
        "translation": {"TRANSLATION": ([[0, 0, 0], [5, 1 / 3, 0], [-5, 0, 0.1]], "f4", False)},
        "rotation_i16": {"ROTATION": ([[0, 0, 0, 32767], [0, 23170, 0, 23170], [5000, -6000, 7000, 30000]], "i2", True)},
        "rotation_i8": {"ROTATION": ([[0, 0, 0, 127], [0, 90, 0, 90], [-128, 0, 0, 0]], "i1", True)},
        "all": {"TRANSLATION": ([[0, 0, 0], [5, 0, 0], [0.1, 0.2, 0.3]], "f4", False), "ROTATION": ([HALF_TURN, TURN, TURN], "f4", False),
                "SCALE": ([[1, 1, 1], [2, 0.1, 3], [-1, 1, 1]], "f4", False)},
    }
    for name, attributes in columns.items():
        g = Gltf()
        attributes = {key: g.accessor(rows, kind, normalized) for key, (rows, kind, normalized) in attributes.items()}
        extension = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
        node = g.node(mesh=g.mesh(), rotation=TURN, translation=[10.1, 0, 0], extensions=extension)
        plain = g.node(mesh=0, translation=[0, 0, 9])
        yield "instances_" + name, g.show(node, plain).require("EXT_mesh_gpu_instancing")


def write_references(folder):
    """How a buffer may be named."""
    g = one(translation=[1, 2, 3])
    raw = bytes(g.data)
    os.makedirs(os.path.join(folder, "sub folder"), exist_ok=True)
    percent = "".join("%%%02X" % b for b in raw)
    encoded = base64.b64encode(raw).decode()
    references = {
        "data_percent": ("data:," + percent, None), "data_typed": ("data:application/gltf-buffer;base64," + encoded, None),
        "data_parameters": ("data:application/octet-stream;x=y;base64," + encoded, None), "data_no_type": ("data:;base64," + encoded, None),
        "data_upper": ("DATA:application/octet-stream;BASE64," + encoded, None), "data_escaped": ("data:;base64," + encoded.replace("=", "%3D").replace("/", "%2F"), None),
        "data_unpadded": ("data:;base64," + encoded.rstrip("="), None),
        "name_space": ("with%20space.bin", "with space.bin"), "name_raw_space": ("raw space.bin", "raw space.bin"), "name_hash": ("a%23b.bin", "a#b.bin"),
        "name_plus": ("a+b.bin", "a+b.bin"), "name_folder": ("sub%20folder/x.bin", "sub folder/x.bin"), "name_dot": ("./dot.bin", "dot.bin"),
        "name_dots": ("sub%20folder/.././/dots.bin", "dots.bin"), "name_dots_escaped": ("sub%20folder/%2E%2e/dots.bin", "dots.bin"),
        "name_dots_nowhere": ("nowhere/a/../../dots.bin", "dots.bin"), "name_dots_outside": ("sub%20folder/../../dots.bin", None),
        "name_unicode": ("%C3%A9.bin", "é.bin"), "name_raw_unicode": ("ü.bin", "ü.bin"), "name_mixed": ("Unicode%20❤.bin", "Unicode ❤.bin"),
        "name_backslash": ("sub folder\\back.bin", "sub folder/back.bin"), "name_percent_literal": ("50%.bin", "50%.bin"), "name_lost": ("lost.bin", None),
        "name_outside": ("../outside.bin", None), "name_http": ("https://example.com/x.bin", None), "data_no_comma": ("data:application/octet-stream;base64", None),
        "data_short": ("data:;base64," + encoded[:20], None),
        "data_fragment": ("data:;base64," + encoded + "#a/b?c", None), "data_fragment_early": ("data:;base64," + encoded[:20] + "#" + encoded[20:], None),
        "data_percent_fragment": ("data:," + percent + "#%41", None), "data_padded_too_much": ("data:;base64," + encoded + "===", None),
    }
    for name, (uri, file) in references.items():
        if file:
            with open(os.path.join(folder, *file.split("/")), "wb") as out:
                out.write(raw)
        g.save(os.path.join(folder, name + ".gltf"), uri)
    g.root.pop("buffers", None)
    g.save(os.path.join(folder, "binary.glb"))
    g.save_glb(os.path.join(folder, "binary_more_chunks.glb"), b"\4\0\0\0XTRA" + b"abcd")


def write_texts(folder):
    """What stands in and behind the JSON and places nothing: padding, and texts in another encoding."""
    g = one(translation=[1, 2, 3], name="NODE")
    g.root["asset"]["generator"], g.root["extras"] = "GENERATOR", {"KEY": None}
    path = os.path.join(folder, "plain.gltf")
    g.save(path)
    with open(path, "rb") as file:
        text = file.read()
    texts = {
        "padded_spaces": text + b" \t\r\n ", "padded_zeros": text + b"\0" * 7, "padded_sign": text + b"\r\n\x1a", "not_padding": text + b"\0x",
        "latin_generator": text.replace(b"GENERATOR", b"caf\xe9"), "latin_key": text.replace(b"KEY", b"\xfc"), "latin_node": text.replace(b"NODE", b"\xe9"),
        "half_a_pair": text.replace(b"NODE", b"\\ud800"), "whole_pair": text.replace(b"NODE", b"\\ud83d\\ude00"),
    }
    for name, changed in texts.items():
        with open(os.path.join(folder, "text_%s.gltf" % name), "wb") as out:
            out.write(changed)
    g.root.pop("buffers", None)
    for name, pad, tail in (("zeros", b"\0" * 5, b""), ("tail", b" ", b"\0" * 6), ("tail_spaces", b" ", b" " * 9)):
        g.save_glb(os.path.join(folder, "text_padded_%s.glb" % name), pad=pad, tail=tail)


def write_nothings(folder):
    """Properties that are null, lists that are empty, and values of another type: the schema of glTF has none of them."""
    g = Gltf()
    attributes = {"JOINTS_0": g.accessor([[0, 0, 0, 0]] * 3, "u1"), "WEIGHTS_0": g.accessor([[1, 0, 0, 0]] * 3)}
    mesh = g.mesh(g.primitive(TRIANGLE, [0, 1, 2], attributes=attributes, targets=[{"POSITION": g.accessor([[1, 0, 0]] * 3)}]), weights=[0.5])
    g.root["skins"] = [{"joints": [1]}]
    g.show(g.node(mesh=mesh, skin=0), g.node(translation=[1, 2, 3]), g.node(mesh=mesh, translation=[0, 0, 9]))
    places = {
        "": ("scene", "animations", "materials", "extensionsUsed", "extensionsRequired", "extensions", "extras"), "asset": ("minVersion", "generator"),
        "nodes 1": ("mesh", "skin", "children", "matrix", "rotation", "scale", "extensions", "name"), "nodes 2": ("weights", "skin"),
        "meshes 0": ("weights", "name"), "meshes 0 primitives 0": ("indices", "mode", "material", "targets"), "skins 0": ("skeleton", "inverseBindMatrices"),
        "accessors 0": ("sparse", "byteOffset", "normalized"), "bufferViews 0": ("byteStride", "byteOffset"),
    }
    for place, keys in places.items():
        for key in keys:
            for name, value in (("null", None), ("empty", []), ("five", 5)):
                root = json.loads(json.dumps(g.document()))
                root["buffers"][0]["uri"] = "data:;base64," + base64.b64encode(g.data).decode()
                item = root
                for step in place.split():
                    item = item[int(step) if step.isdigit() else step]
                item[key] = value
                with open(os.path.join(folder, "%s_%s.gltf" % (name, "_".join((place + " " + key).split()))), "w") as out:
                    json.dump(root, out)


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    folder = sys.argv[1]
    os.makedirs(folder, exist_ok=True)
    for group in (transforms, accessors, scenes, corners_deformed.models):
        for name, g in group():
            g.save(os.path.join(folder, name + ".gltf"))
    write_references(folder)
    write_texts(folder)
    write_nothings(folder)
    corners_obj.write(folder)
    print("%d models in %s" % (sum(f.endswith((".gltf", ".glb", ".obj")) for f in os.listdir(folder)), folder))
    return 0


if __name__ == "__main__":
    sys.exit(main())
