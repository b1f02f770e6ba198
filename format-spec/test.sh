#!/usr/bin/env bash
# Read every valid vector (and freshly built samples) with two programs that share no code with the tool: the reference reader and
# the parser that Kaitai compiles from bvhc.ksy. What they say must be what `bvhc info --json` says; rays must hit the same. Then hold what
# every command prints with --json against schema/.
#
# Everything is installed below target/format-tests. Exit status 77: the packages could not be installed, nothing was tested.
set -euo pipefail
cd "$(dirname "$0")/.."
# Scripts look there for what was built.
export CARGO_TARGET_DIR="$PWD/target"
work=target/format-tests
mkdir -p "$work"

# Install Python's and Node's packages once; again when the lists change.
stamp="$(cat format-spec/requirements.txt format-spec/package.json | cksum)"
if [ "$(cat "$work/stamp" 2>/dev/null)" != "$stamp" ]; then
    {
        python3 -m venv --clear "$work/venv" &&
            "$work/venv/bin/python" -m pip install --quiet --disable-pip-version-check -r format-spec/requirements.txt &&
            cp format-spec/package.json "$work/package.json" &&
            (cd "$work" && npm install --no-audit --no-fund --loglevel=error)
    } || {
        echo "SKIPPED: the packages of format-spec/requirements.txt and package.json could not be installed" >&2
        exit 77
    }
    echo "$stamp" >"$work/stamp"
fi

# Compile the description, then let the driver compare.
cp format-spec/compile_ksy.js "$work/"
node "$work/compile_ksy.js" format-spec/bvhc.ksy "$work"
cargo build --quiet --release --bin bvhc --example trace_ray
"$work/venv/bin/python" format-spec/test_vectors.py --parser "$work" --tool target/release/bvhc \
    --tracer target/release/examples/trace_ray --scratch "$work/scratch"

# The documents that commands print, against their schemas.
"$work/venv/bin/python" format-spec/test_schemas.py --tool target/release/bvhc --scratch "$work/schemas"
