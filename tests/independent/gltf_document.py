"""A glTF 2.0 document: its container, its JSON, its buffers and its accessors. Numbers in brackets are sections of the specification.

An accessor comes out as f64, normalised integers divided [3.11], sparse values put in [3.6.2.3]. Nothing is looked at before it is used.
"""

import base64
import binascii
import json
import os
import re
import struct
from urllib.parse import unquote_to_bytes

import numpy as np

from model import Model, Refused, Unsupported

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}

# What places no triangle may be required and left unread. Anything else that is required must be understood [3.12].
UNDERSTOOD = {"KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_mesh_primitive_restart"}
# Those of them that another reader may refuse by name.
NEED_NOT_BE_KNOWN = {"KHR_mesh_primitive_restart"}
HARMLESS_PREFIXES = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "EXT_lights_")
HARMLESS = {
    "KHR_animation_pointer", "KHR_xmp", "KHR_xmp_json_ld", "EXT_mesh_features", "EXT_structural_metadata", "EXT_instance_features",
    "MSFT_texture_dds", "MSFT_packing_normalRoughnessMetallic", "MSFT_packing_occlusionRoughnessMetallic", "AGI_articulations",
    "AGI_stk_metadata", "CESIUM_primitive_outline", "EXT_lights_image_based",
}

# What the schema requires of the objects of a list, and what else it says of properties that a reader of triangles may look at.
REQUIRED = {
    "buffers": {"byteLength": (int, float)}, "bufferViews": {"buffer": (int, float), "byteLength": (int, float)},
    "accessors": {"componentType": (int, float), "count": (int, float), "type": str}, "meshes": {"primitives": list},
}
OPTIONAL = {
    "accessors": {"name": str, "normalized": bool, "extensions": dict, "sparse": dict, "bufferView": (int, float), "byteOffset": (int, float)},
    "animations": {"name": str, "extensions": dict, "channels": list, "samplers": list}, "buffers": {"uri": str, "name": str, "extensions": dict},
    "bufferViews": {"name": str, "extensions": dict, "byteOffset": (int, float), "byteStride": (int, float)}, "materials": {"name": str},
    "meshes": {"name": str, "weights": list, "extensions": dict}, "scenes": {"name": str, "nodes": list, "extensions": dict},
    "nodes": {"name": str, "weights": list, "children": list, "extensions": dict, "mesh": (int, float), "skin": (int, float), "camera": (int, float)},
    "skins": {"name": str, "joints": list, "extensions": dict, "skeleton": (int, float), "inverseBindMatrices": (int, float)},
}
LISTS = ("accessors", "animations", "buffers", "bufferViews", "cameras", "extensionsRequired", "extensionsUsed", "images", "materials", "meshes",
         "nodes", "samplers", "scenes", "skins", "textures")
# Lists that say by being there that something is meant to be in them.
NOT_TO_BE_EMPTY = {"primitives", "joints", "channels", "samplers"}


def required_is_known(name):
    return name in UNDERSTOOD or name in HARMLESS or name.startswith(HARMLESS_PREFIXES)


