#!/usr/bin/env bash
# What bvhc-core costs a program that links it: crates to compile, and the time of a clean optimised build beside the root package's.
#
#   tests/core_build.sh            both; takes minutes
#   tests/core_build.sh --count    the numbers of crates only, which must not exceed their limits
#
# The program is tests/client. Times depend on the machine and on what else it does, so nothing fails by them.
set -euo pipefail
cd "$(dirname "$0")/.."

# A package and the crates below it, those of build scripts included.
count() { cargo tree -e normal,build --prefix none --no-dedupe "$@" | sed 's/ (.*//' | sort -u | wc -l; }

too_many=0
limit() {
    local most=$1 name=$2 crates
    shift 2
    crates=$(($(count "$@") - 1))
    printf '%4d crates, %s (limit %s)\n' "$crates" "$name" "$most"
    [ "$most" = none ] || [ "$crates" -le "$most" ] || too_many=1
}
limit 16 "a program on bvhc-core" -p bvhc-test-client
limit 25 "the same with rayon and zstd" -p bvhc-test-client --features rayon,zstd
limit none "the root package" -p bvhc
if [ $too_many = 1 ]; then
    echo "too many crates below bvhc-core: see them by cargo tree -p bvhc-test-client -e normal,build" >&2
    exit 1
fi
[ "${1:-}" = "--count" ] && exit

# Clean builds into a folder of their own, with the crates' sources fetched before.
cargo fetch --quiet
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
milliseconds() { echo $(($(date +%s%N) / 1000000)); }
build() {
    local start
    start=$(milliseconds)
    cargo build --quiet --release --target-dir "$scratch/$1" -p "$1"
    took=$(($(milliseconds) - start))
}
build bvhc-test-client
core=$took
build bvhc
root=$took
awk -v core="$core" -v root="$root" 'BEGIN {
    printf "clean release build: %.1f s for the program on bvhc-core, %.1f s for the root package, %.1f times\n", core / 1000, root / 1000, root / core
}'
