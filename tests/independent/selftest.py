#!/usr/bin/env python3
"""The second reader against answers worked out by hand from the specifications, and the comparison against faults that are planted."""

import base64
import json
import os
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import gltf_scene  # noqa: E402
import obj_model  # noqa: E402
from arithmetic import half_ulp, rounded, without_area  # noqa: E402
from cache import Body, Shown  # noqa: E402
from compare import Comparison, stored_name, transform  # noqa: E402
from gltf_writer import TRIANGLE, Gltf  # noqa: E402
from model import NO_NODE, Refused, Unsupported  # noqa: E402

QUARTER = [0.0, 0.0, 0.7071067811865476, 0.7071067811865476]  # a quarter turn about z: x becomes y
QUARTER_MATRIX = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])


def read(g, moment=None):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "m.gltf")
        g.save(path)
        return gltf_scene.read(path, moment)


def world(model):
    """{(mesh, part, node, copy): [triangles]} rounded to 12 digits."""
    return {
        (p.mesh, part.number, p.node, p.copy): np.round(transform(p.matrix, part.positions[part.corners]), 12).tolist()
        for p in model.placements for part in p.parts
    }


class GltfByHand(unittest.TestCase):
    def shows(self, g, expected, moment=None):
        self.assertEqual(world(read(g, moment)), {key: [[list(map(float, c)) for c in t] for t in tris] for key, tris in expected.items()})

    def test_translation_rotation_scale_in_this_order(self):
        g = Gltf()
        node = g.node(mesh=g.mesh(), translation=[10, 0, 0], rotation=QUARTER, scale=[2, 3, 1])
        self.shows(g.show(g.node(translation=[0, 0, 5], children=[node])), {(0, 0, 0, 0): [[(10, 0, 5), (10, 2, 5), (7, 0, 5)]]})

    def test_matrix_columns_first(self):
        g = Gltf()
        g.show(g.node(mesh=g.mesh(), matrix=[0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1]))
        self.shows(g, {(0, 0, 0, 0): [[(7, 8, 9), (7, 9, 9), (6, 8, 9)]]})

    def test_the_node_of_a_skinned_mesh_does_not_place_it(self):
        # Joint at (0, 1, 0) times 0.5; inverse bind scales by 2: p -> p + (0, 0.5, 0).
        g = Gltf()
        attributes = {"JOINTS_0": g.accessor([[0, 0, 0, 0]] * 3, "u1"), "WEIGHTS_0": g.accessor([[1, 0, 0, 0]] * 3)}
        body = g.node(mesh=g.mesh(g.primitive(attributes=attributes)), skin=0, translation=[5, 5, 5])
        joint = g.node(translation=[0, 1, 0])
        g.root["skins"] = [{"joints": [joint], "inverseBindMatrices": g.accessor([[2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]])}]
        self.shows(g.show(g.node(scale=[0.5] * 3, children=[body, joint])), {(0, 0, 0, 0): [[(0, 0.5, 0), (1, 0.5, 0), (0, 1.5, 0)]]})

    def test_weights_are_divided_by_their_sum_and_all_sets_count(self):
        # Joints at x = 0 and at x = 8; the weights 0.25 and (in the second set) 0.25 put each vertex halfway.
        g = Gltf()
        attributes = {
            "JOINTS_0": g.accessor([[0, 0, 0, 0]] * 3, "u2"), "WEIGHTS_0": g.accessor([[0.25, 0, 0, 0]] * 3),
            "JOINTS_1": g.accessor([[1, 0, 0, 0]] * 3, "u1"), "WEIGHTS_1": g.accessor([[0.25, 0, 0, 0]] * 3),
        }
        body = g.node(mesh=g.mesh(g.primitive(attributes=attributes)), skin=0)
        joints = [g.node(), g.node(translation=[8, 0, 0])]
        g.root["skins"] = [{"joints": joints}]
        self.shows(g.show(body, *joints), {(0, 0, 0, 0): [[(4, 0, 0), (5, 0, 0), (4, 1, 0)]]})

    def test_weights_of_the_node_go_before_those_of_the_mesh(self):
        g = Gltf()
        body = g.primitive(targets=[{"POSITION": g.accessor([[0, 0, 8]] * 3)}, {"POSITION": g.sparse(3, [1], [[4, 0, 0]])}])
        mesh = g.mesh(body, weights=[0.5, 0])
        g.show(g.node(mesh=mesh), g.node(mesh=mesh, weights=[0.25, 1], translation=[0, 1, 0]))
        self.shows(g, {(0, 0, 0, 0): [[(0, 0, 4), (1, 0, 4), (0, 1, 4)]], (0, 0, 1, 0): [[(0, 1, 2), (5, 1, 2), (0, 2, 2)]]})

    def test_morph_before_skin(self):
        g = Gltf()
        attributes = {"JOINTS_0": g.accessor([[0, 0, 0, 0]] * 3, "u1"), "WEIGHTS_0": g.accessor([[1, 0, 0, 0]] * 3)}
        mesh = g.mesh(g.primitive(attributes=attributes, targets=[{"POSITION": g.accessor([[1, 0, 0]] * 3)}]), weights=[2])
        g.root["skins"] = [{"joints": [1]}]
        self.shows(g.show(g.node(mesh=mesh, skin=0), g.node(rotation=QUARTER)), {(0, 0, 0, 0): [[(0, 2, 0), (0, 3, 0), (-1, 2, 0)]]})

    def test_animations_by_each_interpolation(self):
        def moved(path, interpolation, times, values, kind="f4"):
            g = Gltf()
            g.show(g.node(mesh=g.mesh(), translation=[9, 9, 9]))
            sampler = {"input": g.accessor(times), "output": g.accessor(values, kind), "interpolation": interpolation}
            g.root["animations"] = [{"channels": [{"sampler": 0, "target": {"node": 0, "path": path}}], "samplers": [sampler]}]
            return g

        def at(x, y, z):
            return {(0, 0, 0, 0): [[(x, y, z), (x + 1, y, z), (x, y + 1, z)]]}
        steps = moved("translation", "STEP", [1, 2], [[1, 2, 3], [4, 5, 6]])
        for time, place in ((0, (1, 2, 3)), (1.5, (1, 2, 3)), (2, (4, 5, 6)), (9, (4, 5, 6))):
            self.shows(steps, at(*place), (0, time))
        self.shows(moved("translation", "LINEAR", [1, 3], [[0, 0, 0], [4, 0, 0]]), at(3, 0, 0), (0, 2.5))
        # x = t^3 from 1 s to 3 s, where its tangents are 3 and 27 a second.
        spline = [[0, 0, 0], [1, 0, 0], [3, 0, 0], [27, 0, 0], [27, 0, 0], [0, 0, 0]]
        self.shows(moved("translation", "CUBICSPLINE", [1, 3], spline), at(8, 0, 0), (0, 2))
        # Half of half a turn, as integers: x becomes y.
        turn = moved("rotation", "LINEAR", [0, 1], [[0, 0, 0, 127], [0, 0, 127, 0]], "i1")
        self.shows(turn, {(0, 0, 0, 0): [[(9, 9, 9), (9, 10, 9), (8, 9, 9)]]}, (0, 0.5))
        with self.assertRaises(Refused):
            read(turn, (1, 0.5))

    def test_instances_stand_between_node_and_mesh(self):
        g = Gltf()
        attributes = {"TRANSLATION": g.accessor([[1, 0, 0], [2, 0, 0]]), "ROTATION": g.accessor([[0, 0, 0, 127], [0, 0, 127, 0]], "i1", True)}
        g.show(g.node(mesh=g.mesh(), scale=[10, 10, 10], extensions={"EXT_mesh_gpu_instancing": {"attributes": attributes}}))
        self.shows(g, {(0, 0, 0, 0): [[(10, 0, 0), (20, 0, 0), (10, 10, 0)]], (0, 0, 0, 1): [[(20, 0, 0), (10, 0, 0), (20, -10, 0)]]})

    def test_strips_and_fans(self):
        corners = [[i, i * i, 0] for i in range(5)]
        for mode, wanted in ((5, [(0, 1, 2), (1, 3, 2), (2, 3, 4)]), (6, [(1, 2, 0), (2, 3, 0), (3, 4, 0)])):
            g = Gltf()
            g.show(g.node(mesh=g.mesh(g.primitive(corners, mode=mode))))
            self.shows(g, {(0, 0, 0, 0): [[corners[i] for i in t] for t in wanted]})

    def test_the_largest_index_begins_a_new_strip(self):
        g = Gltf()
        corners = [[i, i * i, 0] for i in range(4)]
        g.show(g.node(mesh=g.mesh(g.primitive(corners, [0, 1, 2, 255, 3, 2, 1, 0], 5, "u1"))))
        self.shows(g, {(0, 0, 0, 0): [[corners[i] for i in t] for t in ((0, 1, 2), (3, 2, 1), (2, 0, 1))]})

    def test_normalised_integers(self):
        for kind, values, wanted in (("i1", [[-128, 127, 0]], (-1, 1, 0)), ("u1", [[255, 0, 51]], (1, 0, 0.2)), ("i2", [[-32768, 32767, 0]], (-1, 1, 0)), ("u2", [[65535, 0, 13107]], (1, 0, 0.2))):
            g = Gltf()
            mesh = g.mesh(g.primitive(g.accessor(values * 3, kind, True)))
            self.shows(g.show(g.node(mesh=mesh)), {(0, 0, 0, 0): [[wanted] * 3]})

    def test_parts_and_triangles_are_numbered_over_all_primitives(self):
        g = Gltf()
        mesh = g.mesh(g.primitive(TRIANGLE * 2), g.primitive(mode=0), g.primitive(TRIANGLE))
        model = read(g.show(g.node(mesh=mesh)))
        self.assertEqual([(p.number, p.first_prim, len(p)) for p in model.placements[0].parts], [(0, 0, 2), (2, 2, 1)])

    def test_the_named_scene_is_shown(self):
        g = Gltf()
        g.show(g.node(mesh=g.mesh(), translation=[1, 0, 0]))
        g.root["scenes"].append({"nodes": [g.node(mesh=0, translation=[2, 0, 0])]})
        g.root["scene"] = 1
        self.assertEqual(list(world(read(g))), [(0, 0, 1, 0)])

    def test_refusals(self):
        def broken(change):
            g = Gltf()
            g.show(g.node(mesh=g.mesh(g.primitive(TRIANGLE, [0, 1, 2]))))
            change(g)
            return g

        for change in (
            lambda g: g.require("CESIUM_RTC"), lambda g: g.root["asset"].update(version="1.0"), lambda g: g.root["asset"].update(minVersion="2.1"),
        ):
            self.assertRaises(Unsupported, read, broken(change))
        for change in (
            lambda g: g.root["nodes"][0].update(mesh=7), lambda g: g.root["nodes"][0].update(children=[0]), lambda g: g.root["accessors"][0].update(count=2),
            lambda g: g.root["bufferViews"][0].update(byteLength=20), lambda g: g.root["nodes"][0].update(matrix=[1] * 16), lambda g: g.root.update(scene=1),
        ):
            self.assertRaises(Refused, read, broken(change))


