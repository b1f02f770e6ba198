#!/usr/bin/env python3
"""Plain reference reader of the .bvhc file, version 1.4. SPEC.md is the law; numbers in brackets are its sections.

    bvhc_reader.py FILE                           check the file, print what `bvhc info --json FILE` prints
    bvhc_reader.py FILE --ray ox,oy,oz,dx,dy,dz   check the file, trace the ray, print the closest hit (repeatable)
    bvhc_reader.py FILE --rays LIST               the same for each line of a text file
    bvhc_reader.py FILE --frame N --ray ...       the same in the frame of a sequence that has the number N

Needs numpy; `blake3` to check the hashes and `zstandard` to read compressed sections. Slow and obvious on purpose, and
it shares no code with the tool. Exit status: 0 fine, 1 the file is invalid, 2 usage, 3 cannot be read, 5 unsupported.
"""

import argparse
import json
import re
import struct
import sys
from fractions import Fraction

import numpy as np

import bvhc_compact  # beside this file
import bvhc_delta  # likewise

try:
    import blake3
except ImportError:
    blake3 = None
try:
    import zstandard
except ImportError:
    zstandard = None

MINOR = 4  # that this reader knows
SEQUENCE_FEATURE = 1  # of features_required
MAGIC = b"\x89BVH\r\n\x1a\n"
BLOCK = 1 << 20  # decoded bytes of one zstd frame [8]
MAX_DECODED = 8 << 30
MOST_COVERED = 500  # cut triangles of a tree of which the cover is proved, evenly spread: fractions take their time
CRITICAL, COPY_SAFE, CONTENT = 1, 2, 4
REFITTABLE, DUP_REFS, CANONICAL_DFS, SEQUENCE, TWO_LEVEL = 1, 2, 4, 8, 16
TREE_FLAGS = ["REFITTABLE", "DUP_REFS", "CANONICAL_DFS", "SEQUENCE", "TWO_LEVEL"]
SECTION_FLAGS = ["CRITICAL", "COPY_SAFE", "CONTENT"]
U4, U8, V3 = "<u4", "<u8", ("<f4", 3)
HEADER = np.dtype([  # [2]
    ("magic", "V8"), ("major", "<u2"), ("minor", "<u2"), ("min_minor", "<u2"), ("header_len", "<u2"), ("file_len", U8),
    ("features_required", U8), ("features_optional", U8), ("section_count", U4), ("section_entry_len", U4),
    ("section_table_off", U8), ("tree_flags", U4), ("builder_id", U4), ("file_id", "V32"), ("content_id", "V32"),
    ("build_key", "V32"), ("prim_count", U8), ("ref_count", U8), ("node_count", U8), ("blas_count", U4),
    ("instance_count", U4), ("frame_count", U4), ("max_depth", U4), ("scene_min", *V3), ("scene_max", *V3), ("reserved", "V32"),
])
ENTRY = np.dtype([  # [3]
    ("type", "V4"), ("ordinal", U4), ("flags", U4), ("schema", "<u2"), ("codec", "u1"), ("align_log2", "u1"), ("offset", U8),
    ("stored_len", U8), ("raw_len", U8), ("elem_count", U8), ("elem_size", U4), ("reserved", "V12"), ("raw_hash", "V32"),
    ("stored_hash", "V32"),
])
NODE = np.dtype([("min", *V3), ("first", U4), ("max", *V3), ("count", U4)])
RECORDS = {  # [5]: type -> (flags, record)
    "NODE": (5, NODE),
    "TRIS": (5, np.dtype([("v0", *V3), ("prim", U4), ("v1", *V3), ("geom", U4), ("v2", *V3), ("flags", U4)])),
    "GEOM": (5, np.dtype([("source_mesh", U4), ("source_part", U4), ("baked_node", U4), ("blas", U4), ("first_prim", U4),
                          ("prim_count", U4), ("kept_count", U4), ("reserved", U4), ("name_hash", "V32")])),
    "BLAS": (5, np.dtype([("min", *V3), ("node_count", U4), ("max", *V3), ("ref_count", U4), ("node_offset", U8),
                          ("ref_offset", U8), ("prim_count", U4), ("max_depth", U4), ("sah", "<f4"), ("flags", U4)])),
    "TNOD": (5, NODE),
    "INST": (5, np.dtype([("object_to_world", "<f4", 12), ("world_to_object", "<f4", 12), ("blas", U4), ("id", U4),
                          ("mask", U4), ("flags", U4), ("node", U4), ("reserved", "V12")])),
    "TOPO": (5, np.dtype([("ref_offset", U8), ("ref_count", U4), ("node_count", U4), ("vertex_count", U4), ("prim_count", U4),
                          ("max_depth", U4), ("flags", U4), ("reserved", "V32")])),
    "TRIX": (5, np.dtype([("corners", U4, 3), ("prim", U4), ("geom", U4), ("flags", U4)])),
    "POSE": (5, np.dtype([("min", *V3), ("topology", U4), ("max", *V3), ("block", U4), ("node_offset", U8),
                          ("vertex_offset", U8), ("sah", "<f4"), ("flags", U4), ("reserved", "V8")])),
    "VPOS": (5, np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4")])),
    "FRAM": (5, np.dtype([("number", "<i4"), ("placement", U4), ("time", "<f4"), ("flags", U4), ("reserved", "V16")])),
    "CROW": (2, np.dtype([("node_offset", U8), ("node_count", U4), ("waiting", U4)])),
    "CNOD": (2, np.dtype([("origin", *V3), ("exponents", "u1", 3), ("children", "u1"), ("first_node", U4), ("first_ref", U4),
                          ("counts", "u1", 8), ("low", "u1", 24), ("high", "u1", 24)])),
    "CREF": (2, np.dtype([("triangle", U4)])),
    "VERT": (6, np.dtype([("v0", U4), ("v1", U4), ("v2", U4)])),
    "SIDE": (6, np.dtype([("flags", U4)])),
    "NAMS": (2, None),
    "MATS": (6, None),
    "META": (2, None),
}
NUMBERED = {"NODE", "VPOS", "TNOD", "INST"}  # of which a sequence has several [5.6]
ROWS = {b"BLAS", b"TOPO", b"POSE", b"FRAM", b"GEOM"}  # that say how large the other sections are [11]
RAW, ZSTD, DELTA = 0, 1, 2  # codecs [8]
DIFFERENCES = ["TRIX", "VPOS", "NODE"]  # that may have codec 2 in a sequence, in the order in which they are decoded [8.1]
COMPACT = ["CROW", "CNOD", "CREF"]  # that a still file may have, all or none [5.7]
STILL, IN_SEQUENCES = {"TRIS", "BLAS"}, {"TOPO", "TRIX", "POSE", "VPOS", "FRAM"}
KEY, TIMED, HELD = 1, 1, 2


class Invalid(Exception):
    """The file breaks a rule of the specification."""


class Unsupported(Exception):
    """The file may be fine, but this reader must refuse it."""


def require(condition, rule):
    if not condition:
        raise Invalid(rule)


def digest(data, context=None):
    return blake3.blake3(data, derive_key_context=context).digest() if context else blake3.blake3(data).digest()


def plain(row):
    """A record as Python numbers, bytes and small arrays, so that no arithmetic on it can wrap around."""
    return {f: row[f].item() if row[f].ndim == 0 else row[f] for f in row.dtype.names}


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


class File(Trees):
    """A file whose container [2-4], hashes [9], records [5] and trees [5.1] were checked.

    A still file is its own trees. Of a sequence, `frame(i)` gives those of one frame.
    """

    def __init__(self, data):
        self.data = data
        self.read_header()
        self.read_table()
        self.check_hashes()
        self.check_head_counts()
        self.decode_all()
        depths = self.check_sequence() if self.sequence else self.check_still()
        self.check_names()
        self.check_origins()
        self.check_meta()
        require(self.header["max_depth"] == max(depths, default=0), "header.max_depth is not that of the trees")

    def read_header(self):
        require(self.data[:8] == MAGIC, "the magic bytes are missing: not a .bvhc file")
        require(len(self.data) >= 256, "the file is shorter than a header")
        h = self.header = plain(np.frombuffer(self.data, HEADER, 1)[0])
        if h["major"] != 1 or h["min_minor"] > min(h["minor"], MINOR):
            raise Unsupported("format %d.%d, readable from minor %d" % (h["major"], h["minor"], h["min_minor"]))
        if h["features_required"] & ~SEQUENCE_FEATURE:
            raise Unsupported("required features 0x%x" % h["features_required"])
        require(h["header_len"] >= 256 and h["header_len"] % 64 == 0, "header_len")
        require(h["minor"] > MINOR or h["header_len"] == 256, "header_len is not 256 in version 1.%d" % MINOR)
        require(h["file_len"] == len(self.data) and len(self.data) % 64 == 0, "file_len is not the length of the file")
        require(4 <= h["section_count"] <= 65536 and h["section_entry_len"] == 128, "section_count or section_entry_len")
        require(h["section_table_off"] == h["header_len"], "section_table_off is not header_len")
        require(h["reserved"] == bytes(32), "reserved bytes are not zero")
        flags = self.flags = h["tree_flags"]
        require(flags & ~31 == 0 and flags & CANONICAL_DFS, "tree_flags")
        require(bool(flags & REFITTABLE) != bool(flags & DUP_REFS), "exactly one of REFITTABLE and DUP_REFS must be set")
        self.two_level, self.sequence = bool(flags & TWO_LEVEL), bool(flags & SEQUENCE)
        require(self.sequence == bool(h["features_required"] & SEQUENCE_FEATURE), "SEQUENCE without its feature, or the feature without it")
        require(self.two_level or not self.sequence, "SEQUENCE without TWO_LEVEL")
        require(h["min_minor"] >= 2 or not self.sequence, "a sequence that asks for less than version 1.2")

    def understood(self, e):
        """Whether this reader knows a section's type, number, layout and codec."""
        name = e["type"].decode("latin-1")
        codecs = [RAW, ZSTD, DELTA] if self.sequence and name in DIFFERENCES else [RAW, ZSTD]
        return name in RECORDS and (e["ordinal"] == 0 or name in NUMBERED) and e["schema"] == 1 and e["codec"] in codecs

    def read_table(self):
        start, count = self.header["header_len"], self.header["section_count"]
        end = start + 128 * count
        require(end <= len(self.data), "the section table ends behind the file")
        self.table, seen = [plain(e) for e in np.frombuffer(self.data, ENTRY, count, start)], set()
        for e in self.table:
            name, offset, stored, raw = e["type"], e["offset"], e["stored_len"], e["raw_len"]
            require((name, e["ordinal"]) not in seen, "two sections of one type and ordinal")
            seen.add((name, e["ordinal"]))
            require(6 <= e["align_log2"] <= 16 and offset % (1 << e["align_log2"]) == 0, "alignment of %r" % name)
            require(offset >= end and offset - end < 1 << e["align_log2"], "%r overlaps or leaves a gap" % name)
            require(not any(self.data[end:offset]), "bytes before %r are not zero" % name)
            end = offset + stored
            require(end <= len(self.data), "%r ends behind the file" % name)
            require(e["flags"] & ~7 == 0 and e["reserved"] == bytes(12), "flags or reserved bytes of %r" % name)
            size, elements = e["elem_size"], e["elem_count"]
            require(size == 0 or size * elements == raw, "elem_size and elem_count of %r" % name)
            require(e["codec"] != RAW or (raw == stored and e["raw_hash"] == e["stored_hash"]), "lengths of raw %r" % name)
            flags, record = RECORDS.get(name.decode("latin-1"), (None, None))
            if not self.understood(e):
                if e["flags"] & CRITICAL:
                    raise Unsupported("critical section %r, schema %d, codec %d" % (name, e["schema"], e["codec"]))
                continue
            require(e["codec"] != DELTA or self.header["min_minor"] >= 3, "%r has a codec of version 1.3, and the file asks for less" % name)
            require(e["flags"] == flags, "flags of %r" % name)
            require(size == (record.itemsize if record else 0), "elem_size of %r" % name)
            require(name != b"META" or (raw <= 1 << 20 and elements == 0), "META exceeds 1 MiB or has records")
        self.check_presence()
        require(len(self.data) - end < 64 and not any(self.data[end:]), "bytes behind the last section")
        require(sum(e["raw_len"] for e in self.table) <= MAX_DECODED, "sections exceed 8 GiB decoded")

    def check_presence(self):
        """Which types a file has, and their numbers [3, 5]."""
        numbers = {}
        for e in filter(self.understood, self.table):
            numbers.setdefault(e["type"].decode(), []).append(e["ordinal"])
        wanted = {"NODE", "GEOM"} | (IN_SEQUENCES if self.sequence else STILL) | ({"TNOD", "INST"} if self.two_level else set())
        for name in RECORDS:
            if RECORDS[name][0] & CRITICAL:
                require((name in numbers) == (name in wanted), "%s is %s" % (name, "missing" if name in wanted else "not allowed in such a file"))
            require(sorted(numbers.get(name, [0])) == list(range(len(numbers.get(name, [0])))), "the numbers of %s have a hole" % name)
            require(self.sequence or len(numbers.get(name, [0])) == 1, "a still file with several %s" % name)
        require(not self.sequence or not any(name in numbers for name in COMPACT), "a sequence with compact trees")
        for a, b in (("NODE", "VPOS"), ("TNOD", "INST")):
            require(not self.sequence or len(numbers[a]) == len(numbers[b]), "another number of %s than of %s" % (a, b))

    def check_hashes(self):
        if blake3 is None:
            print("hashes not checked: install the Python package blake3", file=sys.stderr)
            return
        for e in self.table:
            stored = self.data[e["offset"]:e["offset"] + e["stored_len"]]
            require(digest(stored) == e["stored_hash"], "stored_hash of %r" % e["type"])
        head, table = self.header["header_len"], 128 * len(self.table)
        blanked = self.data[:64] + bytes(32) + self.data[96:head + table]
        require(digest(blanked, "bvhc v1 file id") == self.header["file_id"], "file_id")
        content = b"".join(
            struct.pack("<4sIHxxIQ32s", *(e[f] for f in ("type", "ordinal", "schema", "elem_size", "raw_len", "raw_hash")))
            for e in sorted(self.table, key=lambda e: (e["type"], e["ordinal"])) if e["flags"] & CONTENT)
        require(digest(content, "bvhc v1 content id") == self.header["content_id"], "content_id")

    def decode_all(self):
        """Rows first: what they say of the other sections is checked before anything large is decoded [11]."""
        self.bodies, self.moved = [None] * len(self.table), None
        for i, e in enumerate(self.table):
            self.bodies[i] = self.decode(e) if e["type"] in ROWS else None
        if self.sequence:
            self.check_sequence_rows()
            self.moved = bvhc_delta.Differences(self.topo, self.pose)
        else:
            self.check_rows(self.body("BLAS"))
        order = [b"", *(name.encode() for name in DIFFERENCES)]  # each needs what stands before it, the others nothing
        for i, e in sorted(enumerate(self.table), key=lambda x: (order.index(x[1]["type"]) if x[1]["type"] in order else 0, x[1]["ordinal"])):
            if e["type"] not in ROWS:
                self.bodies[i] = self.decode(e)

    def decode(self, e):
        """The decoded bytes of a section [8], or None for one that this reader skips."""
        if not self.understood(e):
            return None
        raw, name = self.data[e["offset"]:e["offset"] + e["stored_len"]], e["type"].decode()
        try:
            if e["codec"] == ZSTD:
                raw = unframed(raw, e["raw_len"])
            if e["codec"] == DELTA:
                packed = unframed(raw, self.moved.packed_len(name, e["ordinal"], e["raw_len"]))
                raw = self.moved.decode(name, e["ordinal"], packed)
            require(blake3 is None or digest(raw) == e["raw_hash"], "raw_hash of %r" % e["type"])
            if self.moved:
                self.moved.learn(name, e["ordinal"], raw)
        except bvhc_delta.Undecodable as error:
            raise Invalid("%s %d: %s" % (name, e["ordinal"], error))
        return raw

    def check_head_counts(self):
        """What header and table say of each other [2, 11]."""
        records = {}
        for e in filter(self.understood, self.table):
            records[e["type"].decode()] = records.get(e["type"].decode(), 0) + e["elem_count"]
        names = ("TRIX", "TOPO") if self.sequence else ("TRIS", "BLAS")
        for field, name in zip(("ref_count", "blas_count", "instance_count", "frame_count"), (*names, "INST", "FRAM")):
            require(self.header[field] == records.get(name, 0), "header.%s is not the number of records of %s" % (field, name))
        return records

    def check_rows(self, rows):
        """What the table and the rows of BLAS say of each other [5.4, 11]."""
        records = self.check_head_counts()
        node_at = ref_at = 0
        for b in map(plain, np.frombuffer(rows, RECORDS["BLAS"][1])):
            require((b["node_offset"], b["ref_offset"]) == (node_at, ref_at), "BLAS rows do not tile NODE and TRIS")
            require(b["ref_count"] <= 255 * (b["node_count"] // 2), "a tree has more references than its leaves can hold")
            node_at, ref_at = node_at + b["node_count"], ref_at + b["ref_count"]
        ends = (records.get("NODE", 0), records.get("TRIS", 0))
        require((node_at, ref_at) == ends, "BLAS rows do not end with NODE and TRIS")

    def body(self, name, number=0):
        key = (name.encode(), number)
        found = [b for e, b in zip(self.table, self.bodies) if (e["type"], e["ordinal"]) == key and self.understood(e)]
        return found[0] if found else None

    def rows(self, name, number=0):
        body = self.body(name, number)
        require(body is not None, "%s cannot be read" % name)
        return np.frombuffer(body, RECORDS[name][1])

    def check_header_counts(self, rows, node_counts, tops):
        """The sums over the trees that the header states. `rows`: of BLAS or TOPO; `tops`: each TLAS's nodes."""
        live = lambda n: max(int(n) - 1, 0)
        nodes = sum(map(live, node_counts)) + sum(live(len(top)) for top in tops)
        for field, count in (("prim_count", int(rows["prim_count"].sum(dtype=np.uint64))), ("node_count", nodes)):
            require(self.header[field] == count, "header.%s is %d, the sections say %d" % (field, self.header[field], count))
        duplicates = any(rows["flags"] == DUP_REFS)
        require(duplicates == bool(self.flags & DUP_REFS), "DUP_REFS of the header and of the trees")

    def check_bounds(self, roots):
        roots = [root for root in roots if len(root)]
        low, high = (np.minimum.reduce([r["min"][0] for r in roots]), np.maximum.reduce([r["max"][0] for r in roots])) if roots else (0, 0)
        require((self.header["scene_min"] == low).all() and (self.header["scene_max"] == high).all(), "scene bounds")

    def check_still(self):
        self.node, self.tris, self.geom, self.blas = (self.rows(n) for n in ("NODE", "TRIS", "GEOM", "BLAS"))
        self.tnod, self.inst = (self.rows(n) if self.two_level else np.zeros(0, RECORDS[n][1]) for n in ("TNOD", "INST"))
        require(self.two_level or len(self.blas) <= 1, "several BLASes in a one-level file")
        self.check_header_counts(self.blas, self.blas["node_count"], [self.tnod])
        depths = self.check_trees() + ([self.check_top()] if self.two_level else [])
        self.check_bounds([self.tnod if self.two_level else self.node])
        self.check_nodes()
        self.check_compact()
        return depths

    def check_compact(self):
        """Compact trees [5.7]: the counts, then each tree beside its BLAS."""
        there = [self.body(name) is not None for name in COMPACT]
        require(all(there) or not any(there), "some of CROW, CNOD and CREF are missing")
        if not any(there):
            return
        rows, nodes, order = (self.rows(name) for name in COMPACT)
        require(len(rows) == len(self.blas) and len(order) == len(self.tris), "the numbers of records of CROW and CREF")
        at = 0
        for i, (row, b) in enumerate(zip(map(plain, rows), self.blas)):
            require(row["node_offset"] == at, "CROW rows do not tile CNOD")
            at += row["node_count"]
            require((row["node_count"] == 0) == (b["node_count"] == 0) and at <= len(nodes), "node_count of CROW")
            mine = order["triangle"][int(b["ref_offset"]):][:int(b["ref_count"])].tolist()
            waiting = bvhc_compact.check(nodes[at - row["node_count"]:at], mine, self.tree(b)[0], require, "compact tree %d" % i)
            require(row["waiting"] == waiting, "waiting of CROW")
        require(at == len(nodes), "CROW rows do not end with CNOD")

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

    def check_names(self):
        self.names, self.materials = self.strings("NAMS"), self.strings("MATS")
        if self.names is None:
            require(not any(any(n.item()) for n in self.geom["name_hash"]), "named parts, but no NAMS")
        elif blake3:
            for name, wanted in zip(self.names, self.geom["name_hash"]):
                require((digest(name) if name else bytes(32)) == wanted.item(), "a name of NAMS and its hash in GEOM")

    def strings(self, section):
        """One string a row of GEOM [7]; None where the section is absent."""
        body = self.body(section)
        if body is None:
            return None
        count, strings = len(self.geom), []
        require(len(body) >= 8 + 4 * count and struct.unpack_from("<I", body)[0] == count, "count of %s" % section)
        stated = [e["elem_count"] for e in self.table if e["type"] == section.encode()]
        require(stated == [count], "elem_count of %s" % section)
        text, start = body[8 + 4 * count:], 0
        require(struct.unpack_from("<I", body, 4)[0] == len(text), "text_len of %s" % section)
        for end in struct.unpack_from("<%dI" % count, body, 8):
            require(start <= end <= len(text) and end - start <= 4096, "ends of %s" % section)
            name, start = text[start:end], end
            try:
                name.decode("utf-8")
            except UnicodeDecodeError:
                raise Invalid("a name of %s is not UTF-8" % section)
            strings.append(name)
        require(start == len(text) > 0, "%s has text behind the last name, or none at all" % section)
        return strings

    def check_origins(self):
        """From a hit back to the model [10.3]: `vertices` is u32[TRIS or TRIX, 3] or None, `mirrored` bool[GEOM]."""
        body = self.body("SIDE")
        self.mirrored = np.zeros(len(self.geom), bool)
        if body is not None:
            sides = np.frombuffer(body, "<u4")
            require(len(sides) == len(self.geom) and sides.any() and (sides <= 1).all(), "records of SIDE")
            self.mirrored = sides == 1
            require((self.geom["baked_node"][self.mirrored] != 0xFFFFFFFF).all(), "a part is mirrored, and no node was baked")
        body = self.body("VERT")
        self.vertices = None if body is None else np.frombuffer(body, "<u4").reshape(-1, 3)
        if body is None:
            return
        require(len(self.vertices) == self.header["ref_count"], "VERT has another number of records than there are triangles")
        if not self.sequence:
            self.check_vertices(self.vertices)
            return
        for i, pose in enumerate(self.pose):
            topology = self.topo[int(pose["topology"])]
            self.posed([i]).check_vertices(self.vertices[int(topology["ref_offset"]):][:int(topology["ref_count"])])

    def check_meta(self):
        body = self.body("META")
        self.meta = None if body is None else Meta(body)
        if self.meta and blake3:
            require(digest(self.meta.key_stream(), "bvhc v1 build key") == self.header["build_key"], "build_key")
        for _, name, _, _ in self.meta.inputs if self.meta else []:
            require(not re.match(r"/|[A-Za-z]:", name) and "\\" not in name, "the name of an input is absolute on some system")


def unframed(stored, length):
    """The bytes, so many, that frames hold [8]."""
    if zstandard is None:
        raise Unsupported("a compressed section: install the Python package zstandard")
    blocks, out = -(-length // BLOCK), []
    require(len(stored) >= 8 + 4 * blocks, "a compressed section is shorter than its frame list")
    count, zero = struct.unpack_from("<II", stored)
    require((count, zero) == (blocks, 0), "frame_count of a compressed section")
    position = 8 + 4 * blocks
    for i, size in enumerate(struct.unpack_from("<%dI" % blocks, stored, 8)):
        frame, position = stored[position:position + size], position + size
        want = min(BLOCK, length - i * BLOCK)
        try:
            facts = zstandard.get_frame_parameters(frame)
            fits = facts.content_size == want and facts.window_size <= BLOCK and facts.dict_id == 0
            block = zstandard.ZstdDecompressor().decompress(frame, want, allow_extra_data=False) if fits else b""
        except zstandard.ZstdError as error:
            raise Invalid("a zstd frame: %s" % error)
        require(fits and len(block) == want, "a zstd frame's content size, window or dictionary")
        out.append(block)
    require(position == len(stored), "bytes behind the zstd frames")
    return b"".join(out)


def cofactor(m, r, c):
    """Of the first three columns, with the magnitude of its two products."""
    (r0, r1), (c0, c1) = ((r + 1) % 3, (r + 2) % 3), ((c + 1) % 3, (c + 2) % 3)
    p, q = m[r0][c0] * m[r1][c1], m[r0][c1] * m[r1][c0]
    return p - q, abs(p) + abs(q)


def exact_determinant(m):
    m = [[Fraction(float(v)) for v in row] for row in m]
    return sum(m[0][c] * cofactor(m, 0, c)[0] for c in range(3))


def undoes(a, b):
    """Whether b is the inverse of a, within what f64 loses, and f64 can tell the inverse [5.5]."""
    rows = [[float(v) for v in row] for row in a]  # the sums in f64, one after the other
    told, magnitudes = 0.0, 0.0
    for c in range(3):
        value, magnitude = cofactor(rows, 0, c)
        told, magnitudes = told + rows[0][c] * value, magnitudes + abs(rows[0][c] * magnitude)
    if not abs(told) > magnitudes * 2.0**-48:
        return False
    det = exact_determinant(a)
    m = [[Fraction(v) for v in row] for row in rows]
    terms = sum(abs(m[0][c]) * cofactor(m, 0, c)[1] for c in range(3))
    lost = Fraction(1, 2**48)
    for r in range(3):
        moved = slack = Fraction(0)
        for c in range(4):
            if c < 3:
                value, magnitude = cofactor(m, c, r)
                entry = value / det
                s = lost * (magnitude + abs(entry) * terms) / abs(det)
                moved, slack = moved - entry * m[c][3], slack + (s + lost * abs(entry)) * abs(m[c][3])
            else:
                entry, s = moved, slack
            # A little more, for a reader that computes the entry in f64.
            if abs(Fraction(float(b[r][c])) - entry) > (abs(entry) / 2**22 + s + Fraction(1, 2**149)) * Fraction(9, 8):
                return False
    return True


def covers(boxes, corners):
    """Whether the boxes cover the triangle, in exact arithmetic: cut each out, and see whether something is left [5.1, rule 8]."""
    def solid(part):  # an area; where the triangle has none, a length
        p = part[0] if part else None
        edges = [[a - b for a, b in zip(q, p)] for q in part[1:]]
        if flat:
            return any(any(e) for e in edges)
        return any(x[i] * y[j] != x[j] * y[i] for x, y in zip(edges, edges[1:]) for i, j in ((0, 1), (1, 2), (2, 0)))

    def keep(part, axis, plane, sign):  # what lies where sign * (x[axis] - plane) >= 0
        out = []
        for p, q in zip(part, part[1:] + part[:1]):
            d, e = sign * (p[axis] - plane), sign * (q[axis] - plane)
            out += [p] if d >= 0 else []
            if d * e < 0:
                out.append([a + (b - a) * d / (d - e) for a, b in zip(p, q)])
        return out

    whole, flat = [[Fraction(float(v)) for v in p] for p in corners], False
    flat = not solid(whole)
    if flat and not solid(whole):  # a point
        return any((low <= corners[0]).all() and (corners[0] <= high).all() for low, high in boxes)
    parts = [whole]
    for low, high in boxes:
        sides = [(k, Fraction(float(b[k])), sign) for k in range(3) for b, sign in ((low, 1), (high, -1))]
        left = []
        for part in parts:
            for axis, plane, sign in sides:
                if any(sign * (p[axis] - plane) < 0 for p in part):  # and not only in the side itself, which the box has
                    left.append(keep(part, axis, plane, -sign))
                part = keep(part, axis, plane, sign)
        parts = [part for part in left if solid(part)]
    return not parts


def outward(values, side):
    """The nearest numbers of f32 that are not inside."""
    rounded = values.astype(np.float32)
    inside = rounded.astype(np.float64) > values if side < 0 else rounded.astype(np.float64) < values
    return np.where(inside, np.nextafter(rounded, np.float32(side)), rounded)


def leaf_of_each_ref(nodes):
    """For each reference of a checked tree the node of the leaf that it stands in."""
    leaves = nodes[nodes["count"] > 0]  # record 1 is zero, so it is not among them
    leaves = leaves[np.argsort(leaves["first"])]
    return np.repeat(leaves, leaves["count"])


class Meta:
    """Provenance [6], decoded field by field."""

    def __init__(self, data):
        self.data, self.at = data, 0
        self.tool, self.tool_version, self.method = self.text(), self.text(), self.text()
        self.revision = self.number("<I")
        self.options = self.items(lambda: (self.text(), self.text()))
        self.inputs = self.items(lambda: (self.number("<I"), self.text(), self.number("<Q"), self.take(32)))
        self.read_counts = self.items(lambda: (self.text(), self.number("<Q")))
        self.notes = self.items(self.text)
        require(self.at == len(data), "bytes behind the last field of META")
        for pairs in (self.options, self.read_counts):
            require(len({name for name, _ in pairs}) == len(pairs), "META names an option or a count twice")

    def take(self, length):
        require(length <= len(self.data) - self.at, "META ends in the middle of a field")
        self.at += length
        return self.data[self.at - length:self.at]

    def number(self, form):
        return struct.unpack(form, self.take(struct.calcsize(form)))[0]

    def text(self):
        length = self.number("<Q")
        require(length <= 4096, "a string of META exceeds 4096 bytes")
        try:
            return self.take(length).decode("utf-8")
        except UnicodeDecodeError:
            raise Invalid("a string of META is not UTF-8")

    def items(self, one):
        count = self.number("<Q")
        require(count <= len(self.data), "a list of META is longer than META")
        return [one() for _ in range(count)]

    def key_stream(self):
        """What build_key hashes [9.3]."""
        items = [(1, struct.pack("<H", 1)), (2, self.method.encode()), (3, struct.pack("<I", self.revision))]
        for name, value in self.options:
            items += [(4, name.encode()), (5, value.encode())]
        items += [(6, struct.pack("<IQ", role, length) + digest) for role, _, length, digest in self.inputs]
        return b"".join(struct.pack("<BQ", tag, len(value)) + value for tag, value in items)


def info(file):
    """What `bvhc info --json` says of a file."""
    def flag_set(bits, names):
        return {"bits": bits, "names": [n for i, n in enumerate(names) if bits >> i & 1]}

    def floats(values):
        return [float(str(v)) for v in values]  # the shortest decimal that gives the same f32

    def section(e):
        name = "".join(chr(c) if 33 <= c <= 126 else "\\x%02x" % c for c in e["type"])
        return {
            "type": name, "ordinal": e["ordinal"], "flags": flag_set(e["flags"], SECTION_FLAGS), "schema": e["schema"],
            "codec": {RAW: "raw", ZSTD: "zstd", DELTA: "delta"}.get(e["codec"], str(e["codec"])), "align": 1 << e["align_log2"],
            **{f: e[f] for f in ("offset", "stored_len", "raw_len", "elem_count", "elem_size")},
            **{f: e[f].hex() for f in ("raw_hash", "stored_hash")},
        }

    h, m = file.header, file.meta
    return {
        "file_len": h["file_len"],
        "format": {f: h[f] for f in ("major", "minor", "min_minor")},
        **{f: h[f] for f in ("features_required", "features_optional")},
        "tree_flags": flag_set(h["tree_flags"], TREE_FLAGS),
        "builder": {"id": h["builder_id"], "name": m and m.method},
        **{f: h[f].hex() for f in ("file_id", "content_id", "build_key")},
        **{f: h[f] for f in ("prim_count", "ref_count", "node_count", "blas_count", "instance_count", "frame_count", "max_depth")},
        "scene_bounds": {"min": floats(h["scene_min"]), "max": floats(h["scene_max"])},
        "sections": [section(e) for e in file.table],
        "meta": m and {
            "tool": m.tool, "tool_version": m.tool_version, "method": m.method, "builder_revision": m.revision,
            "options": [{"name": n, "value": v} for n, v in m.options],
            "inputs": [{"role": r, "name": n, "len": length, "blake3": b.hex()} for r, n, length, b in m.inputs],
            "read_counts": [{"name": n, "count": c} for n, c in m.read_counts],
            "notes": m.notes,
        },
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--ray", action="append", default=[], metavar="ox,oy,oz,dx,dy,dz", help="write --ray=-1,... for a negative number")
    parser.add_argument("--frame", type=int, metavar="N", help="the number of the frame of a sequence in which rays are traced")
    parser.add_argument("--rays", metavar="LIST", help="a text file with one such ray a line")
    arguments = parser.parse_args()
    try:
        with open(arguments.file, "rb") as f:
            file = File(f.read())
        rays = arguments.ray + (open(arguments.rays).read().split() if arguments.rays else [])
    except OSError as error:
        print("error: %s" % error, file=sys.stderr)
        return 3
    except Invalid as error:
        print("error: %s is invalid: %s" % (arguments.file, error), file=sys.stderr)
        return 1
    except Unsupported as error:
        print("error: %s is not supported: %s" % (arguments.file, error), file=sys.stderr)
        return 5
    trees = file
    if file.sequence and rays:
        index = file.numbered(arguments.frame)
        if index is None:
            parser.error("--frame must be one of %s" % ", ".join(map(str, file.fram["number"])))
        trees = file.frame(index)
    elif arguments.frame is not None and not file.sequence:
        parser.error("--frame needs a sequence, and %s is a still file" % arguments.file)
    if not rays:
        print(json.dumps({"schema": "bvhc.info.v1", "files": [{"path": arguments.file, **info(file)}]}, indent=2))
    for ray in rays:
        numbers = [float(x) for x in ray.split(",")]
        if len(numbers) != 6:
            parser.error("a ray is six numbers: ox,oy,oz,dx,dy,dz")
        import bvhc_trace  # beside this file
        print(json.dumps(bvhc_trace.closest_hit(trees, numbers[:3], numbers[3:])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
