#!/usr/bin/env python3
"""Build every model at one level and at two, and let the second reader judge each cache.

    run.py --tool BVHC [--scratch DIR] [--json FILE] [--jobs N] [-v] [--flag=--degenerate=keep] [--moment NUMBER SECONDS] FOLDER_OR_MODEL…

A model that the tool refuses must be one that the second reader refuses too, or finds a breach of the specification in. Prints one
line for each model that differs (with -v for every one) and counts. Exit status: 0 all agree, 1 some differ, 2 usage.
"""

import argparse
import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from cache import Cache, bvhc_reader  # noqa: E402
from compare import Comparison, line, read_model  # noqa: E402
from model import Refused  # noqa: E402

LEVELS = ("one", "two", "auto")
REFUSALS = (3, 4, 5)  # a file that is not there, a model that is none, a feature
LONGEST_BUILD = 600  # seconds


def find(paths):
    """Every model below the given folders, in the order of their names."""
    for path in paths:
        if os.path.isfile(path):
            yield path
        for folder, folders, files in os.walk(path):
            folders.sort()
            yield from (os.path.join(folder, f) for f in sorted(files) if f.lower().endswith(("obj", ".gltf", ".glb")))


def judge(job):
    """Build and compare one model at every level: a list of records, one a level."""
    path, tool, scratch, flags, moment = job
    began = time.time()
    try:
        model, refusal = read_model(path, moment), None
    except Refused as error:
        model, refusal = None, str(error)
    records = []
    handle, cache = tempfile.mkstemp(suffix=".bvhc", dir=scratch)
    os.close(handle)
    for level in LEVELS:
        os.unlink(cache)
        try:
            records.append({"model": path, "levels": level, **judge_build(path, cache, level, tool, flags, model, refusal)})
        except subprocess.TimeoutExpired:
            records.append({"model": path, "levels": level, "verdict": "differs", "text": "the build took longer than %d s" % LONGEST_BUILD})
        if not os.path.exists(cache):
            open(cache, "wb").close()
    os.unlink(cache)
    records[-1]["seconds"] = time.time() - began
    return records


def judge_build(path, cache, level, tool, flags, model, refusal):
    command = [tool, "build", path, "-o", cache, "--preset", "draft", "--levels", level, "--jobs", "1", "--json"] + flags
    done = subprocess.run(command, capture_output=True, timeout=LONGEST_BUILD)
    if done.returncode in REFUSALS:
        return judge_refusal(said(done), model, refusal)
    if done.returncode != 0:
        return differs("the build ended with %d: %s" % (done.returncode, said(done)))
    if refusal is not None:
        return differs("it was built, and the second reader refuses it: %s" % refusal)
    try:
        comparison = Comparison(model, Cache(cache)).run()
    except (bvhc_reader.Invalid, bvhc_reader.Unsupported) as error:
        return differs("the reference reader refuses the cache: %s" % error)
    if comparison.left_out and not comparison.differences and b"warning" not in done.stderr:
        comparison.differ("warning", "standard error", 1, "triangles were left out, and no warning says so")
    return {
        "verdict": "differs" if comparison.differences else "agrees", "text": line("", comparison)[2:], "compared": comparison.compared,
        "left_out": comparison.left_out, "differences": comparison.differences,
    }


def judge_refusal(text, model, refusal):
    if refusal is not None:
        return {"verdict": "both refuse", "text": "%s | second reader: %s" % (text, refusal)}
    if model.faults:
        return {"verdict": "breach", "text": "%s | second reader: %s" % (text, "; ".join(model.faults))}
    return differs("it is refused, and the second reader finds %d triangles and no fault: %s" % (model.triangle_count(), text))


def differs(text):
    return {"verdict": "differs", "text": text}


def said(done):
    """The reason of a refusal, from the JSON that the tool prints."""
    try:
        return "; ".join(json.loads(done.stdout)["files"][0]["error"]["facts"])
    except (ValueError, KeyError, IndexError):
        return done.stderr.decode("utf-8", "replace").strip()[-500:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="+", metavar="FOLDER_OR_MODEL")
    parser.add_argument("--tool", required=True, help="the program bvhc")
    parser.add_argument("--scratch", help="folder for caches (default: a temporary one)")
    parser.add_argument("--json", metavar="FILE", help="write every record there")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--flag", action="append", default=[], help="pass this flag to every build, too")
    parser.add_argument("--moment", nargs=2, metavar=("NUMBER", "SECONDS"), help="pose models at this time of this animation")
    parser.add_argument("-v", "--verbose", action="store_true", help="a line for every model and level")
    arguments = parser.parse_args()
    jobs, counts, records, began = [], {}, [], time.time()
    with tempfile.TemporaryDirectory(dir=arguments.scratch) as scratch:
        # Models whose triangles are all left out are refused without this: what is kept of them is judged here.
        flags, moment = ["--empty", "keep"] + arguments.flag, None
        if arguments.moment:
            moment = int(arguments.moment[0]), float(arguments.moment[1])
            flags += ["--clip", arguments.moment[0], "--time", arguments.moment[1]]
        jobs = [(path, arguments.tool, scratch, flags, moment) for path in find(arguments.paths)]
        # The largest models go first, so that no process is left alone with them at the end.
        jobs.sort(key=lambda job: -os.path.getsize(job[0]))
        with concurrent.futures.ProcessPoolExecutor(arguments.jobs) as pool:
            for of_model in pool.map(judge, jobs):
                for record in of_model:
                    counts[record["verdict"]] = counts.get(record["verdict"], 0) + 1
                    if arguments.verbose or record["verdict"] == "differs":
                        print("%-11s %-4s %s: %s" % (record["verdict"], record["levels"], record["model"], record["text"]), flush=True)
                records += of_model
    if arguments.json:
        with open(arguments.json, "w") as file:
            json.dump({"schema": "bvhc.independent-run.v1", "counts": counts, "records": records}, file, indent=1)
    agreed = [r for r in records if r["verdict"] == "agrees"]
    print("%d models, %s: %s; %d triangles compared, %d left out by the policy, %.0f s" % (
        len(jobs), " and ".join(LEVELS), ", ".join("%d %s" % (n, v) for v, n in sorted(counts.items())) or "none",
        sum(r["compared"] for r in agreed), sum(r["left_out"] for r in agreed), time.time() - began))
    return 1 if counts.get("differs") or not jobs else 0


if __name__ == "__main__":
    sys.exit(main())
