#!/usr/bin/env bash
# Two builds of the program: how many instructions each takes for a tree, which no other program on the machine changes. Needs valgrind.
#
#   benches/instructions.sh OLD NEW MODEL [RECIPE…]     programs, a model, and recipes as flags of `bvhc build` (default: every method)
#
# Counted is the building alone, on one thread, without reading and writing. Programs must have their symbols, as `cargo build --release` leaves them.
# `benches/compare.py` measures times.
set -euo pipefail
[ $# -ge 3 ] || { sed -n '2,7s/^# \{0,1\}//p' "$0"; exit 2; }
old=$1 new=$2 model=$3
shift 3
[ $# -gt 0 ] || set -- "--preset draft" "--preset balanced" "--method binned" "--method bonsai" "--method bonsai -O presplit=0.3" "--method sweep" \
    "--method sweep -O presplit=0.3 --reinsert 8" "--method agglomerative" "--method sbvh" "--method sbvh --reinsert 8" "--preset draft --adapt 300"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

count() {
    local flags
    read -ra flags <<<"$2"
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect='*::decide_tree' --toggle-collect='*::decide_sound' \
        "$1" build "$model" -o "$scratch/out.bvhc" --force --quiet --jobs 1 "${flags[@]}" >"$scratch/log" 2>&1 ||
        { cat "$scratch/log" >&2; return 1; }
    local counted
    counted=$(sed -n 's/.*Collected : //p' "$scratch/log")
    if [ "${counted:-0}" = 0 ]; then
        echo "nothing was counted: $1 has no function decide_tree or decide_sound that is called" >&2
        return 1
    fi
    echo "$counted"
}
for recipe in "$@"; do
    a=$(count "$old" "$recipe")
    b=$(count "$new" "$recipe")
    awk -v a="$a" -v b="$b" -v recipe="$recipe" 'BEGIN { printf "%12d  %12d  %.3f  %s\n", a, b, b / a, recipe }'
done
