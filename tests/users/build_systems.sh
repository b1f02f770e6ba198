#!/usr/bin/env bash
# An asset engineer's day: 200 models below Ninja and below Make, by the recipes of the README.
#
#   tests/users/build_systems.sh BVHC      BVHC is the program, such as target/release/bvhc
#
# What is built, what is left alone, what an interruption and a full disk leave behind. Ninja, Make and a file system of its own for the full disk
# (mount needs root) are each skipped where they are not there; exit status 77 if all are.
set -euo pipefail
program=$(realpath "$1")
readme=$(realpath "$(dirname "$0")/../../README.md")
# The recipes are README's own, so that what it says is what is tried.
ninja_command=$(sed -n 's/^  command = //p' "$readme")
make_recipe=$(sed -n 's/^\tbvhc build/bvhc build/p' "$readme")
for recipe in "$ninja_command" "$make_recipe"; do
    [ "$(grep -c '^bvhc build' <<<"$recipe")" = 1 ] || { echo "README has no recipe, or several: $recipe" >&2; exit 1; }
done
count=200
work=$(mktemp -d)
mounted=""
finish() {
    [ -z "$mounted" ] || umount "$mounted"
    rm -rf "$work"
}
trap finish EXIT
cd "$work"
PATH="$work/bin:$PATH"
mkdir bin models
ln -s "$program" bin/bvhc

fail() {
    echo "FAIL  $*" >&2
    exit 1
}
ok() { echo "ok    $*"; }
# Outputs that are newer than the file `mark`.
rebuilt() { find models -name '*.bvhc' -newer mark | wc -l; }
outputs() { find models -name '*.bvhc' | wc -l; }
left_behind() { find . -name '*.bvhc-tmp' | wc -l; }
mark() {
    # File systems keep times to a tick of the clock, which may be 10 ms.
    sleep 0.05
    touch mark
    sleep 0.05
}

# A fan of triangles each, every fourth one a glTF with a buffer in another file.
write_models() {
    python3 - "$count" <<'PYTHON'
import json, struct, sys
for n in range(int(sys.argv[1])):
    corners = [(0, 0, 0)] + [(i, i * i * (n + 1), n % 5) for i in range(1, 12)]
    if n % 4:
        lines = ["v %d %d %d" % c for c in corners] + ["f 1 %d %d" % (i, i + 1) for i in range(2, 12)]
        open("models/m%d.obj" % n, "w").write("\n".join(lines) + "\n")
        continue
    flat = [c for i in range(1, 11) for corner in (corners[0], corners[i], corners[i + 1]) for c in corner]
    open("models/m%d.bin" % n, "wb").write(struct.pack("<%df" % len(flat), *flat))
    size = 4 * len(flat)
    json.dump({"asset": {"version": "2.0"}, "buffers": [{"uri": "m%d.bin" % n, "byteLength": size}],
        "bufferViews": [{"buffer": 0, "byteLength": size}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 30, "type": "VEC3"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}]},
        open("models/m%d.gltf" % n, "w"))
PYTHON
}

