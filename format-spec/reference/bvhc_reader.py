#!/usr/bin/env python3
"""Plain reference reader of the .bvhc file, version 1.4. SPEC.md is the law; numbers in brackets are its sections.

    bvhc_reader.py FILE                           check the file, print what `bvhc info --json FILE` prints
    bvhc_reader.py FILE --ray ox,oy,oz,dx,dy,dz   check the file, trace the ray, print the closest hit (repeatable)
    bvhc_reader.py FILE --rays LIST               the same for each line of a text file
    bvhc_reader.py FILE --frame N --ray ...       the same in the frame of a sequence that has the number N

Needs numpy; `blake3` to check the hashes and `zstandard` to read compressed sections. Slow and obvious on purpose, and
it shares no code with the tool. Exit status: 0 fine, 1 the file is invalid, 2 usage, 3 cannot be read, 5 unsupported.
"""

import argparse
import json
import sys

import bvhc_trace  # beside this file, as those below
from bvhc_file import File
from bvhc_meta import info
from bvhc_records import DIFFERENCES, RECORDS, Invalid, Unsupported, plain

__all__ = ["DIFFERENCES", "RECORDS", "File", "Invalid", "Unsupported", "info", "plain"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file")
    parser.add_argument("--ray", action="append", default=[], metavar="ox,oy,oz,dx,dy,dz", help="write --ray=-1,... for a negative number")
    parser.add_argument("--frame", type=int, metavar="N", help="the number of the frame of a sequence in which rays are traced")
    parser.add_argument("--rays", metavar="LIST", help="a text file with one such ray a line")
    arguments = parser.parse_args()
    try:
        with open(arguments.file, "rb") as f:
            file = File(f.read())
        rays = arguments.ray + (open(arguments.rays).read().split() if arguments.rays else [])
    except OSError as error:
        print("error: %s" % error, file=sys.stderr)
        return 3
    except Invalid as error:
        print("error: %s is invalid: %s" % (arguments.file, error), file=sys.stderr)
        return 1
    except Unsupported as error:
        print("error: %s is not supported: %s" % (arguments.file, error), file=sys.stderr)
        return 5
    trees = file
    if file.sequence and rays:
        index = file.numbered(arguments.frame)
        if index is None:
            parser.error("--frame must be one of %s" % ", ".join(map(str, file.fram["number"])))
        trees = file.frame(index)
    elif arguments.frame is not None and not file.sequence:
        parser.error("--frame needs a sequence, and %s is a still file" % arguments.file)
    if not rays:
        print(json.dumps({"schema": "bvhc.info.v1", "files": [{"path": arguments.file, **info(file)}]}, indent=2))
    for ray in rays:
        numbers = [float(x) for x in ray.split(",")]
        if len(numbers) != 6:
            parser.error("a ray is six numbers: ox,oy,oz,dx,dy,dz")
        print(json.dumps(bvhc_trace.closest_hit(trees, numbers[:3], numbers[3:])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
