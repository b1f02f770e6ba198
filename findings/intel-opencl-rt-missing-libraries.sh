#!/usr/bin/env bash
# Python package intel-opencl-rt 2026.2.0 (Intel's OpenCL driver for processors): installed as its own metadata ask, it has no device.
#
# Expected: `pip install intel-opencl-rt` brings what the driver loads, or loading it tells what else is needed.
# Seen: the driver needs libimf.so, libsvml.so and their like, which only the package intel-cmplr-lib-rt has, and the metadata name tbb and a package of licences alone. An
# ICD loader passes over a driver that it cannot load without a word, so that a program sees no platform at all. With intel-cmplr-lib-rt of the same version beside it,
# the driver has its device.
# Hurts: a CI that runs kernels on Intel's driver finds no device after an installation without an error.
# bvhc: says that there is no device, and ends with 5 where --require-device asks for one; tests/users/drivers.py installs both packages.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
pip() { "$work/venv/bin/pip" install --quiet --disable-pip-version-check "$@"; }
pip intel-opencl-rt==2026.2.0 pyopencl==2026.1.4 numpy==2.2.6
mkdir "$work/vendors"
echo "$work/venv/lib/libintelocl.so" >"$work/vendors/intel.icd"
# Intel's own loader lies in the same folder; the one of pyopencl is asked, which is another build of the usual one.
export LD_LIBRARY_PATH="$work/venv/lib" OCL_ICD_VENDORS="$work/vendors"
cat >"$work/ask.py" <<'PY'
import ctypes, sys
import pyopencl

try:
    platforms = len(pyopencl.get_platforms())
except pyopencl.LogicError as none:
    platforms = 0
try:
    ctypes.CDLL(sys.argv[1])
    reason = "nothing"
except OSError as error:
    reason = str(error).split(":")[0]
print(platforms, reason)
PY
ask() { "$work/venv/bin/python" "$work/ask.py" "$work/venv/lib/libintelocl.so"; }
alone=$(ask)
pip intel-cmplr-lib-rt==2026.2.0
both=$(ask)
echo "platforms, and what the driver lacks: $alone as installed; $both with intel-cmplr-lib-rt"
case "$alone" in
"0 lib"*) ;;
*) echo "CHANGED: the driver loads by itself, or lacks something else"; exit 1 ;;
esac
[ "$both" = "1 nothing" ] || { echo "CHANGED: it has no platform with intel-cmplr-lib-rt either"; exit 1; }
