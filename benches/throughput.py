#!/usr/bin/env python3
"""From file to file: two builds of the program take turns at whole models and at many small ones, as whole processes.

    benches/throughput.py --against OLD [--bvhc target/release/bvhc] [--rounds 5] [--jobs 2] [--models DIR] [--small 1000]
                          [--glb FILE] [--count | --phases] [--only WORD] [MODEL…]

OLD is an older bvhc. MODELs are OBJ or glTF files; without any, those of `--models` (or BVHC_MODELS) that the list below names. Every model is
built by each of the recipes below, the two programs in turn, and the medians and their ratio are told: seconds on the clock, seconds of processors,
and the largest resident set that the operating system counted (`wait4`), in bytes a triangle. Content ids are compared: where the two programs make
other trees of a model, or cut its polygons otherwise, its row says so.

Times depend on what else the machine does, and the disk most of all; `--count` counts instructions instead by valgrind, on one thread, once each.
`--phases` tells in milliseconds what the programs themselves say of reading, building and writing, syncing included, in medians. An output is removed
before it is built again.

The small models are written anew in each run: terrains of 2 to 4,608 triangles, the same bytes on every machine. Each program builds all of them into
an empty folder with one command; the new one once for each mode of `--sync`.
"""

import argparse
import json
import multiprocessing
import os
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

MODELS = [
    ("bitterli_kitchen/bitterli_kitchen.obj", ["draft", "balanced"]),
    ("city_san_francisco/san_francisco.obj", ["draft"]),
    ("sponza_dabrovic/sponza.obj", ["draft"]),
    ("sponza_crytek_partial/sponza_crytek_partial.obj", ["draft"]),
    ("ldraw_falcon/ldraw_falcon.glb", ["draft"]),
]


PHASES = ["read", "build", "write", "total"]


def glb_of(obj, path):
    """Positions and triangles of an OBJ of triangles as one GLB of one primitive."""
    import array
    import struct

    positions, indices = array.array("f"), array.array("I")
    with open(obj, encoding="utf-8", errors="replace") as lines:
        for line in lines:
            word = line.split()
            if word[:1] == ["v"]:
                positions.extend(map(float, word[1:4]))
            elif word[:1] == ["f"]:
                corner = [int(w.split("/")[0]) for w in word[1:]]
                corner = [c - 1 if c > 0 else len(positions) // 3 + c for c in corner]
                for i in range(1, len(corner) - 1):
                    indices.extend((corner[0], corner[i], corner[i + 1]))
    low = [min(positions[k::3]) for k in range(3)]
    high = [max(positions[k::3]) for k in range(3)]
    first, second = positions.tobytes(), indices.tobytes()
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(first) + len(second)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": len(first)},
            {"buffer": 0, "byteOffset": len(first), "byteLength": len(second)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(positions) // 3, "type": "VEC3", "min": low, "max": high},
            {"bufferView": 1, "componentType": 5125, "count": len(indices), "type": "SCALAR"},
        ],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as out:
        out.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(first) + len(second)))
        out.write(struct.pack("<I4s", len(text), b"JSON") + text)
        out.write(struct.pack("<I4s", len(first) + len(second), b"BIN\0") + first + second)


def write_small(folder, count):
    for number in range(count):
        side = 2 + number * 7919 % 48
        rows = [
            f"v {x}.25 {(7 * x * x + 13 * z + number) % 97 / 50:.4f} {z}.5\n" for z in range(side) for x in range(side)
        ]
        corners = [z * side + x + 1 for z in range(side - 1) for x in range(side - 1)]
        rows += [f"f {v} {v + 1} {v + side + 1}\nf {v} {v + side + 1} {v + side}\n" for v in corners]
        (folder / f"m{number:04}.obj").write_text("".join(rows))


def run(command):
    """Seconds on the clock and of processors, and the largest resident set in bytes."""
    start = time.monotonic()
    child = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    seconds = time.monotonic() - start
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        sys.exit(f"exit code {child.returncode}: {' '.join(map(str, command))}")
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024


def phases(command):
    """Milliseconds of reading, building, writing and all of it, as the program says."""
    told = subprocess.run(list(map(str, [*command, "--json"])), capture_output=True, text=True, check=True)
    times = json.loads(told.stdout)["files"][0]["built"]["times"]
    return [times[f"{phase}_ms"] for phase in PHASES]


def instructions(command):
    """Instructions that a command takes; no other program changes their number."""
    counting = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *command]
    told = subprocess.run(list(map(str, counting)), capture_output=True, text=True, check=False)
    found = re.search(r"Collected : (\d+)", told.stderr)
    if told.returncode or not found:
        sys.exit(f"valgrind failed:\n{told.stderr}")
    return int(found.group(1))


def facts(bvhc, file):
    told = subprocess.run([str(bvhc), "info", str(file), "--json"], capture_output=True, text=True, check=True)
    text = told.stdout
    content = re.search(r'"content_id": "(\w+)"', text)
    triangles = re.search(r'"(?:prim_count|triangles)": (\d+)', text)
    return content and content.group(1), int(triangles.group(1)) if triangles else 0