class Documents(unittest.TestCase):
    """What may stand around the triangles of a glTF file: texts, padding, references."""

    def read(self, change_text=lambda text: text, uri=None, **root):
        g = Gltf(**root)
        g.show(g.node(mesh=g.mesh(), name="NAME"))
        with tempfile.TemporaryDirectory() as folder:
            os.mkdir(os.path.join(folder, "m"))
            path = os.path.join(folder, "m", "m.gltf")
            for place in (folder, os.path.join(folder, "m")):
                with open(os.path.join(place, "t.bin"), "wb") as file:
                    file.write(bytes(g.data))
            g.save(path, uri.replace("DATA", base64.b64encode(g.data).decode()) if uri else None)
            with open(path, "rb") as file:
                text = file.read()
            with open(path, "wb") as file:
                file.write(change_text(text))
            model = gltf_scene.read(path)
        self.assertEqual(list(world(model).values()), [[[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]])
        return bool(model.faults)

    def test_padding_and_other_encodings_place_nothing(self):
        for behind, is_fault in ((b" \n\t\r", False), (b"\0\0", True), (b" \0 ", True), (b"\r\n\x1a", True)):
            self.assertEqual(self.read(lambda text: text + behind), is_fault, behind)
        self.assertRaises(Refused, self.read, lambda text: text + b"\0x")
        for name, is_fault in ((b"caf\xe9", True), ("é".encode(), False), (b"\\ud800", True), (b"\\ud83d\\ude00", False)):
            self.assertEqual(self.read(lambda text: text.replace(b"NAME", name)), is_fault, name)

    def test_references(self):
        for uri in ("t.bin", "./t.bin", "x/../t.bin", "x/y/.././../t.bin", "x/%2E%2e/t.bin", "t.bin?v=1#f", "x\\..\\t.bin", "data:;base64,DATA", "data:;base64,DATA#x="):
            self.assertFalse(self.read(uri=uri), uri)
        for uri in ("../t.bin", "x/../../t.bin", "x/../../m/t.bin", "%2e%2e/t.bin", "x\\..\\..\\t.bin", "/t.bin", "data:;base64,#DATA"):
            self.assertRaises(Refused, self.read, uri=uri)

    def test_what_is_null_or_empty_is_not_there_and_a_fault(self):
        def put(**members):
            return lambda text: text.replace(b'"name": "NAME"', json.dumps(members)[1:-1].encode())
        for key in ("matrix", "translation", "children", "weights", "skin", "name", "extensions"):
            self.assertTrue(self.read(put(**{key: None})), key)
        for key in ("matrix", "translation", "children", "weights"):
            self.assertTrue(self.read(put(**{key: []})), key)
        for members in ({"name": 5}, {"camera": "x"}, {"camera": -1}, {"camera": 1.5}, {"extensions": 7}):
            self.assertTrue(self.read(put(**members)), members)
        self.assertRaises(Refused, self.read, put(children=7))
        self.assertFalse(self.read(put(extras={"a": None, "b": []})))

    def test_a_list_of_weights_that_is_empty_leaves_those_of_the_mesh(self):
        for weights in ({"weights": []}, {"weights": None}):
            g = Gltf()
            mesh = g.mesh(g.primitive(targets=[{"POSITION": g.accessor([[0, 0, 8]] * 3)}]), weights=[0.5])
            model = read(g.show(g.node(mesh=mesh, **weights)))
            self.assertEqual(list(world(model).values()), [[[[0, 0, 4], [1, 0, 4], [0, 1, 4]]]])
            self.assertEqual(len(model.faults), 1)


class ObjByHand(unittest.TestCase):
    def triangles(self, text):
        model = obj_model.read(text)
        return [(part.number, part.positions[c].tolist()) for part in model.placements[0].parts for c in part.corners]

    def test_indices_count_from_either_end(self):
        self.assertEqual(self.triangles(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2/-1 3//1\nv 9 9 9\nf 1 2 -1"),
                         [(0, [[0, 0, 0], [1, 0, 0], [0, 1, 0]]), (0, [[0, 0, 0], [1, 0, 0], [9, 9, 9]])])

    def test_lines_go_on_and_end(self):
        self.assertEqual(self.triangles(b"v 0 0 \\\n0 # one\r\nv 1 0 0\rv\t0 1 0 5\r\nf 1 \\\r\n2 3\0\0"), [(0, [[0, 0, 0], [1, 0, 0], [0, 1, 0]])])

    def test_parts_are_runs_of_object_group_and_material(self):
        text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + b"f 1 2 3\n".join([b"o a\n", b"g x\n", b"g x\nusemtl m\n", b"g x\n", b"o a\n", b"g y\n", b"g x\n", b""])
        self.assertEqual([number for number, _ in self.triangles(text)], [0, 1, 2, 2, 3, 4, 5])

    def test_numbers_are_doubles(self):
        self.assertEqual(self.triangles(b"v 4649776.75 1e-300 0.1\nv 1.#IND 0 0\nv 0 0 0\nf 1 3 3")[0][1][0], [4649776.75, 1e-300, 0.1])

    def test_a_backslash_joins_lines_and_may_be_the_last_sign(self):
        corner = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
        for text in (b"f 1 2 3\\", b"f 1 2 3 \\ \t", b"f 1 2 3\\\n", b"f 1 2 3\\\0\0", b"f 1 2\\ \r\n3", b"\\\nf 1 2 3", b"# C:\\\nf 1 2 3", b"f 1 2 \\\n3 # 1 \\\n# 2"):
            self.assertEqual(self.triangles(b"v 0 0 0\nv 1 0 0\nv 0 1 0\n" + text), [(0, corner)], text)
        self.assertRaises(Refused, obj_model.read, b"v 0 0 0\nf 1 1 1\\\\\n")

    def test_numbers_beyond_f64_are_numbers(self):
        corners = self.triangles(b"v 1e400 -1e999 inf\nv -nan(ind) 0 0\nv 0 0 0\nf 1 2 3")[0][1]
        self.assertEqual(corners[0], [sys.float_info.max, -sys.float_info.max, float("inf")])
        self.assertTrue(np.isnan(corners[1][0]))

    def test_refusals(self):
        for text in (b"v 0 0 0\nf 1 1 99999999999999999999", b"f 0 1 2\nv 0 0 0", b"v 0 0 0\nf -2 1 1", b"v 0 0 0\nf 1 1 2", b"v 0 0\nf 1 1 1", b"V 0 0 0", b"<html>", b"v 0 0 0\0\nf 1 1 1", b"v 0 0 x\nf 1 1 1"):
            self.assertRaises(Refused, obj_model.read, text)


class FakeCache:
    """What a right cache of a model would hold."""

    def __init__(self, model, two_level, drop=()):
        self.read_counts, self.options, self.places = {}, {"degenerate": "drop"}, []
        for p in model.placements:
            for part in p.parts:
                rows = np.array([i for i in range(len(part)) if i not in drop], dtype=np.int64)
                local = part.positions[part.corners[rows]]
                corners = rounded(local if two_level else transform(p.matrix, local))
                body = Body(p.mesh, part.number, p.node, 0, part.first_prim, len(part), part.name if isinstance(part.name, bytes) else stored_name(*part.name), rows + part.first_prim, corners)
                self.places.append(Shown(body, p.node, rounded(p.matrix[:3]).astype(np.float64) if two_level else None))

    def shown(self):
        return self.places


class Counts(unittest.TestCase):
    def kinds(self, model, drop, **counts):
        cache = FakeCache(model, False, drop=drop)
        cache.read_counts.update({key + "_triangles": count for key, count in counts.items()})
        for shown in cache.places:
            shown.body.corners = shown.body.corners[np.isfinite(shown.body.corners).all(axis=(1, 2))]
        return {d["kind"] for d in Comparison(model, cache).run().differences}

    def test_a_number_beyond_f64_is_out_of_range_and_an_infinity_is_no_number(self):
        for number, reason, other in ((b"1e400", "out_of_range", "non_finite"), (b"-inf", "non_finite", "out_of_range")):
            model = obj_model.read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv %s 0 0\nf 1 2 3\nf 1 2 4\n" % number)
            self.assertEqual(self.kinds(model, [1], **{reason: 1}), set())
            self.assertEqual(self.kinds(model, [1], **{other: 1}), {"count"})

    def test_the_cut_of_a_polygon_decides_how_many_triangles_have_its_corner_beyond_f32(self):
        model = obj_model.read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 1e39 0 0\nf 1 2 3\nf 1 2 3 4\n")
        for counts, wanted in (({"out_of_range": 2}, set()), ({"out_of_range": 1, "degenerate": 1}, set()), ({"out_of_range": 3}, {"count"})):
            self.assertEqual(self.kinds(model, [1, 2], **counts), wanted)

    def test_one_pose_of_two_nodes_counts_once_or_twice(self):
        def model(second):
            g = Gltf()
            mesh = g.mesh(g.primitive(TRIANGLE * 2, [0, 1, 2, 3, 3, 4], targets=[{"POSITION": g.accessor([[0, 0, 1]] * 6)}]), weights=[1])
            return read(g.show(g.node(mesh=mesh), g.node(mesh=mesh, translation=[1, 2, 3], weights=[second])))
        for second, told, wanted in ((1, 1, set()), (1, 2, set()), (1, 3, {"count"}), (0.5, 1, {"count"}), (0.5, 2, set())):
            self.assertEqual(self.kinds(model(second), [1], degenerate=told), wanted, (second, told))


class PlantedFaults(unittest.TestCase):
    def model(self):
        g = Gltf()
        flat = [[0, 0, 0], [1, 1, 1], [2, 2, 2]]
        mesh = g.mesh(g.primitive(TRIANGLE + [[0.1, 0.2, 5.3], [1.7, 0.2, 5.1], [0, 3.3, 5]] + flat))
        return read(g.show(g.node(mesh=mesh, rotation=[0.1825741858, 0.3651483717, 0.5477225575, 0.7302967433], translation=[7.7, 0.1, -3.3])))

    def kinds(self, change=None, two_level=False, count=1):
        model = self.model()
        cache = FakeCache(model, two_level, drop=[2])
        cache.read_counts["degenerate_triangles"] = count
        if change:
            change(cache.places[0])
        return {d["kind"] for d in Comparison(model, cache).run().differences}

    def test_a_right_cache_agrees(self):
        for two_level in (False, True):
            self.assertEqual(self.kinds(two_level=two_level), set())

    def test_one_unit_in_the_last_place_is_found(self):
        for corner in np.ndindex(2, 3, 3):
            def shift(shown):
                shown.body.corners[corner] = np.nextafter(shown.body.corners[corner], np.float32(np.inf))
            self.assertEqual(self.kinds(shift), {"position"})

        def matrix(shown):
            shown.matrix[1, 3] *= 1 + 2.0**-23
        self.assertEqual(self.kinds(matrix, True), {"matrix"})

    def test_an_origin_elsewhere_agrees_and_a_wrong_one_does_not(self):
        for error, wanted in ((0.0, set()), (1e-5, {"position"})):
            def move(shown):
                origin = np.array([100.25, -3.5, 7.0])
                local = shown.body.corners.astype(np.float64)
                shown.body.corners = rounded(transform(np.vstack([shown.matrix, [0, 0, 0, 1]]), local) - origin + error)
                shown.matrix = np.column_stack([np.eye(3), origin])
            model = self.model()
            model.placements[0].matrix[:3] = rounded(model.placements[0].matrix[:3])
            cache = FakeCache(model, True, drop=[2])
            cache.read_counts["degenerate_triangles"] = 1
            move(cache.places[0])
            self.assertEqual({d["kind"] for d in Comparison(model, cache).run().differences}, wanted)

    def test_two_units_in_the_last_place_are_found_beside_a_far_origin(self):
        origin = np.float32([4649776.5, -500123.25, 102.5])
        for corner in np.ndindex(2, 3, 3):
            for units in (0, 2):
                model = self.model()
                model.placements[0].matrix[:3, 3] += origin
                cache = FakeCache(model, True, drop=[2])
                cache.read_counts["degenerate_triangles"] = 1
                shown = cache.places[0]
                local = shown.body.corners.astype(np.float64)
                shown.body.corners = rounded(transform(model.placements[0].matrix, local) - origin)
                shown.matrix = np.column_stack([np.eye(3), origin])
                # The numbers of the model are of f64: of the corners beside the origin some units are below them.
                shown.body.corners[corner] += np.float32(units * max(np.spacing(shown.body.corners[corner]), 2.0**-20))
                self.assertEqual({d["kind"] for d in Comparison(model, cache).run().differences}, {"position"} if units else set())

    def moved(self, change=lambda places: None, by=(1.0625e-3, -1.7e-4, 6.0001e-4), mesh_at=(80000.25, 2.5, -3.75)):
        """A mesh of two places that stands moved in its own space, as rounding to f32 leaves it."""
        g = Gltf()
        rng = np.random.default_rng(7)
        mesh = g.mesh(g.primitive(np.float32(rng.uniform(-1, 1, (12, 3)) + mesh_at)))
        turns = [[0.1825741858, 0.3651483717, 0.5477225575, 0.7302967433], QUARTER]
        model = read(g.show(*(g.node(mesh=mesh, rotation=turn, translation=[7.7, 0.1, -3.3]) for turn in turns)))
        cache = FakeCache(model, True)
        body = cache.places[0].body
        right = model.placements[0].parts[0].positions[model.placements[0].parts[0].corners]
        body.corners, body.node = rounded(right - by), NO_NODE
        for shown, placement in zip(cache.places, model.placements):
            shown.body = body
            shown.matrix[:, 3] = rounded(placement.matrix[:3] @ np.append(by, 1))
        change(cache.places)
        return {d["kind"] for d in Comparison(model, cache).run().differences}

    def test_a_shared_mesh_may_be_moved_in_its_own_space(self):
        for by in ((1.0625e-3, -1.7e-4, 6.0001e-4), (0, 0, 0), (80000, 0, 0), (80000.123, 1 / 3, -4), (1e-5, 1e-6, -1e-5), (0.004, 0, 0)):
            self.assertEqual(self.moved(by=by), set(), by)

    def test_faults_of_a_moved_mesh_are_found(self):
        def next_but_one(array, at):
            # The model's numbers are of f64: beside the origin some units of f32 are below them.
            array[at] = np.float32(array[at] + 2 * max(np.spacing(np.abs(np.float32(array[at]))), 2.0**-25))
        for by in ((1.0625e-3, -1.7e-4, 6.0001e-4), (0, 0, 0), (80000.123, 1 / 3, -4)):
            for corner in np.ndindex(4, 3, 3):
                self.assertTrue(self.moved(lambda places: next_but_one(places[0].body.corners, corner), by=by), (by, corner))
            for entry in np.ndindex(3, 3):
                # Beside a zero f32 is finer than the f64 of a turn.
                if QUARTER_MATRIX[entry]:
                    self.assertEqual(self.moved(lambda places: next_but_one(places[1].matrix, entry), by=by), {"matrix"}, (by, entry))
            self.assertIn("matrix", self.moved(lambda places: places[0].matrix.__iadd__(np.eye(3, 4, 3) * 1e-3), by=by))

    def test_corners_in_another_order_are_found(self):
        for order, kind in (([1, 2, 0], "corners turned"), ([1, 0, 2], "corners the other way round")):
            def turn(shown):
                shown.body.corners[0] = shown.body.corners[0][order]
            self.assertEqual(self.kinds(turn), {kind})

    def test_triangles_that_are_missing_swapped_or_too_many_are_found(self):
        def lose(shown):
            shown.body.prims, shown.body.corners = shown.body.prims[1:], shown.body.corners[1:]
        self.assertEqual(self.kinds(lose), {"missing"})

        def swap(shown):
            shown.body.corners = shown.body.corners[::-1].copy()
        self.assertEqual(self.kinds(swap), {"position"})

        def keep(shown):
            shown.body.prims = np.array([0, 1, 2])
            shown.body.corners = np.concatenate([shown.body.corners, np.zeros((1, 3, 3), np.float32)])
        self.assertTrue({"without area, and kept"} <= self.kinds(keep))
        self.assertEqual(self.kinds(count=0), {"count"})

        def other_part(shown):
            shown.body.part = 1
        self.assertEqual(self.kinds(other_part), {"missing", "extra part"})

        def shifted(shown):
            shown.body.first_prim = 1
        self.assertIn("range", self.kinds(shifted))


class Polygons(unittest.TestCase):
    TEXT = b"v 0 0 0\nv 4 0 0\nv 1 1 0\nv 0 4 0\nv 9 9 9\nf 1 2 3 4\n"

    def kinds(self, *triangles, drop=0):
        model = obj_model.read(self.TEXT)
        cache = FakeCache(model, False)
        body = cache.places[0].body
        positions = model.placements[0].parts[0].positions
        body.corners = rounded(positions[np.array(triangles) - 1])
        body.prims = np.arange(len(triangles))
        cache.read_counts["degenerate_triangles"] = drop
        return {d["kind"] for d in Comparison(model, cache).run().differences}

    def test_either_diagonal_that_does_not_fold_is_right(self):
        self.assertEqual(self.kinds((1, 2, 3), (1, 3, 4)), set())
        self.assertEqual(self.kinds((3, 4, 1), (3, 1, 2)), set())

    def test_wrong_cuts_are_found(self):
        self.assertEqual(self.kinds((1, 2, 4), (2, 3, 4)), {"polygon folded over"})
        self.assertIn("polygon's edges", self.kinds((1, 2, 3), (1, 2, 4)))
        self.assertIn("polygon's edges", self.kinds((1, 3, 2), (1, 4, 3)))
        self.assertIn("polygon's corner", self.kinds((1, 2, 3), (1, 3, 5)))
        self.assertEqual(self.kinds((1, 2, 3), drop=1), {"polygon's area"})


    def test_corners_that_rounding_may_join_are_told_apart_by_what_is_stored(self):
        # The second and third corner are a tenth of a unit of f32 apart, and stand on either side of where rounding parts them.
        text = b"v 0 0 0\nv 16777216.95 0 0\nv 16777217.05 0 0\nv 16777217.05 9 0\nv 0 9 0\nf 1 2 3 4 5\n"
        model = obj_model.read(text)
        positions = model.placements[0].parts[0].positions
        for triangles, wanted in ((((1, 2, 3), (1, 3, 4), (1, 4, 5)), set()), (((1, 2, 4), (2, 3, 4), (1, 4, 5)), set()),
                                  (((1, 2, 4), (2, 4, 3), (1, 4, 5)), {"polygon's edges"}), (((1, 2, 4), (1, 3, 4), (1, 4, 5)), {"polygon's edges"})):
            cache = FakeCache(model, False)
            body = cache.places[0].body
            body.corners, body.prims = rounded(positions[np.array(triangles) - 1]), np.arange(3)
            kept = ~without_area(body.corners)
            if wanted:
                kept[:] = True
            body.corners, body.prims = body.corners[kept], body.prims[kept]
            cache.read_counts["degenerate_triangles"] = int((~kept).sum())
            self.assertEqual({d["kind"] for d in Comparison(model, cache).run().differences}, wanted, triangles)

    def test_one_unit_in_the_last_place_is_found_about_an_origin(self):
        model = obj_model.read(self.TEXT.replace(b"v ", b"v 4649776.").replace(b" 1 1 0", b" 1 1 0"))
        origin = np.array([4649776.0, 1.0, 0.0])
        positions = model.placements[0].parts[0].positions
        for moved, wanted in ((0.0, set()), (2.0**-22, {"polygon's corner"})):
            cache = FakeCache(model, True)
            shown = cache.places[0]
            shown.body.corners = rounded(positions[np.array([(1, 2, 3), (1, 3, 4)]) - 1] - origin)
            shown.matrix = np.column_stack([np.eye(3), origin])
            shown.body.corners[1, 2, 1] += np.float32(moved)
            self.assertEqual({d["kind"] for d in Comparison(model, cache).run().differences}, wanted)


class Names(unittest.TestCase):
    def test_no_byte_is_lost(self):
        for object_, group, wanted in ((b"Lamp", b"", b"Lamp"), (b"", b"off", b"/off"), (b"Lamp", b"off", b"Lamp/off"), (b"a/b", b"c/d", b"a%2Fb/c/d"),
                                       (b"50%", b"5%", b"50%25/5%25"), (b"caf\xe9", "é".encode(), b"caf%E9/" + "é".encode()), (b"", b"", b"")):
            self.assertEqual(stored_name(object_, group), wanted)

    def test_a_wrong_name_is_found(self):
        model = obj_model.read(b"o Lamp\ng off\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3")
        cache = FakeCache(model, False)
        self.assertEqual(Comparison(model, cache).run().differences, [])
        cache.places[0].body.name = b"Lamp"
        self.assertEqual([d["kind"] for d in Comparison(model, cache).run().differences], ["name"])


class Arithmetic(unittest.TestCase):
    def test_half_a_unit_in_the_last_place(self):
        for x in (1.0, 1.5, -3.7, 4649776.75, 1e-38, 1e-44, 0.0, 3e38):
            f = np.float32(x)
            self.assertEqual(half_ulp(np.array([float(f)]))[0], float(np.spacing(np.abs(f))) / 2, x)

    def test_area_is_decided_exactly(self):
        eps = 2.0**-23
        triangles = np.array([
            [[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[0, 0, 0], [1, 1, 1], [2, 2, 2 + 2 * eps]], [[1, 1, 1]] * 3, [[0.1, 0.2, 0.3], [0.1, 0.2, 0.3], [5, 6, 7]],
            [[1e8, 0, 0], [1e8, 1e-38, 0], [0, 0, 0]], [[0, 0, 0], [1e-44, 0, 0], [0, 1e-44, 0]],
        ], dtype=np.float32)
        self.assertEqual(without_area(triangles).tolist(), [True, False, True, True, False, False])


if __name__ == "__main__":
    unittest.main()
