#!/usr/bin/env python3
"""Plain reference reader of the .bvhc file, version 1.1. SPEC.md is the law; numbers in brackets are its sections.

    bvhc_reader.py FILE                           check the file, print what `bvhc info --json FILE` prints
    bvhc_reader.py FILE --ray ox,oy,oz,dx,dy,dz   check the file, trace the ray, print the closest hit (repeatable)
    bvhc_reader.py FILE --rays LIST               the same for each line of a text file

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

try:
    import blake3
except ImportError:
    blake3 = None
try:
    import zstandard
except ImportError:
    zstandard = None

MINOR = 1  # that this reader knows
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
    "VERT": (6, np.dtype([("v0", U4), ("v1", U4), ("v2", U4)])),
    "SIDE": (6, np.dtype([("flags", U4)])),
    "NAMS": (2, None),
    "MATS": (6, None),
    "META": (2, None),
}


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


class File:
    """A file whose container [2-4], hashes [9], records [5] and trees [5.1] were checked."""

    def __init__(self, data):
        self.data = data
        self.read_header()
        self.read_table()
        self.check_hashes()
        self.bodies = [None] * len(self.table)
        for i, entry in sorted(enumerate(self.table), key=lambda entry: entry[1]["type"] != b"BLAS"):
            self.bodies[i] = self.decode(entry)
            if entry["type"] == b"BLAS" and self.bodies[i] is not None:
                self.check_counts(self.bodies[i])  # before anything large is decoded [11]
        self.read_records()
        self.check_names()
        self.check_origins()
        self.check_meta()
        self.depths = [self.check_tree(*self.tree(b), "BLAS %d" % i) for i, b in enumerate(self.blas)]
        self.check_blases()
        if self.two_level:
            self.depths.append(self.check_tree(self.tnod, len(self.inst), "TLAS"))
            self.check_instances()
        require(self.header["max_depth"] == max(self.depths, default=0), "header.max_depth is not that of the trees")
        self.check_scene_bounds()

    def read_header(self):
        require(self.data[:8] == MAGIC, "the magic bytes are missing: not a .bvhc file")
        require(len(self.data) >= 256, "the file is shorter than a header")
        h = self.header = plain(np.frombuffer(self.data, HEADER, 1)[0])
        if h["major"] != 1 or h["min_minor"] > min(h["minor"], MINOR):
            raise Unsupported("format %d.%d, readable from minor %d" % (h["major"], h["minor"], h["min_minor"]))
        if h["features_required"] != 0:
            raise Unsupported("required features 0x%x" % h["features_required"])
        require(h["header_len"] >= 256 and h["header_len"] % 64 == 0, "header_len")
        require(h["minor"] > MINOR or h["header_len"] == 256, "header_len is not 256 in version 1.%d" % MINOR)
        require(h["file_len"] == len(self.data) and len(self.data) % 64 == 0, "file_len is not the length of the file")
        require(4 <= h["section_count"] <= 65536 and h["section_entry_len"] == 128, "section_count or section_entry_len")
        require(h["section_table_off"] == h["header_len"], "section_table_off is not header_len")
        require(h["reserved"] == bytes(32) and h["frame_count"] == 0, "reserved bytes or frame_count are not zero")
        flags = self.flags = h["tree_flags"]
        require(flags & ~31 == 0 and not flags & SEQUENCE and flags & CANONICAL_DFS, "tree_flags")
        require(bool(flags & REFITTABLE) != bool(flags & DUP_REFS), "exactly one of REFITTABLE and DUP_REFS must be set")
        self.two_level = bool(flags & TWO_LEVEL)

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
            require(e["codec"] != 0 or (raw == stored and e["raw_hash"] == e["stored_hash"]), "lengths of raw %r" % name)
            flags, record = RECORDS.get(name.decode("latin-1"), (None, None))
            if flags is None or e["ordinal"] != 0 or e["schema"] != 1 or e["codec"] > 1:
                if e["flags"] & CRITICAL:
                    raise Unsupported("critical section %r, schema %d, codec %d" % (name, e["schema"], e["codec"]))
                continue
            require(e["flags"] == flags, "flags of %r" % name)
            require(size == (record.itemsize if record else 0), "elem_size of %r" % name)
            require(name != b"META" or (raw <= 1 << 20 and elements == 0), "META exceeds 1 MiB or has records")
        require(len(self.data) - end < 64 and not any(self.data[end:]), "bytes behind the last section")
        require(sum(e["raw_len"] for e in self.table) <= MAX_DECODED, "sections exceed 8 GiB decoded")

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

    def decode(self, e):
        """The decoded bytes of a section [8], or None for one that this reader skips."""
        stored = self.data[e["offset"]:e["offset"] + e["stored_len"]]
        if not understood(e):
            return None
        if e["codec"] == 0:
            return stored
        if zstandard is None:
            raise Unsupported("a compressed section: install the Python package zstandard")
        raw_len, out = e["raw_len"], []
        blocks = -(-raw_len // BLOCK)
        require(len(stored) >= 8 + 4 * blocks, "a compressed section is shorter than its frame list")
        count, zero = struct.unpack_from("<II", stored)
        require((count, zero) == (blocks, 0), "frame_count of a compressed section")
        position = 8 + 4 * blocks
        for i, length in enumerate(struct.unpack_from("<%dI" % blocks, stored, 8)):
            frame, position = stored[position:position + length], position + length
            want = min(BLOCK, raw_len - i * BLOCK)
            try:
                facts = zstandard.get_frame_parameters(frame)
                fits = facts.content_size == want and facts.window_size <= BLOCK and facts.dict_id == 0
                block = zstandard.ZstdDecompressor().decompress(frame, want, allow_extra_data=False) if fits else b""
            except zstandard.ZstdError as error:
                raise Invalid("a zstd frame: %s" % error)
            require(fits and len(block) == want, "a zstd frame's content size, window or dictionary")
            out.append(block)
        require(position == len(stored), "bytes behind the zstd frames")
        raw = b"".join(out)
        require(blake3 is None or digest(raw) == e["raw_hash"], "raw_hash of %r" % e["type"])
        return raw

    def check_counts(self, rows):
        """What header, table and the rows of BLAS say of each other [5.4, 11]."""
        records = {e["type"].decode(): e["elem_count"] for e in self.table if understood(e)}
        for field, name in [("ref_count", "TRIS"), ("blas_count", "BLAS"), ("instance_count", "INST")]:
            require(self.header[field] == records.get(name, 0), "header.%s is not the number of records of %s" % (field, name))
        node_at = ref_at = 0
        for b in map(plain, np.frombuffer(rows, RECORDS["BLAS"][1])):
            require((b["node_offset"], b["ref_offset"]) == (node_at, ref_at), "BLAS rows do not tile NODE and TRIS")
            require(b["ref_count"] <= 255 * (b["node_count"] // 2), "a tree has more references than its leaves can hold")
            node_at, ref_at = node_at + b["node_count"], ref_at + b["ref_count"]
        ends = (records.get("NODE", 0), records.get("TRIS", 0))
        require((node_at, ref_at) == ends, "BLAS rows do not end with NODE and TRIS")

    def body(self, name):
        found = [b for e, b in zip(self.table, self.bodies) if e["type"] == name.encode() and understood(e)]
        return found[0] if found else None

    def read_records(self):
        def rows(name, wanted=True):
            body = self.body(name)
            require((body is not None) == wanted, "%s is %s" % (name, "missing" if wanted else "not allowed in a one-level file"))
            return np.frombuffer(body or b"", RECORDS[name][1])

        self.node, self.tris, self.geom, self.blas = (rows(n) for n in ("NODE", "TRIS", "GEOM", "BLAS"))
        self.tnod, self.inst = (rows(n, self.two_level) for n in ("TNOD", "INST"))
        h, live = self.header, lambda n: max(int(n) - 1, 0)
        counts = {
            "prim_count": int(self.blas["prim_count"].sum(dtype=np.uint64)), "ref_count": len(self.tris),
            "node_count": sum(map(live, self.blas["node_count"])) + live(len(self.tnod)), "blas_count": len(self.blas),
            "instance_count": len(self.inst),
        }
        for field, count in counts.items():
            require(h[field] == count, "header.%s is %d, the sections say %d" % (field, h[field], count))
        require(self.two_level or len(self.blas) <= 1, "several BLASes in a one-level file")
        duplicates = any(self.blas["flags"] == DUP_REFS)
        require(duplicates == bool(self.flags & DUP_REFS), "DUP_REFS of the header and of the BLASes")
        require(all(np.isfinite(self.tris[v]).all() for v in ("v0", "v1", "v2")), "a triangle's corner is not finite")
        require((self.tris["flags"] <= 1).all() and (self.tris["geom"] < len(self.geom)).all(), "flags or geom of TRIS")
        first, prims = (self.geom[f].astype(np.uint64) for f in ("first_prim", "prim_count"))
        require((first + prims < 1 << 32).all() and (self.geom["kept_count"] <= prims).all(), "counts of GEOM")
        require((np.diff(self.geom["blas"].astype(np.int64)) >= 0).all(), "GEOM rows are not in the order of their blas")
        require((self.geom["blas"] < len(self.blas)).all() and not self.geom["reserved"].any(), "blas or reserved of GEOM")
        row, prim = self.tris["geom"], self.tris["prim"]
        require(((prim >= first[row]) & (prim < first[row] + prims[row])).all(), "prim of TRIS is not in its part")

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
            nodes, name = self.tree(b)[0], "BLAS %d" % i
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
            if b["flags"] == REFITTABLE:
                self.check_tight(nodes, corners, name)
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
    def check_tight(nodes, corners, name):
        """No box is larger than what it holds: rule 9 of [5.1]."""
        live = np.arange(len(nodes)) != 1
        inner = np.flatnonzero(live & (nodes["count"] == 0))
        pairs = nodes["first"][inner][:, None] + [0, 1]
        tight = (nodes["min"][pairs].min(axis=1) == nodes["min"][inner]).all()
        tight &= (nodes["max"][pairs].max(axis=1) == nodes["max"][inner]).all()
        for n in nodes[live & (nodes["count"] > 0)]:
            held = corners[int(n["first"]):][:int(n["count"])].reshape(-1, 3)
            tight &= (held.min(axis=0) == n["min"]).all() and (held.max(axis=0) == n["max"]).all()
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
        for m, box in zip(self.inst, leaf_of_each_ref(self.tnod)):
            b, a = self.blas[int(m["blas"])], m["object_to_world"].reshape(3, 4).astype(np.float64)
            if b["node_count"]:
                ends = np.stack([a[:, :3] * b["min"].astype(np.float64), a[:, :3] * b["max"].astype(np.float64)])
                low, high = (np.cumsum(np.column_stack([a[:, 3], e]), axis=1)[:, 3] for e in (ends.min(axis=0), ends.max(axis=0)))
                slack = (np.abs(ends).max(axis=0).sum(axis=1) + np.abs(a[:, 3])) * 2.0**-50
                require((box["min"] <= low - slack).all() and (box["max"] >= high + slack).all(), "an instance leaves its leaf's box")

    def check_scene_bounds(self):
        root = self.tnod if self.two_level else self.node
        low, high = (root["min"][0], root["max"][0]) if len(root) else (np.zeros(3), np.zeros(3))
        require((self.header["scene_min"] == low).all() and (self.header["scene_max"] == high).all(), "scene bounds")

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
        """From a hit back to the model [10.3]: `vertices` is u32[TRIS, 3] or None, `mirrored` bool[GEOM]."""
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
        require(len(self.vertices) == len(self.tris), "VERT has another number of records than TRIS")
        # A vertex of a part stands in one place: equal pairs of part and vertex lie next to each other, with equal positions.
        corners = (np.stack([self.tris[v] for v in ("v0", "v1", "v2")], axis=1) + np.float32(0)).view("<u4").reshape(-1, 3)
        keys = np.repeat(self.tris["geom"].astype(np.uint64), 3) << np.uint64(32) | self.vertices.reshape(-1)
        order = np.argsort(keys, kind="stable")
        same = keys[order][1:] == keys[order][:-1]
        require((corners[order][1:] == corners[order][:-1])[same].all(), "a vertex of a part stands in two places")
        keys = self.tris["geom"].astype(np.uint64) << np.uint64(32) | self.tris["prim"]
        order = np.argsort(keys, kind="stable")
        same = keys[order][1:] == keys[order][:-1]
        require((self.vertices[order][1:] == self.vertices[order][:-1])[same].all(), "copies of a triangle have different vertices")

    def check_meta(self):
        body = self.body("META")
        self.meta = None if body is None else Meta(body)
        if self.meta and blake3:
            require(digest(self.meta.key_stream(), "bvhc v1 build key") == self.header["build_key"], "build_key")
        for _, name, _, _ in self.meta.inputs if self.meta else []:
            require(not re.match(r"/|[A-Za-z]:[/\\]", name), "the name of an input is absolute")


def understood(e):
    """Whether this reader knows a section's type, number, layout and codec."""
    return e["type"].decode("latin-1") in RECORDS and e["ordinal"] == 0 and e["schema"] == 1 and e["codec"] <= 1


