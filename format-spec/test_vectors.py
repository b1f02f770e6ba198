"""Compare three readings of every valid vector: the tool's, the reference reader's and the Kaitai parser's.

Called by test.sh, which knows where everything stands. Besides the vectors, the samples are built with the tool (raw and compressed,
one level and two) so that files of real size are compared too. Invalid vectors must be refused by the reference reader.
"""

import argparse
import json
import math
import os
import random
import subprocess
import sys
import traceback
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "reference"))
import bvhc_reader
import bvhc_trace

RAYS = 60
# Rules that the reference reader does not prove: the memory limit is the user's, E06 needs the model; and warnings (W) are not errors.
LEFT_TO_THE_TOOL = {"E0127", "E06", "W01", "W04", "W05", "W07"}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--parser", "--tool", "--tracer", "--scratch"):
        parser.add_argument(option, required=True)
    arguments = parser.parse_args()
    sys.path.insert(0, arguments.parser)
    import bvhc  # compiled from bvhc.ksy

    valid = sorted((HERE / "vectors" / "valid").glob("*.bvhc"))
    if not valid:
        sys.exit("no valid vectors below %s" % (HERE / "vectors" / "valid"))
    files = valid + build_samples(Path(arguments.tool), Path(arguments.scratch))
    failures = 0
    for path in files:
        try:
            rays, hits = compare(path, bvhc, arguments)
            print("ok    %-42s info, records and %d rays (%d hits) agree" % (path.name, rays, hits))
        except Exception as error:
            failures += 1
            print("FAIL  %s: %s" % (path.name, error))
            if not isinstance(error, AssertionError):
                traceback.print_exc()
    failures += refuse_invalid(sorted((HERE / "vectors" / "invalid").rglob("*.bvhc")))
    print("%d files compared, %d failures" % (len(files), failures))
    sys.exit(1 if failures else 0)


def build_samples(tool, scratch):
    """A few caches of real size: spatial splits, two levels, flattened, compressed, sequences as differences."""
    scratch.mkdir(parents=True, exist_ok=True)
    samples = HERE.parent / "samples"
    made = []
    for name, model, options in [
        ("colonnade-sbvh", "colonnade.obj", []),
        ("helicopter-binned", "helicopter/heli.0001.obj", ["--method", "binned"]),
        ("forest-two-level", "forest.glb", []),
        ("forest-flat", "forest.gltf", ["--flatten"]),
        ("colonnade-vertices", "colonnade.obj", ["--vertices"]),
        ("forest-vertices", "forest.glb", ["--flatten", "--vertices"]),
        ("colonnade-compact", "colonnade.obj", ["--nodes", "compact8"]),
        ("forest-compact", "forest.glb", ["--nodes", "compact8"]),
        ("roof-turned", "corrugated_roof.obj", ["--orient"]),
        ("helicopter-rebuilt", "helicopter/heli.####.obj", ["--frames", "1-2", "--method", "sbvh", "--refit", "never", "--codec", "compact"]),
        ("helicopter-refitted", "helicopter/heli.####.obj", ["--frames", "1-6", "--refit", "always", "--codec", "compact"]),
    ]:
        out = scratch / (name + ".bvhc")
        run([tool, "build", samples / model, "-o", out, "--force", "-q", *options])
        made.append(out)
    [moved] = json.loads(run([tool, "info", "--json", made[-1]]))["files"]
    as_differences = {s["type"] for s in moved["sections"] if s["codec"] == "delta"}
    assert as_differences == set(bvhc_reader.DIFFERENCES), "of %s these are stored as differences: %s" % (made[-1].name, as_differences)
    packed = scratch / "forest-zstd.bvhc"
    run([tool, "convert", scratch / "forest-two-level.bvhc", "-o", packed, "--codec", "zstd", "-q"])
    return made + [packed]


def run(command, **options):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)
    if done.returncode:
        raise AssertionError("%s: exit status %d\n%s" % (" ".join(map(str, command)), done.returncode, done.stderr))
    return done.stdout


def compare(path, bvhc, arguments):
    file = bvhc_reader.File(path.read_bytes())
    document = json.loads(run([arguments.tool, "info", "--json", path]))
    assert document["schema"] == "bvhc.info.v1" and len(document["files"]) == 1, "info: %s" % document
    ours, theirs = {"path": str(path), **bvhc_reader.info(file)}, document["files"][0]
    for key in sorted(ours.keys() | theirs.keys()):
        assert ours.get(key) == theirs.get(key), "%s: reader %r, tool %r" % (key, ours.get(key), theirs.get(key))
    compare_parser(file, bvhc.Bvhc.from_file(str(path)), bvhc.Bvhc)
    bounds = [np.asarray(file.header[k], float) for k in ("scene_min", "scene_max")]
    if not file.sequence:
        return compare_rays(path, file, bounds, [arguments.tracer, path])
    of_frames = [
        compare_rays(path, file.frame(i), bounds, [arguments.tracer, path, number]) for i, number in enumerate(file.fram["number"])
    ]
    return tuple(map(sum, zip(*of_frames)))


