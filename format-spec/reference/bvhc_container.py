"""The container: header, section table, hashes and codecs, SPEC.md 2 to 4, 8 and 9. Used by bvhc_file.py."""

import struct
import sys

import numpy as np

import bvhc_delta
from bvhc_records import (
    BLOCK, CANONICAL_DFS, COMPACT, CONTENT, CRITICAL, DELTA, DIFFERENCES, DUP_REFS, ENTRY, HEADER, IN_SEQUENCES, TURNED,
    MAGIC, MAX_DECODED, MINOR, NUMBERED, RAW, RECORDS, REFITTABLE, ROWS, SEQUENCE, SEQUENCE_FEATURE, STILL,
    TWO_LEVEL, ZSTD, Invalid, Unsupported, blake3, digest, plain, require,
)

try:
    import zstandard
except ImportError:
    zstandard = None


class Container:
    """Header, table and sections, SPEC.md 2 to 4, 8 and 9: what holds before any record is understood."""

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
        require(not self.sequence or not any(name in numbers for name in COMPACT + TURNED), "a sequence with compact trees or turned subtrees")
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

    def body(self, name, number=0):
        key = (name.encode(), number)
        found = [b for e, b in zip(self.table, self.bodies) if (e["type"], e["ordinal"]) == key and self.understood(e)]
        return found[0] if found else None

    def rows(self, name, number=0):
        body = self.body(name, number)
        require(body is not None, "%s cannot be read" % name)
        return np.frombuffer(body, RECORDS[name][1])


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
