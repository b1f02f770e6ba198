"""Wavefront OBJ, read by the format's description ("Object Files (.obj)", Advanced Visualizer, appendix B1).

Statements other than v, f, o, g and usemtl place no triangle, but for fo, which older files have for f. Numbers are read as f64. What the description leaves open is said where
it is decided.
"""

import re

import numpy as np

from model import NO_NODE, Model, Part, Placement, Polygon, Refused

STATEMENTS = frozenset(
    b"v vt vn vp cstype deg bmat step p l f curv curv2 surf parm trim hole scrv sp end con g s mg o bevel c_interp d_interp lod "
    b"usemtl mtllib shadow_obj trace_obj ctech stech maplib usemap call csh fo bsp bzp cdc cdp res".split())
ELEMENTS = frozenset(b"p l curv curv2 surf".split())
# A file of more would have more than a hundred gigabytes.
MOST_VERTICES = 1 << 35


def read(data):
    """The model in the bytes of an OBJ file. It is one mesh without a node; a part is a run of faces of one object, group, material."""
    lines = statements(data)
    model, vertices = Model(), []
    state = State()
    known = False
    for line in lines:
        words = line.split(None, 1)
        key, rest = words if len(words) == 2 else (line, b"")
        if key == b"v":
            vertices.append(rest)
        elif key in (b"f", b"fo"):
            state.face(rest.split(), len(vertices), model)
        elif key == b"o":
            # Two objects of one name are two objects: the statement begins one.
            state.objects += 1
            state.object = rest
        elif key == b"g":
            state.group = rest
        elif key == b"usemtl":
            state.material = rest
        elif key in ELEMENTS:
            model.skipped += 1
        elif not key or key in STATEMENTS:
            pass
        elif key not in state.unknown:
            state.unknown.add(key)
            model.fault("an unknown statement %r" % key[:20].decode("latin-1"))
        known = known or key in STATEMENTS
    if not known:
        if any(lines):
            raise Refused("there is no OBJ statement in it")
        model.fault("it is empty")
    positions = parse_vertices(vertices, model)
    place(state, positions, model)
    return model


def statements(data):
    """The lines of the file, without comments, white space at both ends, and with continued lines joined.

    Lines are joined by a backslash at the end of a line; white space behind it is nothing that could be seen, and behind the last line
    there is nothing to join. Comments "are not processed", so that a line of comment ends where it ends.
    """
    # Several writers round a file up to a block with zeros: they stand behind the text and say nothing.
    # So does the sign that ended texts of DOS.
    data = data.rstrip(b"\0\x1a \t\r\n")
    if b"\0" in data:
        raise Refused("a zero byte stands in the text")
    if data[:3] == b"\xef\xbb\xbf":
        data = data[3:]
    lines = [line.strip() for line in data.splitlines()]
    if b"\\" in data:
        lines = joined(lines)
    if b"#" in data:
        # A name may hold the sign, so that only a line of numbers ends there.
        lines = [without_comment(line) if b"#" in line else line for line in lines]
    return lines


def joined(lines):
    out, begun = [], None
    for line in lines:
        whole = line if begun is None else (begun + b" " + line).strip()
        begun = None
        if line[-1:] == b"\\" and whole[:1] != b"#":
            begun = whole[:-1]
        else:
            out.append(whole)
    return out if begun is None else out + [begun.strip()]


def without_comment(line):
    if line[:1] == b"#":
        return b""
    return re.split(rb"\s#", line, maxsplit=1)[0].rstrip() if line[:1] in (b"v", b"f") else line


