#!/usr/bin/env bash
# PoCL 3.0 on processors with FMA (Python packages pocl-binary-distribution 3.0, pyopencl 2026.1.4): x * y - y * x is not zero.
#
# Expected: a kernel of plain f32 operations, above all one built with -cl-opt-disable, rounds each product, so that the cross product
# of a vector with itself is 0, and that of (a, b) is minus that of (b, a).
# Seen: one product is fused into the subtraction and the other is rounded, with -cl-opt-disable too. Of 100,000 vectors almost
# all have a cross product with themselves that is not 0, and for nearly half of the pairs of neighbours (a, b) and (b, a) do not cancel.
# The pragma FP_CONTRACT OFF brings both to none. OpenCL C (Preprocessor Directives and Macros) lets a compiler contract unless told.
# PoCL 3.1 of Debian 12 does the same.
# Hurts: watertight triangle tests: an edge has another sign seen from its other triangle, so rays slip through or hit both;
# triangles without area get one.
# bvhc: builds every kernel behind that pragma, and asks each device by a probe before it trusts it (src/verify/opencl/probe.rs).
set -euo pipefail

if [ -r /proc/cpuinfo ] && [ "$(uname -m)" = x86_64 ] && ! grep -qw fma /proc/cpuinfo; then
    echo "this processor has no FMA: the behaviour cannot be seen here" >&2
    exit 2
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check pocl-binary-distribution==3.0 pyopencl==2026.1.4 numpy==2.2.6
cat > "$work/run.py" <<'PY'
import numpy as np, pyopencl as cl

KERNEL = """
__kernel void cross_products(__global const float2 *v, __global float *self, __global float *both) {
    int i = get_global_id(0);
    float2 a = v[i], b = v[i + 1];
    self[i] = a.x * a.y - a.y * a.x;
    both[i] = (a.x * b.y - a.y * b.x) + (b.x * a.y - b.y * a.x);
}
"""
platform = next(p for p in cl.get_platforms() if "PoCL 3.0-rc2" in p.version)
context = cl.Context(platform.get_devices()[:1])
queue = cl.CommandQueue(context)
count = 100000
vectors = np.random.default_rng(1).random((count + 1, 2), dtype=np.float32)
flags = cl.mem_flags
given = cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=vectors)
places = [cl.Buffer(context, flags.WRITE_ONLY, 4 * count) for _ in range(2)]
for name, source, options in (
    ("plain", KERNEL, []),
    ("opt-disable", KERNEL, ["-cl-opt-disable"]),
    ("pragma", "#pragma OPENCL FP_CONTRACT OFF\n" + KERNEL, []),
):
    program = cl.Program(context, source).build(options)
    program.cross_products(queue, (count,), None, given, *places)
    found = [np.empty(count, np.float32) for _ in places]
    for to, place in zip(found, places):
        cl.enqueue_copy(queue, to, place)
    print(name, "with itself", np.count_nonzero(found[0]), "both ways", np.count_nonzero(found[1]), "of", count)
PY
POCL_CACHE_DIR="$work" PYOPENCL_NO_CACHE=1 "$work/venv/bin/python" "$work/run.py" | tee "$work/out"
fail() { echo "CHANGED: $1" >&2; exit 1; }
number() { sed -n "s/^$1 with itself \([0-9]*\) both ways \([0-9]*\) .*/\\$2/p" "$work/out"; }
for way in plain opt-disable; do
    [ "$(number $way 1)" -gt 90000 ] || fail "$way: x * y - y * x is 0 now"
    [ "$(number $way 2)" -gt 30000 ] || fail "$way: both ways cancel now"
done
[ "$(number pragma 1)" = 0 ] && [ "$(number pragma 2)" = 0 ] || fail "the pragma does not help any more"
echo "as described: contracted with and without -cl-opt-disable; exact behind the pragma"
