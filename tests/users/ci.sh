#!/usr/bin/env bash
# A CI engineer's day: the steps of docs/verification.md on a machine without a device, and with each OpenCL driver that is there.
#
#   tests/users/ci.sh BVHC      BVHC is the program, such as target/release/bvhc
set -euo pipefail
program=$(realpath "$1")
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
fail() {
    echo "FAIL  $*" >&2
    exit 1
}
ok() { echo "ok    $*"; }
# What a CI system reads: the numbers of cases, failures and errors.
counts() { sed -n '2s/.*tests="\([0-9]*\)" failures="\([0-9]*\)" errors="\([0-9]*\)".*/\1 \2 \3/p' "$1"; }

cp "$here/samples/corrugated_roof.obj" "$here/samples/stadium.obj" .
"$program" build corrugated_roof.obj stadium.obj -o caches/ --preset draft -q
"$program" check caches
files="caches/corrugated_roof.bvhc caches/stadium.bvhc"

none() { OCL_ICD_VENDORS=/nonexistent OCL_ICD_FILENAMES="" "$program" "$@"; }
none verify $files --device all --rays 5k --junit none.xml >log 2>told || fail "without a device: $(cat told)"
grep -q "no OpenCL device" told || fail "without a device, --device all does not say so"
code=0
none verify $files --device all --require-device --rays 5k --junit none.xml >log 2>told || code=$?
[ $code = 5 ] || fail "--require-device without a device ends with $code"
[ "$(counts none.xml)" = "1 0 1" ] || fail "the report of a run without a device: $(cat none.xml)"
ok "without a device"

printf 'not a cache' >caches/odd.bvhc
code=0
"$program" verify caches --device cpu --rays 5k --junit odd.xml --json >odd.json 2>told || code=$?
[ $code = 1 ] || fail "with a file that is no cache, the run ends with $code"
grep -q '"error"' odd.json || fail "the document does not have the file that is no cache"
rm caches/odd.bvhc
ok "a file that is no cache"

devices=$("$program" verify --list-devices --json | grep -c '"index"' || true)
if [ "$devices" = 0 ]; then
    echo "SKIPPED: verification on OpenCL devices, since there is none"
    exit 0
fi
"$program" verify $files --device all --require-device --rays 5k --junit all.xml >log || fail "on $devices devices: $(cat log)"
[ "$(counts all.xml | cut -d' ' -f2-)" = "0 0" ] || fail "the report of a run on $devices devices"
ok "on $devices OpenCL devices: $(counts all.xml | cut -d' ' -f1) cases"