def compare_parser(file, parsed, kaitai):
    """Header and table field by field, every record of every raw section, META and names."""
    same_fields(file.header, parsed.header, "header")
    assert len(parsed.sections) == len(file.table), "number of sections"
    for entry, section, body in zip(file.table, parsed.sections, file.bodies):
        name = entry["type"].decode("latin-1")
        assert int(section.kind) == int.from_bytes(entry["type"], "little"), "%s: type" % name
        same_fields({k: v for k, v in entry.items() if k != "type"}, section, name)
        layout, read = kaitai.Layout(section.layout), section.body
        if layout == kaitai.Layout.zstd:
            assert sum(map(len, read.frames)) + 8 + 4 * read.num_frames == entry["stored_len"], "%s: frames" % name
        elif layout == kaitai.Layout.names:
            names = [row.text.encode() for row in read.rows]
            assert names == (file.names if name == "NAMS" else file.materials), name
            assert b"".join(names) == read.text and len(names) == len(file.geom), name
        elif layout == kaitai.Layout.meta:
            m = file.meta
            assert (read.tool.value, read.tool_version.value, read.method.value) == (m.tool, m.tool_version, m.method), "META"
            assert [(o.name.value, o.value.value) for o in read.options] == m.options, "META options"
            assert [(i.role, i.name.value, i.len, i.blake3) for i in read.inputs] == m.inputs, "META inputs"
            assert [(c.name.value, c.count) for c in read.read_counts] == m.read_counts, "META read_counts"
            assert [n.value for n in read.notes] == m.notes and read.builder_revision == m.revision, "META notes"
        elif layout != kaitai.Layout.unknown:
            rows = np.frombuffer(body, bvhc_reader.RECORDS[name][1])
            assert len(read.rows) == len(rows), "%s: records" % name
            for i, (record, row) in enumerate(zip(rows, read.rows)):
                same_fields(bvhc_reader.plain(record), row, "%s[%d]" % (name, i))


def same_fields(record, parsed, where):
    for field, value in record.items():
        other = getattr(parsed, field)
        if isinstance(value, np.ndarray):
            value = value.tolist()
            other = [other.x, other.y, other.z] if hasattr(other, "x") else list(other)
        assert other == value, "%s.%s: reader %r, parser %r" % (where, field, value, other)


def compare_rays(path, trees, bounds, tracer):
    """The same rays through the tool and the reader; `trees` is a still file, or a frame of a sequence."""
    rays = make_rays(trees, bounds, random.Random(path.name))
    lines = "".join(",".join("%.9g" % x for x in ray) + "\n" for ray in rays)
    answers = [json.loads(line) for line in run(tracer, input=lines).splitlines()]
    assert len(answers) == len(rays), "%d rays, %d answers" % (len(rays), len(answers))
    hits = 0
    for ray, tool in zip(rays, answers):
        mine = bvhc_trace.closest_hit(trees, ray[:3], ray[3:])
        said = "ray %s: reader %s, tool %s" % (",".join("%.9g" % x for x in ray), mine, tool)
        names = [h and tuple(h[k] for k in ("instance", "geom", "prim")) for h in (mine, tool)]
        same_place = mine and tool and math.isclose(mine["t"], tool["t"], rel_tol=1e-5, abs_tol=1e-6)
        if not (names[0] == names[1] and (same_place or not mine)):
            # Another triangle at the same place, or one that is hit on its very edge, may be taken by one and left by the other.
            assert same_place or any(h and on_edge(h) for h in (mine, tool)), said
        hits += mine is not None
    return len(rays), hits


def on_edge(hit):
    return min(hit["u"], hit["v"], 1.0 - hit["u"] - hit["v"]) < 1e-5


def make_rays(file, bounds, source):
    """Rays at triangles' middles, corners and edges from around the scene, along axes, and at random; f32 numbers throughout."""
    low, high = bounds
    size = float(np.linalg.norm(high - low)) or 1.0
    rays = []
    for n in range(RAYS):
        origin = [source.uniform(a - 0.3 * size, b + 0.3 * size) for a, b in zip(low, high)]
        target = [source.uniform(a, b) for a, b in zip(low, high)]
        if len(file.tris) and n % 6 < 4:
            t = file.tris[source.randrange(len(file.tris))]
            weights = [(1 / 3, 1 / 3, 1 / 3), (0.5, 0.5, 0.0), (1.0, 0.0, 0.0), (0.2, 0.3, 0.5)][n % 6]
            target = sum(w * t[v].astype(float) for w, v in zip(weights, ("v0", "v1", "v2")))
            if file.two_level:
                places = file.inst[file.inst["blas"] == file.geom[t["geom"]]["blas"]]
                m = places[source.randrange(len(places))]["object_to_world"].reshape(3, 4).astype(float)
                target = m[:, :3] @ target + m[:, 3]
        direction = [b - a for a, b in zip(origin, target)]
        if n % 6 == 4:
            axis = source.randrange(3)
            origin = [a if i != axis else low[axis] - size for i, a in enumerate(target)]
            direction = [1.0 if i == axis else source.choice([0.0, -0.0]) for i in range(3)]
        rays.append([float(np.float32(x)) for x in (*origin, *direction)])
    return rays


def refuse_invalid(paths):
    """The reference reader must refuse every invalid vector that shows an error, and never fail in another way."""
    wrong, refused = [], 0
    for path in paths:
        try:
            bvhc_reader.File(path.read_bytes())
            if path.name[:5] not in LEFT_TO_THE_TOOL and path.name[:3] not in LEFT_TO_THE_TOOL:
                wrong.append("%s is accepted" % path.name)
        except (bvhc_reader.Invalid, bvhc_reader.Unsupported):
            refused += 1
            if path.name.startswith("W"):
                wrong.append("%s is refused, but a warning is no error" % path.name)
        except Exception as error:
            wrong.append("%s makes the reader fail: %r" % (path.name, error))
    for line in wrong:
        print("FAIL  %s" % line)
    print("%d of %d invalid vectors refused by the reference reader, the others are left to the tool" % (refused, len(paths)))
    return len(wrong)


if __name__ == "__main__":
    main()
