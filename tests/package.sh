#!/usr/bin/env bash
# What is handed out: the crates that a registry would get, and the program.
#
#   tests/package.sh           packs both crates, without compiling them; each must stay below 2 MB
#   tests/package.sh --all     compiles them from their packages as well, and builds the stripped program and prints its size; takes minutes
set -euo pipefail
cd "$(dirname "$0")/.."
# Scripts look there for what was built.
export CARGO_TARGET_DIR="$PWD/target"
verify=--no-verify
[ "${1:-}" = "--all" ] && verify=

# A package that is new to the registry cannot find the other one there, so both are packed in one call.
rm -rf target/package
cargo publish --workspace --exclude bvhc-test-client --dry-run --quiet --allow-dirty $verify
too_large=0 seen=0
for crate in target/package/bvhc-*.crate target/package/tmp-crate/bvhc-*.crate; do
    [ -f "$crate" ] || continue
    bytes=$(wc -c <"$crate")
    printf '%9d bytes, %s\n' "$bytes" "$(basename "$crate")"
    [ "$bytes" -lt 2000000 ] || too_large=1
    seen=$((seen + 1))
done
if [ $seen -lt 2 ]; then
    echo "$seen packages were found, not 2" >&2
    exit 1
fi
if [ $too_large = 1 ]; then
    echo "a package must stay below 2 MB: see what is in it by cargo package --list" >&2
    exit 1
fi
if [ -z "$verify" ]; then
    cargo build --quiet --profile dist
    printf '%9d bytes, the stripped program\n' "$(wc -c <target/dist/bvhc)"
fi