# The same course for both: build all, nothing, one changed model, one changed buffer, an interruption, and to the end.
course() {
    local name=$1
    shift
    rm -rf models && mkdir models && write_models
    "$@" >log 2>&1 || fail "$name: $(tail -5 log)"
    [ "$(outputs)" = $count ] || fail "$name built $(outputs) of $count"
    mark && "$@" >log 2>&1
    [ "$(rebuilt)" = 0 ] || fail "$name rebuilt $(rebuilt) although nothing changed"
    mark && echo "v 9 9 9" >>models/m1.obj && echo "f 1 2 13" >>models/m1.obj && "$@" >log 2>&1
    [ "$(rebuilt)" = 1 ] || fail "$name rebuilt $(rebuilt) for one changed model"
    mark && printf '\0\0\200\077' | dd of=models/m0.bin conv=notrunc status=none && "$@" >log 2>&1
    [ "$(rebuilt)" = 1 ] || fail "$name rebuilt $(rebuilt) for one changed buffer"

    # A triangle without area is accepted by name.
    mark && echo "f 1 1 2" >>models/m2.obj && "$@" >log 2>&1 || fail "$name refused a triangle without area: $(tail -5 log)"
    [ "$(rebuilt)" = 1 ] || fail "$name rebuilt $(rebuilt) for a triangle without area"

    # Any other warning is an error, is read, and leaves the other outputs to be built.
    echo "l 1 2" >>models/m2.obj
    if "$@" >log 2>&1; then fail "$name took a model with a line"; fi
    grep -q "line and point primitive" log || fail "$name does not show why"
    rm models/m2.bvhc && sed -i '$d' models/m2.obj && "$@" >log 2>&1 || fail "$name: $(tail -5 log)"

    rm models/*.bvhc
    "$@" >log 2>&1 &
    local job=$!
    while [ "$(outputs)" -lt 5 ] && kill -0 $job 2>/dev/null; do sleep 0.02; done
    kill -INT $job 2>/dev/null || true
    wait $job || true
    [ "$(left_behind)" = 0 ] || fail "$name, interrupted, left $(left_behind) temporary files"
    "$@" >log 2>&1 || fail "$name after an interruption: $(tail -5 log)"
    [ "$(outputs)" = $count ] || fail "$name built $(outputs) of $count after an interruption"
    bvhc check models -q || fail "$name: a file is not valid"
    ok "$name: $count models, nothing to do, one change, one buffer, a warning, an interruption"
}

tried=0
if command -v ninja >/dev/null; then
    write_models
    {
        printf 'rule bvh\n  command = %s\n' "$ninja_command"
        printf '  depfile = $out.d\n  deps = gcc\n  restat = 1\n'
        for model in models/*.obj models/*.gltf; do printf 'build %s.bvhc: bvh %s\n' "${model%.*}" "$model"; done
    } >build.ninja
    course Ninja setsid --wait ninja
    tried=1
fi
if command -v make >/dev/null; then
    # Make's rules are those of the README; models of two kinds need a rule each.
    {
        printf 'all: $(addsuffix .bvhc,$(basename $(wildcard models/*.obj models/*.gltf)))\n'
        for kind in obj gltf; do
            printf '%%.bvhc: %%.%s\n\t%s\n' $kind "$make_recipe"
        done
        printf -- '-include $(wildcard models/*.bvhc.d)\n'
    } >Makefile
    course Make setsid --wait make -k -j 4
    tried=1
fi

# A disk that is full: the old output stays, nothing else does, and the exit code is that of files.
mkdir small
if mount -t tmpfs -o size=64k tmpfs small 2>/dev/null; then
    mounted=$work/small
    cp models/m1.obj small/
    bvhc build small/m1.obj -o small/m1.bvhc -q
    cp small/m1.bvhc old
    head -c 60000 /dev/zero >small/ballast 2>/dev/null || true
    code=0
    bvhc build small/m1.obj -o small/m1.bvhc --force >log 2>&1 || code=$?
    [ $code = 3 ] || fail "a full disk ends with $code: $(cat log)"
    cmp small/m1.bvhc old || fail "a full disk changed the old output"
    [ "$(left_behind)" = 0 ] || fail "a full disk left a temporary file"
    ok "a full disk"
    tried=1
else
    echo "SKIPPED: a full disk, since no file system can be mounted here"
fi
# The same by a limit on the size of files, which ends a program by a signal unless it catches it.
(
    ulimit -f 1
    code=0
    bvhc build models/m1.obj -o limited.bvhc >log2 2>&1 || code=$?
    echo $code >code
) 2>/dev/null || true
if [ -e code ]; then
    [ "$(cat code)" = 3 ] || fail "a limit on file sizes ends with $(cat code)"
    [ ! -e limited.bvhc ] && [ "$(left_behind)" = 0 ] || fail "a limit on file sizes left a file"
    ok "a limit on the size of files"
fi
[ $tried = 1 ] || exit 77
