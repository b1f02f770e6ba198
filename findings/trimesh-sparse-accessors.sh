#!/usr/bin/env bash
# trimesh 5.2.0: the substituted values of a sparse glTF accessor are dropped without a word; vertices stand where they were before.
#
# Expected: a sparse accessor is its buffer view, or zeros where there is none, with some elements replaced (glTF 2.0, section 3.6.2.3).
# That is core glTF, no extension.
# Seen: the replacements are not read. A triangle whose third corner is moved from y = 1 to y = 5 loads with y = 1, and one that is
# made of replacements alone has all three corners at the origin. Counts are right; the accessor's own min and max contradict what comes out.
# Hurts: models that optimisers wrote with sparse positions: boxes, volumes and ray hits are those of another shape.
# bvhc: puts the values in (tests/independent/corners.py, cases "sparse_alone" and "sparse_over").
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check trimesh==5.2.0 numpy==2.2.6
cat > "$work/run.py" <<'PY'
import base64, io, json
import numpy as np, trimesh

def model(base, numbers, values):
    """A model of one triangle whose positions are `base`, or zeros, with `values` put in at `numbers`."""
    pieces = [np.array(numbers, np.uint16).tobytes(), np.array(values, np.float32).tobytes()]
    sparse = {"count": len(numbers), "indices": {"bufferView": 0, "componentType": 5123}, "values": {"bufferView": 1}}
    positions = {"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse, "min": [0, 0, 0], "max": [1, 5, 0]}
    if base:
        pieces.append(np.array(base, np.float32).tobytes())
        positions["bufferView"] = 2
    data, views = b"", []
    for piece in pieces:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(piece)})
        data += piece + b"\0" * (-len(piece) % 4)
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [positions],
        "bufferViews": views, "buffers": [{"byteLength": len(data), "uri": uri}],
    })

for name, text in (
    ("one corner replaced:", model([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [2], [[0, 5, 0]])),
    ("no buffer view:", model(None, [1, 2], [[1, 0, 0], [0, 5, 0]])),
):
    scene = trimesh.load_scene(io.BytesIO(text.encode()), file_type="gltf", process=False)
    mesh = scene.to_mesh()
    print(name, len(mesh.faces), "triangle, area", float(mesh.area), "last corner", mesh.vertices[-1].tolist())
PY
"$work/venv/bin/python" "$work/run.py" | tee "$work/out"
expected='one corner replaced: 1 triangle, area 0.5 last corner [0.0, 1.0, 0.0]
no buffer view: 1 triangle, area 0.0 last corner [0.0, 0.0, 0.0]'
if [ "$(cat "$work/out")" != "$expected" ]; then
    printf 'CHANGED: trimesh 5.2.0 reads sparse accessors otherwise. Seen before:\n%s\n' "$expected" >&2
    exit 1
fi
echo "as described: areas 0.5 and 0; both triangles have an area of 2.5 and their last corner at (0, 5, 0)"