def cofactor(m, r, c):
    """Of the first three columns, with the magnitude of its two products."""
    (r0, r1), (c0, c1) = ((r + 1) % 3, (r + 2) % 3), ((c + 1) % 3, (c + 2) % 3)
    p, q = m[r0][c0] * m[r1][c1], m[r0][c1] * m[r1][c0]
    return p - q, abs(p) + abs(q)


def exact_determinant(m):
    m = [[Fraction(float(v)) for v in row] for row in m]
    return sum(m[0][c] * cofactor(m, 0, c)[0] for c in range(3))


def undoes(a, b):
    """Whether b is the inverse of a, within what f64 loses [5.5]."""
    det = exact_determinant(a)
    m = [[Fraction(float(v)) for v in row] for row in a]
    terms = sum(abs(m[0][c]) * cofactor(m, 0, c)[1] for c in range(3))
    lost = Fraction(1, 2**48)
    if abs(det) <= terms * lost:
        return det != 0
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
            "codec": {0: "raw", 1: "zstd"}.get(e["codec"], str(e["codec"])), "align": 1 << e["align_log2"],
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
    if not rays:
        print(json.dumps({"schema": "bvhc.info.v1", "files": [{"path": arguments.file, **info(file)}]}, indent=2))
    for ray in rays:
        numbers = [float(x) for x in ray.split(",")]
        if len(numbers) != 6:
            parser.error("a ray is six numbers: ox,oy,oz,dx,dy,dz")
        import bvhc_trace  # beside this file
        print(json.dumps(bvhc_trace.closest_hit(file, numbers[:3], numbers[3:])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