class State:
    """Where in the file the reader is, and the faces so far."""

    def __init__(self):
        self.objects, self.object, self.group, self.material = 0, b"", b"", b""
        self.unknown = set()
        self.corners, self.sizes, self.face_counts, self.highest = [], [], [], 0
        self.run, self.names, self.first_faces = None, [], []

    def face(self, tokens, vertices, model):
        if len(tokens) < 3:
            # "A minimum of three vertices are required": the tool and every loader leave such a face out.
            model.skipped += 1
            model.fault("a face of fewer than three corners")
            return
        run = (self.objects, self.group, self.material)
        if run != self.run:
            self.run = run
            self.names.append((self.object, self.group))
            self.first_faces.append(len(self.sizes))
        for token in tokens:
            try:
                index = int(token.partition(b"/")[0] if b"/" in token else token)
            except ValueError:
                raise Refused("a face has the corner %r" % token[:20].decode("latin-1"))
            if index < 0:
                index += vertices + 1
                if index < 1:
                    raise Refused("a face counts back to before the first vertex")
            elif index == 0:
                raise Refused("a face uses vertex 0; the first is 1")
            elif index > MOST_VERTICES:
                raise Refused("a face uses vertex %.30s" % index)
            elif index > vertices:
                # Vertices are to precede the elements that use them. Most loaders look them up at the end.
                model.fault("a face uses a vertex that comes later")
            self.corners.append(index - 1)
        self.sizes.append(len(tokens))


def parse_vertices(lines, model):
    """f64[n, 3]. A fourth number is the weight of rational curves and surfaces, and no part of a polygon's corner."""
    rows = [line.split(None, 3)[:3] for line in lines]
    if any(len(row) < 3 for row in rows):
        raise Refused("a vertex of fewer than three numbers")
    flat = [number for row in rows for number in row]
    try:
        values = np.array(list(map(float, flat)), dtype=np.float64).reshape(-1, 3)
    except ValueError:
        values = np.array([odd_number(number) for number in flat], dtype=np.float64).reshape(-1, 3)
    if any(b"_" in number for number in flat):
        raise Refused("a vertex is no number: it has an underscore")
    # A number beyond f64 is one all the same, not an infinity that someone wrote.
    for i in np.flatnonzero(np.isinf(values.reshape(-1))).tolist():
        if b"i" not in flat[i].lower():
            values.reshape(-1)[i] = np.copysign(np.finfo(np.float64).max, values.reshape(-1)[i])
    return values


def odd_number(text):
    """A number, or what C libraries of Microsoft's print where there is none: 1.#IND, -1.#INF, 1.#QNAN; later -nan(ind)."""
    if re.fullmatch(rb"[+-]?(1\.#\w+|nan\(\w*\))", text, re.IGNORECASE):
        return float("nan")
    try:
        return float(text)
    except ValueError:
        raise Refused("a vertex has the number %r" % text[:20].decode("latin-1"))


def place(state, positions, model):
    """Cut faces into triangles and make them the parts of the one mesh. A polygon's cut is a fan here; see `polygons`."""
    corners, sizes = np.array(state.corners, dtype=np.int64), np.array(state.sizes, dtype=np.int64)
    if len(corners) and corners.max() >= len(positions):
        raise Refused("a face uses vertex %d of %d" % (corners.max() + 1, len(positions)))
    starts = np.cumsum(sizes) - sizes
    counts = sizes - 2
    first_prims = np.cumsum(counts) - counts
    triangles = np.empty((int(counts.sum()), 3), dtype=np.int64)
    for size in np.unique(sizes):
        faces = np.flatnonzero(sizes == size)
        for i in range(size - 2):
            rows = first_prims[faces] + i
            triangles[rows] = np.stack([corners[starts[faces]], corners[starts[faces] + i + 1], corners[starts[faces] + i + 2]], axis=1)
    is_cut = np.repeat(sizes > 3, counts)
    bounds = [int(first_prims[f]) for f in state.first_faces] + [len(triangles)]
    parts = [
        Part(i, a, positions, triangles[a:b], np.abs(positions), state.names[i], is_cut=is_cut[a:b])
        for i, (a, b) in enumerate(zip(bounds, bounds[1:]))
    ]
    part_of = np.searchsorted(state.first_faces, np.arange(len(sizes)), side="right") - 1
    for f in np.flatnonzero(sizes > 3).tolist():
        part = parts[part_of[f]]
        part.polygons.append(Polygon(int(first_prims[f]) - part.first_prim, corners[starts[f]:starts[f] + sizes[f]]))
    identity = np.eye(4)
    model.placements.append(Placement(0, NO_NODE, 0, identity, identity, parts))
