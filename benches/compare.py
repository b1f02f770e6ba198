#!/usr/bin/env python3
"""Two builds of the peers benchmark, run in turn: by how much one builds trees quicker than the other.

    cargo bench --no-run --bench peers        # prints the executable, once in each of two checkouts
    benches/compare.py OLD NEW [--scenes A,B] [--recipes A,B] [--runs N]

Each run times every recipe once on one thread and once on two. For each recipe it prints the new build's time over the old one's, by the
medians over the runs of each scene and by their least ones, and then the geometric mean over scenes. Trees that differ are named.
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import tempfile


def run(program, scenes, recipes):
    """Times by (scene, recipe, threads), and what tells trees apart by (scene, recipe)."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "out.json")
        command = [program, "--quick", "--peers", "none", "--scenes", scenes, "--json", file]
        subprocess.run(command + (["--recipes", recipes] if recipes else []), check=True, stdout=subprocess.DEVNULL)
        with open(file) as text:
            measured = json.load(text)
    times, trees = {}, {}
    for scene in measured:
        for tree in scene["trees"]:
            for threads, ms in enumerate(tree["ms"], 1):
                times[scene["name"], tree["setting"], threads] = ms
            trees[scene["name"], tree["setting"]] = (tree["sah"], tree["depth"], tree["refs_per_triangle"], tree["visits"])
    return times, trees


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--scenes", default="sponza_dabrovic,bunny,dragon_202k")
    parser.add_argument("--recipes", help="as the benchmark names them (default: all)")
    parser.add_argument("--runs", type=int, default=9)
    arguments = parser.parse_args()
    times = {"old": [], "new": []}
    trees = {}
    for turn in range(arguments.runs):
        # The first of a pair may be the slower or the quicker one for reasons of its own.
        for which in ("old", "new") if turn % 2 == 0 else ("new", "old"):
            taken, trees[which] = run(getattr(arguments, which), arguments.scenes, arguments.recipes)
            times[which].append(taken)
    shared = [key for key in times["old"][0] if key in times["new"][0]]

    def mean(of, recipe, threads):
        keys = [k for k in shared if k[2] == threads and recipe in (k[1], None)]
        ratio = lambda k: of(t[k] for t in times["new"]) / of(t[k] for t in times["old"])
        return math.exp(statistics.fmean(math.log(ratio(k)) for k in keys))

    print("| recipe | 1 thread, median | least | 2 threads, median | least |\n|---|---:|---:|---:|---:|")
    for recipe in [*dict.fromkeys(k[1] for k in shared), None]:
        columns = [mean(of, recipe, threads) for threads in (1, 2) for of in (statistics.median, min)]
        print("| %s | %.3f | %.3f | %.3f | %.3f |" % (recipe or "**all**", *columns))
    for key, tree in trees["old"].items():
        if key in trees["new"] and trees["new"][key] != tree:
            print("another tree: %s of %s" % (key[1], key[0]))


if __name__ == "__main__":
    main()
