"""Records, flags and constants of the .bvhc file, as SPEC.md has them; numbers in brackets are its sections. Used by bvhc_reader.py."""

import numpy as np

try:
    import blake3
except ImportError:
    blake3 = None

MINOR = 5  # that this reader knows
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
    "OROW": (2, np.dtype([("axes", "<f4", 9), ("first", U4), ("end", U4), ("node_offset", U4), ("reserved", "V16")])),
    "ONOD": (2, NODE),
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
TURNED = ["OROW", "ONOD"]  # that a still file of one level may have, both or none [5.8]
NEST = 3  # turned subtrees in one another [5.8]
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
