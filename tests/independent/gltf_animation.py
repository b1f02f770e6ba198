"""A glTF 2.0 document posed at one time of one animation. Numbers in brackets are sections of the specification."""

import numpy as np

from model import Refused, Unsupported

WIDTHS = {"translation": "VEC3", "rotation": "VEC4", "scale": "VEC3", "weights": "SCALAR"}


def pose(document, number, time):
    """Give the nodes what animation `number` makes of them at `time` seconds [3.11]. All else keeps what the file gives it."""
    animation = document.item("animations", number)
    samplers = document.list(animation, "samplers")
    moved = set()
    for channel in document.list(animation, "channels"):
        target = channel["target"]
        path = target.get("path")
        if path == "pointer":
            pointer = target.get("extensions", {}).get("KHR_animation_pointer", {}).get("pointer", "")
            if pointer.startswith(("/nodes/", "/meshes/")):
                raise Unsupported("KHR_animation_pointer moves %s" % pointer)
            continue
        if "node" not in target or path not in WIDTHS:
            continue
        n = document.integer(target["node"], "node")
        node = document.item("nodes", n)
        if "matrix" in node and path != "weights":
            raise Refused("node %d has a matrix and is animated" % n)
        if (n, path) in moved:
            raise Refused("two channels move the %s of node %d" % (path, n))
        moved.add((n, path))
        sampler = samplers[document.integer(channel["sampler"], "sampler")]
        node[path] = sample(document, sampler, path, time).tolist()


def sample(document, sampler, path, time):
    """The value at a time [3.11, appendix C]: the first key's before it, the last key's after it, a key's own at its time."""
    times, _ = document.stored(document.integer(sampler["input"], "input"), ("SCALAR",))
    times = times[:, 0]
    if len(times) == 0 or (np.diff(times) < 0).any() or not np.isfinite(times).all():
        raise Refused("key times do not increase")
    interpolation = sampler.get("interpolation", "LINEAR")
    if interpolation not in ("STEP", "LINEAR", "CUBICSPLINE"):
        raise Refused("the interpolation is %r" % interpolation)
    values = normalised(document, document.integer(sampler["output"], "output"), WIDTHS[path])
    parts = 3 if interpolation == "CUBICSPLINE" else 1
    width = values.size // (len(times) * parts)
    if width == 0 or values.size != len(times) * parts * width:
        raise Refused("a sampler has %d keys and %d numbers" % (len(times), values.size))
    values = values.reshape(len(times), parts, width)
    own = values[:, parts // 2]

    before = int(np.searchsorted(times, np.float32(time), side="right")) - 1
    if before < 0:
        return own[0]
    if before == len(times) - 1 or times[before] == np.float32(time) or interpolation == "STEP":
        return own[before]
    span = float(times[before + 1]) - float(times[before])
    t = (time - float(times[before])) / span
    if interpolation == "LINEAR":
        return slerp(own[before], own[before + 1], t) if path == "rotation" else own[before] * (1 - t) + own[before + 1] * t
    leaving, arriving = values[before, 2], values[before + 1, 0]
    return ((2 * t**3 - 3 * t**2 + 1) * own[before] + span * (t**3 - 2 * t**2 + t) * leaving
            + (-2 * t**3 + 3 * t**2) * own[before + 1] + span * (t**3 - t**2) * arriving)


def normalised(document, index, kind):
    """Integers are fractions here, whether the accessor says so or not [3.11]."""
    values, _ = document.stored(index, (kind,))
    out = values.astype(np.float64)
    return out if values.dtype.kind == "f" else np.maximum(out / float(np.iinfo(values.dtype).max), -1.0)


def slerp(a, b, t):
    """Along the shorter arc [C.4]; a turn has no length. Where both arcs are equally long the sign of 0 is taken as +."""
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    cosine = float(a @ b)
    if cosine < 0:
        b, cosine = -b, -cosine
    angle = np.arctan2(np.linalg.norm(b - a * cosine), cosine)
    if angle < 1e-9:
        return a * (1 - t) + b * t
    return (np.sin((1 - t) * angle) * a + np.sin(t * angle) * b) / np.sin(angle)
