#!/usr/bin/env python3
"""Bytes of sequences beside a file for each frame, a row an animation.

    benches/sequence_bytes.py [--bvhc target/release/bvhc] [--fps N] PATTERN|MODEL:CLIP… [-- BUILD-OPTION…]

PATTERN names OBJ frames (quoted, such as 'heli.%04d.obj'), and CLIP is the number of a glTF model's animation, played at N frames a second (default: as its keys have).
All files of a row are built by the same options. *files* is what `bvhc build` makes of each frame alone, `raw` to `one tree, 16 bits` what it makes of them together.
Cells are bytes a triangle and frame, of whole files; *raw : files* is what a raw sequence takes of those.

Only Python's own library is needed. Nothing depends on the machine.
"""

import argparse
import csv
import io
import json
import subprocess
import sys
import tempfile
from pathlib import Path

# Name, and options of the build.
FORMS = [
    ("raw", []),
    ("compact", ["--codec", "compact"]),
    ("one tree, raw", ["--trees", "1"]),
    ("one tree, compact", ["--trees", "1", "--codec", "compact"]),
    ("one tree, 16 bits", ["--trees", "1", "--codec", "compact", "--vertex-bits", "16"]),
]


class Bench:
    def __init__(self, bvhc, folder, fps, options):
        self.bvhc, self.folder, self.fps, self.options = bvhc, Path(folder), fps, options

    def run(self, *args):
        run = subprocess.run(list(map(str, [self.bvhc, *args])), stdout=subprocess.PIPE, check=False)
        if run.returncode:
            sys.exit(f"bvhc {' '.join(map(str, args))}: exit code {run.returncode}")
        return run.stdout.decode()

    def build(self, *args):
        """What a build says of its files."""
        return json.loads(self.run("build", *args, "--no-check", "--quiet", "--json", *self.options))["files"]

    def row(self, animation):
        model, _, clip = animation.rpartition(":")
        played = ["--clip", clip, "--fps", self.fps] if model else []
        model = model or animation
        sequence = self.folder / "sequence.bvhc"
        sizes, shown = [], 0
        for _, form in FORMS:
            built = self.build(model, "-o", sequence, "--force", *played, *form)[0]["built"]
            sizes.append(built["file_len"])
            shown = shown or [frame["instanced_triangles"] for frame in built["sequence"]["frames"]]
        stills = self.folder / "stills"
        if clip and played:
            self.build(model, "-o", sequence, "--force", *played)
            frames = csv.DictReader(io.StringIO(self.run("stats", sequence, "--frames", "--csv", "--rays", 0)))
            still = self.folder / "still.bvhc"
            alone = sum(
                self.build(model, "-o", still, "--force", "--clip", clip, "--time", frame["time"], "--degenerate", "keep")[0]["built"]["file_len"]
                for frame in frames
            )
        else:
            stills.mkdir()
            alone = sum(result["built"]["file_len"] for result in self.build(model, "-o", stills, "--degenerate", "keep"))
            for file in stills.iterdir():
                file.unlink()
            stills.rmdir()
        each = [f"{size / max(sum(shown), 1):.2f}" for size in (alone, *sizes)]
        name = Path(model).stem if not played else f"{Path(model).stem} {clip}"
        smaller = sizes[0] / alone
        share = f"{smaller:.2f}" if smaller > 0.1 else f"1 : {1 / smaller:.0f}"
        print(f"| {name} | {max(shown)} | {len(shown)} | {each[0]} | {each[1]} | {share} | {' | '.join(each[2:])} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bvhc", default="target/release/bvhc")
    parser.add_argument("--fps", default="auto")
    parser.add_argument("animations", nargs="+", metavar="PATTERN|MODEL:CLIP")
    arguments = sys.argv[1:]
    split = arguments.index("--") if "--" in arguments else len(arguments)
    args = parser.parse_args(arguments[:split])
    names = [name for name, _ in FORMS]
    print(f"| animation | triangles | frames | files | {names[0]} | raw : files | {' | '.join(names[1:])} |")
    print(f"|---|{'--:|' * (len(names) + 4)}")
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(args.bvhc, folder, args.fps, arguments[split + 1 :])
        for animation in args.animations:
            bench.row(animation)


if __name__ == "__main__":
    main()
