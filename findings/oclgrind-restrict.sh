#!/usr/bin/env bash
# Oclgrind 21.10 (Debian 12): a kernel that calls a function with `restrict` pointers is not created.
#
# Expected: `restrict` is part of OpenCL C 1.x (C99), so a kernel may call a function whose pointers have it. A simulator that looks for
# faulty loads and stores does not fail on code that has none.
# Seen: at default optimisation clCreateKernel fails, since Oclgrind does not know an intrinsic by which its own compiler marks what
# `restrict` said once the function is inlined (llvm.experimental.noalias.scope.decl). With -cl-opt-disable, or without the word, the
# same kernel runs and gives the right numbers.
# Hurts: whoever checks kernels by Oclgrind takes them for broken: the message names an undefined external function of the kernel.
# bvhc: its own kernels, which have no `restrict`, end with the same message. They are checked with -cl-opt-disable
# (tests/users/drivers.py, docs/verification.md).
set -euo pipefail

command -v apt-get >/dev/null && command -v dpkg >/dev/null || { echo "needs Debian 12: apt-get and dpkg" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/packages"
(cd "$work/packages" && apt-get download -qq oclgrind=21.10-3 liboclgrind-21.10=21.10-3 libclang-common-14-dev libclang-cpp14 libllvm14 2>/dev/null)
for package in "$work"/packages/*.deb; do dpkg -x "$package" "$work"; done
libraries=$(dirname "$(find "$work" -name 'liboclgrind-21.10.so' | head -n 1)")
export LD_LIBRARY_PATH="$libraries:$work/usr/lib/llvm-14/lib:$work/usr/lib/oclgrind"
tool="$work/usr/bin/oclgrind-kernel"
"$tool" --version | sed -n 's/.*\(Oclgrind [0-9.]*\).*/\1/p' | head -n 1

cd "$work"
kernel() { # NAME WORD
    cat > "$1.cl" <<CL
void twice(global const float *$2 in, global float *$2 out) { *out = 2.0f * *in; }
kernel void numbers(global float *out) { uint i = get_global_id(0); twice(out + i, out + i + 4); }
CL
    printf '%s.cl\nnumbers\n4 1 1\n4 1 1\n<size=32 float fill=1 dump>\n' "$1" > "$1.sim"
}
kernel marked restrict
kernel plain ""
run() { # NAME OPTIONS
    if "$tool" ${2:+--build-options "$2"} "$1.sim" > out 2>&1 && grep -q 'out\[7\] = 2' out; then
        echo "$1 ${2:-default options}: runs, right numbers"
    else
        echo "$1 ${2:-default options}: $(grep -m 1 'Undefined external function' out || echo 'fails otherwise')"
    fi
}
{ run marked ""; run marked -cl-opt-disable; run plain ""; } | tee told
fail() { echo "CHANGED: $1" >&2; exit 1; }
grep -q '^marked default options: .*noalias.scope.decl' told || fail "a function with restrict pointers is taken at default optimisation now"
grep -q '^marked -cl-opt-disable: runs' told || fail "it is not taken with -cl-opt-disable either"
grep -q '^plain default options: runs' told || fail "the kernel without restrict does not run"
