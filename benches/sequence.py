#!/usr/bin/env python3
"""A long sequence: how long each phase takes, how much memory, and what a second build and one of an edited frame do.

    benches/sequence.py [--bvhc target/release/bvhc] [--frames 1000] [--side 123] [--folder DIR] [--threads ROUNDS] [--open target/release/examples/frames]
                        [-- BUILD-OPTION…]

The frame that is edited stands right behind the middle; where it is one of those that trees are made of, all are read. Writes that many frames of a cloth in waves (2 · (side - 1)² triangles; 123 makes 29,768) into a folder, needs about 3 GB there, and removes them.
With `--threads`, builds on one thread and on two take turns instead, so many of each, and the table says how much is gained. Processor time does not grow while other programs run; neither does the
number of threads at work, on Linux: the time that threads ran or waited for a processor, as a share of the build's. What two processors of their own would gain follows from both.

With `--open`, that program (`cargo build --release --example frames`) opens every frame of the file of all frames and traces a ray in it; it prints what opening one takes, the median and the most.

Only Python's own library is needed. Counts and memory are the program's own (its largest resident set, which has the pages of the file that was there, if one was); times depend on the machine and on what
else it does.
"""

import argparse
import filecmp
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path


# A prime number, so that the waves come back after as many frames and not before.
PERIOD = 1009


def write_frames(folder, count, side):
    """The frames, the same bytes on every machine: the waves are made of sines that were rounded to thousandths. No two frames are alike."""
    wave = [round(1000 * math.sin(2 * math.pi * i / PERIOD)) for i in range(PERIOD)]
    faces = "".join(
        f"f {v} {v + 1} {v + side + 1}\nf {v} {v + side + 1} {v + side}\n"
        for z in range(side - 1)
        for v in range(z * side + 1, z * side + side)
    )
    for frame in range(1, count + 1):
        write_frame(folder, frame, side, wave, faces, 0)
    return wave, faces


def write_frame(folder, frame, side, wave, faces, lift):
    rows = []
    for z in range(side):
        for x in range(side):
            first, second, third = (wave[i % PERIOD] for i in (20 * x + 8 * frame, 14 * z + 5 * frame, 6 * x + 3 * z))
            height = first + second * third // 1000 + lift
            rows.append(f"v {x} {height / 500:.3f} {z}\n")
    (folder / f"cloth.{frame:04d}.obj").write_text("".join(rows) + faces)


class Bench:
    def __init__(self, bvhc, folder, options):
        self.bvhc, self.folder, self.options = bvhc, folder, options

    def build(self, what, frames, *more):
        """Build the first frames, and print what that took."""
        file = self.folder / f"cloth.{frames}.bvhc"
        pattern = self.folder / "cloth.%04d.obj"
        # Reading the file back maps it, and mapped pages count as memory, though the system can have them back.
        quiet = ["--no-check", "--json", *self.options]
        command = [self.bvhc, "build", pattern, "-o", file, "--frames", f"1-{frames}", *quiet, *more]
        run = subprocess.run(list(map(str, command)), stdout=subprocess.PIPE, check=False)
        if run.returncode:
            sys.exit(f"{what}: exit code {run.returncode}")
        result = json.loads(run.stdout)["files"][0]
        if result["status"] != "built":
            print(f"| {what} | {result['status']} | | | | | | | |")
            return result, file
        built = result["built"]
        times, sequence = built["times"], built["sequence"]
        seconds = [f"{times[phase + '_ms'] / 1000:.1f}" for phase in ("read", "build", "write", "total")]
        memory = f"{(built['peak_memory'] or 0) / 2**20:.0f}"
        cells = [what, sequence["read"], sequence["built"], sequence["refitted"], sequence["taken"], *seconds, memory]
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)
        return result, file

    def at_work(self, frames, jobs):
        """Build on so many threads: seconds on the clock, of processors, and how many threads were at work on average."""
        file = self.folder / f"threads.{frames}.bvhc"
        file.unlink(missing_ok=True)
        pattern = self.folder / "cloth.%04d.obj"
        options = ["--frames", f"1-{frames}", "--jobs", jobs, "--no-check", "--quiet", *self.options]
        start, wanted = time.monotonic(), {}
        run = subprocess.Popen(list(map(str, [self.bvhc, "build", pattern, "-o", file, *options])))
        while True:
            # What the threads had last is lost once the program has ended, so it is read every other moment.
            pid, status, usage = os.wait4(run.pid, os.WNOHANG)
            if pid:
                break
            for thread in Path(f"/proc/{run.pid}/task").glob("*/schedstat"):
                try:
                    ran, waited, _ = map(int, thread.read_text().split())
                    wanted[thread] = (ran + waited) / 1e9
                except (OSError, ValueError):
                    pass
            time.sleep(0.01)
        seconds = time.monotonic() - start
        run.returncode = os.waitstatus_to_exitcode(status)
        if run.returncode:
            sys.exit(f"{jobs} threads: exit code {run.returncode}")
        return seconds, usage.ru_utime + usage.ru_stime, sum(wanted.values()) / seconds


