#!/usr/bin/env python3
"""Trace very many rays through caches of real scenes, against each model placed in f64: none may miss, go farther or hit what is not there.

    tests/rays.py [--rays N] [--tool BVHC] [--seed N] [MODEL…]     (default: 1,000,000,000 rays over the scenes below BVHC_MODELS)

Every model is built at one level and at two, and all rays are shared out evenly among the files. `bvhc verify` traces them and judges: each
hit is tested against the triangle that it names, and brute force judges a sample and every ray that passes the triangle at which it was
aimed. It takes a line for each file, and a while: half an hour and more on two cores. Exit status: 0 all right, 1 not, 2 usage.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

WRONG = ("missed", "farther", "false_hits", "malformed", "any_hit", "bits", "tree")
# Folders of corner cases hold a few triangles each: `tests/independent/run.sh` reads them.
LEFT_OUT = ("obj_corner", "gltf_corner")


def models(root):
    """One model a folder and kind: frames of a sequence are alike."""
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in LEFT_OUT)
        found = sorted(f for f in files if f.endswith((".obj", ".gltf", ".glb")))
        yield from (os.path.join(folder, f) for f in (found[:1] if len(found) > 3 else found))


def verify(tool, model, levels, rays, seed, folder):
    """The verdict on one file: a record of counts, or the reason why there is none."""
    cache = os.path.join(folder, "scene.bvhc")
    build = [tool, "build", model, "-o", cache, "--force", "--levels", levels, "--quiet"]
    built = subprocess.run(build, capture_output=True, text=True)
    if built.returncode != 0:
        return None, built.stderr.strip()
    command = [tool, "verify", cache, "--source", model, "--device", "cpu", "--rays", str(rays), "--seed", str(seed), "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        return None, done.stderr.strip()
    return json.loads(done.stdout)["files"][0], None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("models", nargs="*", metavar="MODEL")
    parser.add_argument("--rays", type=int, default=1_000_000_000)
    parser.add_argument("--tool", default="target/release/bvhc")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    root = os.environ.get("BVHC_MODELS", "../shared/models")
    jobs = [(m, levels) for m in arguments.models or models(root) for levels in ("one", "two")]
    if not jobs:
        parser.error("no model is given, and there is none below %s" % root)
    share = -(-arguments.rays // len(jobs))
    sums, right, astray = {}, True, 0
    for model, levels in jobs:
        with tempfile.TemporaryDirectory() as folder:
            file, reason = verify(arguments.tool, model, levels, share, arguments.seed, folder)
        if file is None:
            print("FAILED  %s, %s: %s" % (model, levels, reason), flush=True)
            right = False
            continue
        total = file["devices"][0]["total"]
        total["judged by brute force"] = file["oracle"]["rays"]
        for name, count in total.items():
            sums[name] = sums.get(name, 0) + count
        astray += file["placing"]["astray"]
        right &= file["right"]
        print("%s %12d rays  %12d hits  %9d ties  %6d grazing  %7.1f s  %s, %s level%s" % (
            "right" if file["right"] else "WRONG", total["rays"], total["hits"], total["ties"], total["grazing"],
            total["seconds"], os.path.relpath(model, root) if not arguments.models else model, levels, "s" if levels == "two" else ""), flush=True)
    if sums:
        print("%d files, %d rays, %d hits, %d judged by brute force: %s, %d triangles astray" % (
            len(jobs), sums["rays"], sums["hits"], sums["judged by brute force"],
            ", ".join("%d %s" % (sums[name], name.replace("_", " ")) for name in WRONG), astray))
    sys.exit(0 if right and sums and not any(sums[name] for name in WRONG) and astray == 0 else 1)


if __name__ == "__main__":
    main()
