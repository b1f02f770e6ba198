"""Provenance, SPEC.md 6, and what is told of a whole file. Used by bvhc_reader.py."""

import struct

from bvhc_records import DELTA, RAW, SECTION_FLAGS, TREE_FLAGS, ZSTD, Invalid, digest, require


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
    # All records of TNOD but the unused one of each tree.
    top_nodes = sum(max(e["elem_count"] - 1, 0) for e in file.table if e["type"] == b"TNOD")
    return {
        "file_len": h["file_len"],
        "format": {f: h[f] for f in ("major", "minor", "min_minor")},
        **{f: h[f] for f in ("features_required", "features_optional")},
        "tree_flags": flag_set(h["tree_flags"], TREE_FLAGS),
        "builder": {"id": h["builder_id"], "name": m and m.method},
        **{f: h[f].hex() for f in ("file_id", "content_id", "build_key")},
        "triangles": h["prim_count"], "references": h["ref_count"], "nodes": h["node_count"] - top_nodes, "top_nodes": top_nodes,
        "trees": h["blas_count"], "instances": h["instance_count"], "frames": h["frame_count"], "max_depth": h["max_depth"],
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