def compare_threads(bench, frames, rounds):
    runs = {1: [], 2: []}
    for _ in range(rounds):
        for jobs, some in runs.items():
            some.append(bench.at_work(frames, jobs))
    one, two = ([statistics.median(column) for column in zip(*some)] for some in runs.values())
    print("| threads | clock, s | processors, s | threads at work |")
    print("|--:|--:|--:|--:|")
    for jobs, (seconds, processors, at_work) in ((1, one), (2, two)):
        print(f"| {jobs} | {seconds:.1f} | {processors:.1f} | {at_work:.2f} |")
    gain = two[2] / one[2] * one[1] / two[1]
    print(f"\nTwo threads are {one[0] / two[0]:.2f} times as quick by the clock, and {gain:.2f} times with a processor for each.")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bvhc", default="target/release/bvhc")
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--side", type=int, default=123)
    parser.add_argument("--folder", help="where frames and files go; default: the system's for temporary files")
    parser.add_argument("--threads", type=int, metavar="ROUNDS", help="compare one thread with two")
    parser.add_argument("--open", metavar="PROGRAM", help="examples/frames as it was built, to time the opening of frames")
    parser.add_argument("options", nargs="*", help="options of bvhc build, after --")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=args.folder) as folder:
        folder = Path(folder)
        wave, faces = write_frames(folder, args.frames, args.side)
        bench = Bench(args.bvhc, folder, args.options)
        if args.threads:
            return compare_threads(bench, args.frames, args.threads)
        few = max(args.frames // 10, 1)
        print("| | frames read | trees built | refitted | taken | read, s | build, s | write, s | total, s | peak memory, MiB |")
        print("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|")
        bench.build(f"{few} frames", few, "--jobs", "2")
        _, file = bench.build(f"{args.frames} frames, one thread", args.frames, "--jobs", "1")
        # A file that is there is mapped to be looked at, and what was looked at counts as memory.
        file.unlink()
        bench.build(f"{args.frames} frames, two threads", args.frames, "--jobs", "2")
        opened = None
        if args.open:
            opened = subprocess.run([args.open, file], stdout=subprocess.PIPE, check=True).stdout.decode().splitlines()
        before = file.stat()
        bench.build("again", args.frames)
        if file.stat().st_mtime_ns != before.st_mtime_ns:
            sys.exit("a build of what is up to date wrote the file")
        write_frame(folder, args.frames // 2 + 1, args.side, wave, faces, 37)
        bench.build("one frame edited", args.frames, "--jobs", "2")
        taken = file.rename(folder / "taken.bvhc")
        bench.build("the same, all frames", args.frames, "--jobs", "2")
        if not filecmp.cmp(file, taken, shallow=False):
            sys.exit("a build from the file that was there made other bytes")
        if opened:
            print(f"\n{Path(opened[0]).name}; {opened[-1]}")


if __name__ == "__main__":
    main()
