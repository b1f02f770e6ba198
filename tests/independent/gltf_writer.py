"""Write small glTF files: just enough to say what a test wants to say."""

import base64
import json
import struct

import numpy as np

CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
TRIANGLE = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


class Gltf:
    """A document with one buffer that grows with each accessor. `root` is its JSON."""

    def __init__(self, **root):
        self.data = bytearray()
        self.root = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": [], "meshes": [], "nodes": [], **root}

    def view(self, data, stride=None):
        self.data += bytes(-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        if stride:
            view["byteStride"] = stride
        self.data += data
        self.root["bufferViews"].append(view)
        return len(self.root["bufferViews"]) - 1

    def accessor(self, values, kind="f4", normalized=False, stride=None, lead=0, bare=False, **more):
        """`values` [n] or [n, width]. With `stride`, elements stand so many bytes apart behind `lead` bytes. `bare`: no view, all zeros."""
        values = np.asarray(values)
        values = values.reshape(len(values), -1).astype("<" + kind)
        item = {"componentType": CODES[kind], "count": len(values), "type": KINDS[values.shape[1]], **more}
        if normalized:
            item["normalized"] = True
        if not bare:
            rows = [row.tobytes() for row in values]
            # Vertices start at multiples of 4; indices are packed.
            step = stride or (len(rows[0]) if values.shape[1] == 1 else -(-len(rows[0]) // 4) * 4)
            padded = step != len(rows[0])
            item["bufferView"] = self.view(bytes(lead) + b"".join(row + b"\xee" * (step - len(row)) for row in rows), step if padded else None)
            if lead:
                item["byteOffset"] = lead
        self.root["accessors"].append(item)
        return len(self.root["accessors"]) - 1

    def sparse(self, count, at, values, base=None, index="u2"):
        """A VEC3 accessor of zeros (or of `base`) in which `values` stand at the places `at`."""
        number = self.accessor(np.zeros((count, 3)) if base is None else base, bare=base is None)
        self.root["accessors"][number]["sparse"] = {
            "count": len(at), "indices": {"bufferView": self.view(np.asarray(at).astype("<" + index).tobytes()), "componentType": CODES[index]},
            "values": {"bufferView": self.view(np.asarray(values, "<f4").tobytes())},
        }
        return number

    def primitive(self, positions=TRIANGLE, indices=None, mode=None, kind="u2", attributes=None, **more):
        """`positions` are rows or the number of an accessor."""
        item = {"attributes": {"POSITION": positions if isinstance(positions, int) else self.accessor(positions), **(attributes or {})}, **more}
        if indices is not None:
            item["indices"] = self.accessor(indices, kind)
        if mode is not None:
            item["mode"] = mode
        return item

    def mesh(self, *primitives, **more):
        self.root["meshes"].append({"primitives": list(primitives) or [self.primitive()], **more})
        return len(self.root["meshes"]) - 1

    def node(self, **node):
        self.root["nodes"].append(node)
        return len(self.root["nodes"]) - 1

    def show(self, *nodes):
        self.root["scenes"], self.root["scene"] = [{"nodes": list(nodes)}], 0
        return self

    def require(self, *names):
        self.root["extensionsUsed"] = self.root["extensionsRequired"] = list(names)
        return self

    def document(self):
        root = {key: value for key, value in self.root.items() if value != []}
        if self.data:
            root.setdefault("buffers", [{}])[0]["byteLength"] = len(self.data)
        return root

    def save(self, path, uri=None):
        """As .glb, or as .gltf with the buffer in a data URI or under the reference `uri`."""
        if path.endswith(".glb"):
            return self.save_glb(path)
        root = self.document()
        if self.data:
            root["buffers"][0]["uri"] = uri or "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        with open(path, "w", encoding="utf-8") as file:
            json.dump(root, file)

    def save_glb(self, path, more=b"", pad=b" ", tail=b""):
        """`more` chunks, `pad` to fill up the JSON with (more than one byte: so many at least), and what stands behind the file's end."""
        text = json.dumps(self.document()).encode() + (pad if len(pad) > 1 else b"")
        text += pad[:1] * (-len(text) % 4)
        body = bytes(self.data) + bytes(-len(self.data) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(body), b"BIN\0") + body + more
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks + tail)
