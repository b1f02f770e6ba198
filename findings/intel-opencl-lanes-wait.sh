#!/usr/bin/env bash
# Intel's OpenCL driver for processors (Python package intel-opencl-rt 2026.2.0): work items of different length wait for each other.
#
# Expected: on a processor each work item is a loop of its own, as with other drivers for processors, or the compiler puts items side by side where that is quicker.
# Seen: the compiler puts work items into the lanes of a vector, also where a kernel is one loop that follows indices and ends at once for most items and late for a few.
# All lanes wait for the longest. Where one item in sixteen takes a hundred times as many steps, the kernel takes more than twice the time that it takes with the attribute
# intel_vec_len_hint(1), which turns that off. The answers are the same.
# Hurts: traversal of trees, where each ray has a way of its own, and above all rays that see much of a scene from far away.
# bvhc: gives its traversal kernel that attribute where the driver's compiler defines cl_intel_vec_len_hint (src/verify/opencl/kernels/traverse.cl).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check intel-opencl-rt==2026.2.0 intel-cmplr-lib-rt==2026.2.0 pyopencl==2026.1.4 numpy==2.2.6
mkdir "$work/vendors"
echo "$work/venv/lib/libintelocl.so" >"$work/vendors/intel.icd"
export LD_LIBRARY_PATH="$work/venv/lib" OCL_ICD_VENDORS="$work/vendors"
cat >"$work/run.py" <<'PY'
import statistics, time, warnings
import numpy as np, pyopencl as cl

warnings.simplefilter("ignore")
KERNEL = """
__kernel %s void steps(__global const uint *next, __global const uint *start, __global uint *count) {
    uint at = start[get_global_id(0)], n = 0;
    while (at != 0) { at = next[at]; ++n; }
    count[get_global_id(0)] = n;
}
"""
device = cl.get_platforms()[0].get_devices()[0]
context = cl.Context([device])
queue = cl.CommandQueue(context)
items, flags = 1 << 16, cl.mem_flags
chain = np.maximum(np.arange(4096, dtype=np.int64) - 1, 0).astype(np.uint32)
lengths = np.where(np.random.default_rng(1).random(items) < 1 / 16, 2000, 20).astype(np.uint32)
given = [cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=data) for data in (chain, lengths)]
place = cl.Buffer(context, flags.WRITE_ONLY, 4 * items)
kernels = {name: cl.Kernel(cl.Program(context, KERNEL % hint).build(), "steps")
           for name, hint in (("plain", ""), ("told", "__attribute__((intel_vec_len_hint(1)))"))}
times = {name: [] for name in kernels}
for _ in range(15):
    for name, kernel in kernels.items():
        began = time.perf_counter()
        kernel(queue, (items,), (64,), *given, place)
        queue.finish()
        times[name].append(time.perf_counter() - began)
        found = np.empty(items, np.uint32)
        cl.enqueue_copy(queue, found, place)
        assert (found == lengths).all(), name
ratio = statistics.median(times["plain"]) / statistics.median(times["told"])
print(f"{device.name}, driver {device.driver_version}: {ratio:.1f} times as long as with intel_vec_len_hint(1), same answers")
raise SystemExit(0 if ratio > 1.5 else "CHANGED: work items no longer wait for each other")
PY
"$work/venv/bin/python" "$work/run.py"