class Bench:
    def __init__(self, args, folder):
        self.programs = {"old": Path(args.against).resolve(), "new": Path(args.bvhc).resolve()}
        self.args, self.folder = args, folder

    def build(self, program, model, out, *more):
        return [self.programs[program], "build", model, "-o", out, "--force", "--quiet", *more]

    def model(self, model, preset):
        files = {program: self.folder / f"{program}.bvhc" for program in self.programs}
        what = f"{model.name}, {preset}"
        if self.args.count:
            counts = []
            for program, file in files.items():
                file.unlink(missing_ok=True)
                counts.append(instructions(self.build(program, model, file, "--preset", preset, "--jobs", "1")))
            print(f"| {what} | {counts[0]:,} | {counts[1]:,} | {counts[1] / counts[0]:.3f} |", flush=True)
            return
        runs = {program: [] for program in files}
        for _ in range(self.args.rounds):
            for program, file in files.items():
                file.unlink(missing_ok=True)
                command = self.build(program, model, file, "--preset", preset, "--jobs", self.args.jobs)
                runs[program].append(phases(command) if self.args.phases else run(command))
        if self.args.phases:
            for program, times in runs.items():
                medians = [f"{statistics.median(column):.0f}" for column in zip(*times)]
                print(f"| {what}, {program} | {' | '.join(medians)} |", flush=True)
            return
        (old_id, triangles), (new_id, _) = (facts(self.programs["new"], file) for file in files.values())
        if old_id != new_id:
            what += " (other content)"
        old, new = ([statistics.median(column) for column in zip(*some)] for some in runs.values())
        each = [f"{bytes_ / max(triangles, 1):.0f}" for bytes_ in (old[2], new[2])]
        print(
            f"| {what} | {old[0]:.3f} | {new[0]:.3f} | {new[0] / old[0]:.2f} | {new[1] / old[1]:.2f} | {each[0]} | {each[1]} |",
            flush=True,
        )

    def small(self):
        inputs = self.folder / "small"
        inputs.mkdir()
        write_small(inputs, self.args.small)
        models = sorted(inputs.iterdir())
        ways = [("old", []), *(("new", ["--sync", mode]) for mode in ("each", "batch", "none"))]
        if self.args.count:
            ways = [("old", []), ("new", ["--sync", "none"])]
        names = [" ".join([program, *more]) for program, more in ways]
        runs = {name: [] for name in names}
        for _ in range(1 if self.args.count else self.args.rounds):
            for name, (program, more) in zip(names, ways):
                out = self.folder / "caches"
                shutil.rmtree(out, ignore_errors=True)
                more = [*more, "--preset", "draft", "--jobs", "1" if self.args.count else self.args.jobs]
                command = [self.programs[program], "build", *models, "-o", f"{out}/", "--quiet", *more]
                runs[name].append(instructions(command) if self.args.count else run(command))
        if self.args.count:
            old, new = (runs[name][0] for name in names)
            print(f"| {len(models)} small models | {old:,} | {new:,} | {new / old:.3f} |")
            return
        medians = {name: [statistics.median(column) for column in zip(*some)] for name, some in runs.items()}
        print("\n| | files a second | × old | processors, × old | peak memory, MiB |\n|---|--:|--:|--:|--:|")
        for name, (seconds, processors, peak) in medians.items():
            old = medians["old"]
            cells = [f"{len(models) / seconds:.0f}", f"{old[0] / seconds:.2f}", f"{processors / old[1]:.2f}"]
            print(f"| {name} | {' | '.join(cells)} | {peak / 2**20:.0f} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", required=True, metavar="OLD", help="an older bvhc")
    parser.add_argument("--bvhc", default="target/release/bvhc")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--jobs", default="2")
    parser.add_argument("--models", default=os.environ.get("BVHC_MODELS"), metavar="DIR")
    parser.add_argument("--small", type=int, default=1000, metavar="COUNT", help="how many small models; 0: none")
    parser.add_argument("--glb", metavar="OBJ", help="also build this OBJ model as a GLB")
    parser.add_argument("--count", action="store_true", help="count instructions by valgrind")
    parser.add_argument("--phases", action="store_true", help="times of reading, building and writing")
    parser.add_argument("--only", default="", metavar="WORD", help="only what has this word in its name or preset")
    parser.add_argument("--folder", help="where files go; default: the system's for temporary files")
    parser.add_argument("model", nargs="*", type=Path)
    args = parser.parse_args()
    models = [(model, ["draft"]) for model in args.model]
    if not models and args.models:
        models = [(Path(args.models) / name, presets) for name, presets in MODELS]
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        bench = Bench(args, Path(folder))
        if args.glb:
            glb = bench.folder / (Path(args.glb).stem + ".glb")
            # In a process of its own: what this one holds when it starts a program counts as the program's largest set.
            maker = multiprocessing.get_context("fork").Process(target=glb_of, args=(args.glb, glb))
            maker.start()
            maker.join()
            if maker.exitcode:
                sys.exit(f"cannot make a GLB of {args.glb}")
            models.append((glb, ["draft", "balanced"]))
        if args.count:
            print("| | instructions, old | new | ratio |\n|---|--:|--:|--:|")
        elif args.phases:
            print(f"| milliseconds | {' | '.join(PHASES)} |\n|---|--:|--:|--:|--:|")
        else:
            print("| | seconds, old | new | ratio | processors | bytes a triangle, old | new |\n|---|--:|--:|--:|--:|--:|--:|")
        for model, presets in models:
            for preset in presets:
                if args.only in f"{model.name} {preset}":
                    bench.model(model, preset)
        if args.small and not args.phases:
            bench.small()


if __name__ == "__main__":
    main()
