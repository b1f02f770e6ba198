#!/usr/bin/env python3
"""Ways to predict the vertices of a pose, and what is left of them: bytes a triangle and frame of raw sequences, first poses not counted.

    benches/predictors.py SEQUENCE.bvhc…      needs numpy and zstandard (format-spec/requirements.txt)

Residuals are folded differences of the numbers' bits in byte planes, packed by zstd at level 9, as codec 2 of the format has them with a scale of 0.
"""

import sys
from pathlib import Path

import numpy as np
import zstandard

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "format-spec" / "reference"))
import bvhc_reader  # noqa: E402

PACK = zstandard.ZstdCompressor(level=9)


def ordered(x):
    """The bits of f32 numbers as integers that grow with them."""
    bits = np.ascontiguousarray(x, np.float32).view(np.int32)
    return bits ^ ((bits >> 31) & 0x7FFFFFFF)


def left(pose, predicted):
    """Bytes of what is left."""
    rest = ordered(pose) - ordered(predicted)
    planes = ((rest << 1) ^ (rest >> 31)).view(np.uint8).reshape(len(pose), 12).T
    return len(PACK.compress(np.ascontiguousarray(planes).tobytes()))


def vertex_before(base, pose, _):
    """As the vertex before moved."""
    out = base.copy()
    out[1:] += pose[:-1] - base[:-1]
    return out


def map_of_64(base, pose, _):
    """One affine map for 64 vertices each, as rounded to f32; it has to be stored."""
    out = np.empty_like(pose)
    for i in range(0, len(base), 64):
        points = np.c_[base[i : i + 64].astype(float), np.ones(len(base[i : i + 64]))]
        fitted = np.linalg.lstsq(points, pose[i : i + 64].astype(float), rcond=None)[0].astype(np.float32)
        out[i : i + 64] = points @ fitted
    return out


def eight_before(base, pose, first):
    """As the affine map by which the eight vertices before moved, fitted where they stand in the first pose."""
    first, moved, count = first.astype(float), pose.astype(float) - base, len(base)
    rows = np.arange(count)[:, None] - np.arange(1, 9)
    there, rows = rows >= 0, np.maximum(rows, 0)
    offset = first[rows] - first[:, None]
    square = (offset**2).sum(2)
    near = there / (square + 2.0**-40 * square.max(1, keepdims=True) + 1e-300)
    total = np.maximum(near.sum(1, keepdims=True), 1e-300)
    mean = (near[..., None] * offset).sum(1) / total
    apart = offset - mean[:, None]
    scatter = np.einsum("nk,nki,nkj->nij", near, apart, apart)
    ridge = np.trace(scatter, axis1=1, axis2=2) * 2.0**-10 + 2.0**-24
    slope = np.linalg.solve(scatter + ridge[:, None, None] * np.eye(3), mean[..., None])[..., 0]
    weight = near * (1 / total - np.einsum("nki,ni->nk", apart, slope))
    return (base + np.einsum("nk,nki->ni", weight, moved[rows])).astype(np.float32)


def vertices(cache, pose, topology):
    """The vertices of a pose."""
    block = np.frombuffer(cache.body("VPOS", int(pose["block"])), "<f4").reshape(-1, 3)
    return block[int(pose["vertex_offset"]) :][: int(topology["vertex_count"])]


def main():
    names = ["frame before", "first frame", "line through two", "vertex before", "map of 64", "eight before", "eight before, short ways"]
    print("| file | %s |\n|---|%s" % (" | ".join(names), "--:|" * len(names)))
    for path in sys.argv[1:]:
        cache = bvhc_reader.File(Path(path).read_bytes())
        rows = cache.rows("POSE")
        sums, triangles = np.zeros(len(names)), 0
        for topology, row in enumerate(cache.rows("TOPO")):
            poses = [vertices(cache, pose, row) for pose in rows if pose["topology"] == topology]
            for i in range(1, len(poses)):
                pose, before, first, way = poses[i], poses[i - 1], poses[0], poses[i & (i - 1)]
                line = 2 * before - poses[i - 2] if i > 1 else before
                sums += [
                    left(pose, before),
                    left(pose, first),
                    left(pose, line),
                    left(pose, vertex_before(before, pose, first)),
                    left(pose, map_of_64(before, pose, first)) + 48 * -(-len(pose) // 64),
                    left(pose, eight_before(before, pose, first)),
                    left(pose, eight_before(way, pose, first)),
                ]
                triangles += int(row["prim_count"])
        print("| %s | %s |" % (Path(path).name, " | ".join("%.2f" % (x / max(triangles, 1)) for x in sums)))


if __name__ == "__main__":
    main()