class Document:
    """The JSON of a file and its bytes."""

    def __init__(self, path, model=None):
        self.model = model if model is not None else Model()
        self.folder = os.path.dirname(path)
        with open(path, "rb") as file:
            data = file.read()
        self.binary = None
        text = self.read_glb(data) if data[:4] == b"glTF" else data
        self.json = self.read_json(text)
        self.check_version()
        for name in self.list(self.json, "extensionsRequired"):
            if not (isinstance(name, str) and required_is_known(name)):
                raise Unsupported("it requires the extension %s" % name)
            if name in NEED_NOT_BE_KNOWN:
                self.model.fault("it requires the extension %s, which a reader need not know" % name)
        self.buffers = {}
        self.check_schema()

    # The container [4.4].

    def read_glb(self, data):
        if len(data) < 12:
            raise Refused("the GLB header is cut off")
        version, length = struct.unpack_from("<II", data, 4)
        if version != 2:
            raise Unsupported("GLB version %d" % version)
        if length != len(data):
            self.model.fault("the GLB says %d bytes and has %d" % (length, len(data)))
        at, chunks = 12, []
        while at < min(length, len(data)):
            if at + 8 > len(data):
                raise Refused("the header of a GLB chunk is cut off")
            size, kind = struct.unpack_from("<I4s", data, at)
            if at + 8 + size > len(data):
                raise Refused("a GLB chunk is cut off")
            chunks.append((kind, data[at + 8:at + 8 + size]))
            at += 8 + size
        if not chunks or chunks[0][0] != b"JSON":
            raise Refused("the first chunk of the GLB is not its JSON")
        kinds = [kind for kind, _ in chunks]
        for kind in (b"JSON", b"BIN\0"):
            if kinds.count(kind) > 1:
                self.model.fault("the GLB has two chunks %s" % kind.decode("latin-1").rstrip("\0"))
        for kind, body in chunks[1:]:
            if kind == b"BIN\0" and self.binary is None:
                self.binary = body
        return chunks[0][1]

    def read_json(self, text):
        if text[:3] == b"\xef\xbb\xbf":
            self.model.fault("the JSON begins with a byte order mark")
            text = text[3:]
        # JSON ends with its object, and spaces are to pad it [4.4.3.2]. Some writers fill up with zeros, or end a text by the sign that
        # ended texts of DOS; a parser of JSON may accept what is more than JSON (RFC 8259, 9).
        end = text.rstrip(b"\0\x1a \t\r\n")
        if text[len(end):].strip(b" \t\r\n"):
            self.model.fault("the JSON is padded with other than white space")
        try:
            # Names in another encoding than UTF-8 [2.7] place no triangle. Their bytes come as U+DC80 and on.
            value = json.loads(end.decode("utf-8", "surrogateescape"), parse_constant=self.no_constant)
        except (ValueError, RecursionError) as error:
            raise Refused("its JSON: %s" % error)
        if not isinstance(value, dict):
            raise Refused("its JSON is no object")
        try:
            json.dumps(value, ensure_ascii=False).encode("utf-8")
        except UnicodeEncodeError:
            self.model.fault("a text of the JSON is no Unicode")
        return self.without_nothings(value)

    def without_nothings(self, value):
        """By the schema no property is null, and no list is empty. Writers mean a property that is not there."""
        if isinstance(value, list):
            return [self.without_nothings(item) if isinstance(item, (dict, list)) else item for item in value]
        out = {}
        for key, item in value.items():
            if key == "extras":
                continue
            if item is None or item == []:
                self.model.fault("%s is %s" % (key, "null" if item is None else "empty"))
                if item is None or key not in NOT_TO_BE_EMPTY:
                    continue
            out[key] = self.without_nothings(item) if isinstance(item, (dict, list)) and key != "extensions" else item
        return out

    @staticmethod
    def no_constant(text):
        raise ValueError("%s is no JSON number" % text)

    def check_version(self):
        """[3.2]: `minVersion` says what a reader must know, `version` what the file was written for."""
        asset = self.json.get("asset")
        if not isinstance(asset, dict) or not isinstance(asset.get("version"), str):
            raise Refused("it has no asset.version")
        for key in ("version", "minVersion"):
            version = asset.get(key)
            if version is None:
                continue
            major, dot, minor = str(version).partition(".")
            if not (dot and major.isdigit() and minor.isdigit()):
                raise Refused("asset.%s is %r" % (key, version))
            if int(major) != 2 or (key == "minVersion" and int(minor) > 0):
                raise Unsupported("it needs glTF %s" % version)

    # Values of the JSON.

    def list(self, parent, key):
        value = parent.get(key, [])
        if not isinstance(value, list):
            raise Refused("%s is no list" % key)
        return value

    def item(self, kind, index):
        items = self.list(self.json, kind)
        index = self.integer(index, kind)
        if index >= len(items):
            raise Refused("%s %d of %d" % (kind, index, len(items)))
        if not isinstance(items[index], dict):
            raise Refused("%s %d is no object" % (kind, index))
        return items[index]

    def integer(self, value, what):
        """JSON has one kind of number: 1.0 and 1e0 are integers, too."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or value != int(value) or value < 0:
            raise Refused("%s is %r, no number of an item or count" % (what, value))
        return int(value)

    def number(self, parent, key, default=None):
        value = parent.get(key)
        if value is None:
            if default is None:
                raise Refused("%s is missing" % key)
            return default
        return self.integer(value, key)

    def check_schema(self):
        """What the schema says of objects, used or not: a reader may refuse a file for any of it."""
        root = self.json
        for key in LISTS:
            if key in root and not isinstance(root[key], list):
                self.model.fault("%s is no list" % key)
        for kind in sorted(REQUIRED.keys() | OPTIONAL.keys()):
            items = root.get(kind, [])
            for i, item in enumerate(items if isinstance(items, list) else []):
                self.check_object(item, "%s %d" % (kind, i), REQUIRED.get(kind, {}), OPTIONAL.get(kind, {}))
                for primitive in item.get("primitives", []) if kind == "meshes" and isinstance(item, dict) else []:
                    self.check_object(primitive, "a primitive of mesh %d" % i, {"attributes": dict}, {
                        "indices": (int, float), "material": (int, float), "mode": (int, float), "targets": list, "extensions": dict})
        for i, node in enumerate(self.list(root, "nodes")):
            if not isinstance(node, dict):
                continue
            lists = [node[key] for key in ("matrix", "translation", "rotation", "scale") if isinstance(node.get(key), list)]
            if not all(isinstance(x, (int, float)) and abs(x) < float("inf") for numbers in lists for x in numbers):
                self.model.fault("a number of node %d is not finite" % i)
            matrix = node.get("matrix")
            if isinstance(matrix, list) and len(matrix) == 16 and matrix[3::4] != [0, 0, 0, 1]:
                self.model.fault("the matrix of node %d is not affine" % i)

    def check_object(self, item, what, required, optional):
        if not isinstance(item, dict):
            self.model.fault("%s is no object" % what)
            return
        for key, types in {**optional, **required}.items():
            value = item.get(key)
            if value is None and key in required:
                self.model.fault("%s has no %s" % (what, key))
            elif value is not None and (not isinstance(value, types) or isinstance(value, bool) and types != bool):
                self.model.fault("the %s of %s is %.20r" % (key, what, value))
            elif types == (int, float) and value is not None and not (value >= 0 and value == value // 1):
                self.model.fault("the %s of %s is %r" % (key, what, value))

    # Buffers [3.6.1].

    def buffer(self, index):
        if index not in self.buffers:
            item = self.item("buffers", index)
            length = self.number(item, "byteLength")
            uri = item.get("uri")
            if uri is None:
                if index != 0 or self.binary is None:
                    raise Refused("buffer %d has no data" % index)
                data = self.binary
            elif not isinstance(uri, str):
                raise Refused("the uri of buffer %d is no text" % index)
            else:
                data = data_uri(uri, self.model) if uri[:5].lower() == "data:" else self.external(uri, index)
            if len(data) < length:
                raise Refused("buffer %d has %d of %d bytes" % (index, len(data), length))
            self.buffers[index] = data[:length]
        return self.buffers[index]

    def external(self, uri, index):
        """A relative reference by RFC 3986; then the names as some exporters write them."""
        colon = uri.find(":")
        if colon > 0 and "/" not in uri[:colon] and uri[:colon].isalnum():
            raise Refused("buffer %d is at %s" % (index, uri))
        if uri.startswith("/"):
            raise Refused("buffer %d has an absolute path" % index)
        path = uri.partition("#")[0].partition("?")[0]
        decoded = [os.fsdecode(unquote_to_bytes(path)), uri]
        for name in decoded + [name.replace("\\", "/") for name in decoded]:
            if "\0" in name:
                raise Refused("buffer %d has a zero byte in its name" % index)
            name = without_dots(name)
            if name.split("/")[0] in ("..", ""):
                raise Refused("buffer %d is outside of the model's folder" % index)
            if re.match("[A-Za-z]:", name):
                self.model.fault("buffer %d names a drive, where there are drives" % index)
            full = os.path.join(self.folder, name)
            if os.path.isfile(full):
                with open(full, "rb") as file:
                    return file.read()
        raise Refused("buffer %d names %s, which is not there" % (index, uri))

    def view(self, index):
        item = self.item("bufferViews", index)
        data = self.buffer(self.number(item, "buffer"))
        start, length = self.number(item, "byteOffset", 0), self.number(item, "byteLength")
        if start + length > len(data):
            raise Refused("bufferView %d leaves its buffer" % index)
        return data[start:start + length], item.get("byteStride")

    # Accessors [3.6.2].

    def rows(self, view, offset, count, component, width, what):
        """`count` elements as the file stores them, [count, width]."""
        if component not in COMPONENTS:
            raise Refused("componentType %r of %s" % (component, what))
        kind = np.dtype(COMPONENTS[component])
        data, stride = self.view(view)
        size = kind.itemsize * width
        stride = size if stride is None else self.integer(stride, "byteStride")
        if count == 0:
            return np.empty((0, width), dtype=kind)
        if stride < size:
            raise Refused("byteStride %d of %s is less than an element" % (stride, what))
        if offset + stride * (count - 1) + size > len(data):
            raise Refused("%s leaves its bufferView" % what)
        if offset % kind.itemsize:
            self.model.fault("%s is not aligned" % what)
        raw = np.frombuffer(data, np.uint8)
        elements = np.lib.stride_tricks.as_strided(raw[offset:], (count, size), (stride, 1))
        return np.ascontiguousarray(elements).view(kind)

    def stored(self, index, types):
        """An accessor's elements as they are stored, sparse values put in, and whether they are normalised."""
        item, what = self.item("accessors", index), "accessor %d" % index
        count, kind, component = self.number(item, "count"), item.get("type"), item.get("componentType")
        if kind not in types:
            raise Refused("%s is %r, not %s" % (what, kind, " or ".join(types)))
        if component not in COMPONENTS:
            raise Refused("componentType %r of %s" % (component, what))
        width = WIDTHS[kind]
        if item.get("bufferView") is None:
            # No view: zeros, which sparse values may replace.
            if count > 1 << 26:
                raise Refused("%s has %d elements" % (what, count))
            values = np.zeros((count, width), dtype=COMPONENTS[component])
        else:
            view = self.integer(item["bufferView"], "bufferView")
            values = self.rows(view, self.number(item, "byteOffset", 0), count, component, width, what)
        sparse = item.get("sparse")
        if sparse is not None:
            values = self.substituted(values, sparse, count, component, width, what)
        return values, bool(item.get("normalized", False))

    def substituted(self, values, sparse, count, component, width, what):
        if not isinstance(sparse, dict):
            raise Refused("%s: sparse is no object" % what)
        number = self.number(sparse, "count")
        places, new = sparse.get("indices"), sparse.get("values")
        if not isinstance(places, dict) or not isinstance(new, dict):
            raise Refused("%s: sparse without indices or values" % what)
        if places.get("componentType") not in (5121, 5123, 5125):
            raise Refused("%s: sparse indices of type %r" % (what, places.get("componentType")))
        at = self.rows(self.number(places, "bufferView"), self.number(places, "byteOffset", 0), number, places["componentType"], 1, what)
        rows = self.rows(self.number(new, "bufferView"), self.number(new, "byteOffset", 0), number, component, width, what)
        at = at[:, 0].astype(np.int64)
        if (at >= count).any():
            raise Refused("%s: a sparse index is not in it" % what)
        if (np.diff(at) <= 0).any():
            self.model.fault("%s: sparse indices do not increase" % what)
        values = values.copy()
        values[at] = rows
        return values

    def floats(self, index, types):
        """f64[count, width] [3.6.2.2]: integers that are normalised are divided by the largest of their type."""
        values, normalised = self.stored(index, types)
        out = values.astype(np.float64)
        if normalised and values.dtype.kind != "f":
            out = np.maximum(out / float(np.iinfo(values.dtype).max), -1.0)
        return out

    def indices(self, index):
        values, _ = self.stored(index, ("SCALAR",))
        if values.dtype.kind != "u":
            raise Refused("the indices of accessor %d are not unsigned" % index)
        return values[:, 0].astype(np.int64), int(np.iinfo(values.dtype).max)


def without_dots(path):
    """A relative path without the segments `.` and `..`, by RFC 3986, 5.2.4, but that `..` stay where nothing stands before them."""
    segments = path.split("/")
    out = []
    for i, segment in enumerate(segments):
        if segment == ".." and out and out[-1] != "..":
            out.pop()
        elif segment != ".":
            out.append(segment)
            continue
        # What ends in a dot segment is a folder.
        if i == len(segments) - 1:
            out.append("")
    return "/".join(out)


def data_uri(uri, model):
    """The bytes of a data URI by RFC 2397: data:[type][;parameter=value]*[;base64],data. A fragment behind it is none of it (RFC 3986, 3.5)."""
    head, comma, body = uri[5:].partition("#")[0].partition(",")
    if not comma:
        raise Refused("a data URI has no comma")
    data = unquote_to_bytes(body)
    if head.split(";")[-1].strip().lower() != "base64":
        return data
    data = b"".join(data.split())
    if len(data) - len(data.rstrip(b"=")) > -len(data.rstrip(b"=")) % 4:
        model.fault("a data URI has more padding than it needs")
    try:
        return base64.b64decode(data + b"=" * (-len(data) % 4), validate=True)
    except binascii.Error as error:
        raise Refused("a data URI: %s" % error)
