"""The file as a whole, still or a sequence: every rule of SPEC.md. Used by bvhc_reader.py."""

import re
import struct

import numpy as np

import bvhc_compact
import bvhc_turned
from bvhc_container import Container
from bvhc_frames import Frames
from bvhc_meta import Meta
from bvhc_records import COMPACT, TURNED, DUP_REFS, RECORDS, Invalid, blake3, digest, plain, require
from bvhc_trees import Trees


class File(Container, Frames, Trees):
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
        self.check_turned()
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

    def check_turned(self):
        """Turned subtrees [5.8]."""
        there = [self.body(name) is not None for name in TURNED]
        require(all(there) or not any(there), "one of OROW and ONOD is missing")
        if any(there):
            require(len(self.blas) == 1 and not self.two_level, "turned subtrees of no one tree")
            nodes = self.tree(self.blas[0])[0]
            bvhc_turned.check(*(self.rows(name) for name in TURNED), nodes, self.tris, require)

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
