#!/usr/bin/env bash
# Embree 4.4.0 (in the Python package embreex 4.4.0.post1): HIGH quality and ROBUST cannot be had together, and nothing says so.
#
# Expected: the manual describes RTC_BUILD_QUALITY_HIGH (a tree with spatial splits) and RTC_SCENE_FLAG_ROBUST (no ray slips between
# neighbours) as independent settings, so a scene with both has splits and is watertight. Where that cannot be, an error code.
# Seen: HIGH alone takes the builder "FastSpatialSAH". With ROBUST, or with COMPACT, the builder is the plain "SAH" of MEDIUM; there is
# no error, and rtcGetSceneFlags gives the flags back as set. And ROBUST is needed: without it, of 20,000 rays that aim at the
# edges of a closed octahedron from within, more than a thousand get out.
# Hurts: who compares builders, or pays for "final frame" quality: the tree is the medium one. Who leaves ROBUST out has holes.
# bvhc: one traversal, watertight for every method (tests/watertight.rs); benches/peers has Embree's trees from rtcBuildBVH, without flags.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check embreex==4.4.0.post1 numpy==2.2.6
cat > "$work/run.py" <<'PY'
import ctypes as c, pathlib, embreex, numpy as np

libs = pathlib.Path(embreex.__file__).parent.parent / "embreex.libs"
c.CDLL(str(next(libs.glob("libtbb*"))), mode=c.RTLD_GLOBAL)
rtc = c.CDLL(str(next(libs.glob("libembree4*"))))
P = c.c_void_p
for name, result, *args in [
    ("NewDevice", P, c.c_char_p), ("NewScene", P, P), ("SetSceneFlags", None, P, c.c_int), ("SetSceneBuildQuality", None, P, c.c_int),
    ("NewGeometry", P, P, c.c_int), ("SetNewGeometryBuffer", P, P, c.c_int, c.c_uint, c.c_int, c.c_size_t, c.c_size_t),
    ("CommitGeometry", None, P), ("AttachGeometry", c.c_uint, P, P), ("CommitScene", None, P), ("GetSceneFlags", c.c_int, P),
    ("GetDeviceError", c.c_int, P), ("GetDeviceProperty", c.c_ssize_t, P, c.c_int), ("Intersect1", None, P, P, P),
]:
    function = getattr(rtc, "rtc" + name)
    function.restype, function.argtypes = result, args

# A skew octahedron: eight triangles over six points that they share by number, so that there is no gap anywhere.
points = np.array([[1.1, 0.2, 0.1], [-0.9, 0.1, 0.3], [0.2, 1.2, -0.1], [0.1, -1, 0.2], [-0.2, 0.1, 1], [0.3, 0.2, -1.1]], np.float32)
faces = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]], np.uint32)

device = rtc.rtcNewDevice(b"threads=1,verbose=2")
print("version", rtc.rtcGetDeviceProperty(device, 0), flush=True)

def scene(flags, quality):
    s, g = rtc.rtcNewScene(device), rtc.rtcNewGeometry(device, 0)
    rtc.rtcSetSceneFlags(s, flags)
    rtc.rtcSetSceneBuildQuality(s, quality)
    for kind, form, data in ((1, 0x9003, points), (0, 0x5003, faces)):
        c.memmove(rtc.rtcSetNewGeometryBuffer(g, kind, 0, form, 12, len(data)), data.ctypes.data, data.nbytes)
    rtc.rtcCommitGeometry(g)
    rtc.rtcAttachGeometry(s, g)
    rtc.rtcCommitScene(s)
    return s

for name, flags in (("NONE", 0), ("COMPACT", 2), ("ROBUST", 4)):
    for quality in (1, 2):
        print("case", name, ("MEDIUM", "HIGH")[quality - 1], flush=True)
        s = scene(flags, quality)
        print("flags kept", rtc.rtcGetSceneFlags(s) == flags, "error", rtc.rtcGetDeviceError(device), flush=True)

random, count = np.random.default_rng(3), 20000
face, corner, along = random.integers(len(faces), size=count), random.integers(3, size=count), random.random((count, 1))
a, b = points[faces[face, corner]], points[faces[face, (corner + 1) % 3]]
origins = random.uniform(-0.1, 0.1, (count, 3)).astype(np.float32)
directions = (a * (1 - along) + b * along - origins).astype(np.float32)
room = c.create_string_buffer(128)
place = (c.addressof(room) + 15) // 16 * 16
ray = np.frombuffer((c.c_float * 20).from_address(place), np.float32)
number = ray.view(np.uint32)
for name, flags in (("NONE", 0), ("ROBUST", 4)):
    s, out = scene(flags, 1), 0
    for o, d in zip(origins, directions):
        ray[:] = 0
        ray[0:3], ray[4:7], ray[8] = o, d, np.inf
        number[9] = number[17] = number[18] = 0xFFFFFFFF
        rtc.rtcIntersect1(s, place, None)
        out += int(number[18] == 0xFFFFFFFF)
    print("escaped", name, out, flush=True)
PY
"$work/venv/bin/python" "$work/run.py" > "$work/log"
grep -E '^(version|case|flags|escaped)|building' "$work/log" | tee "$work/out"
fail() { echo "CHANGED: $1" >&2; exit 1; }
splits() { sed -n "/^case $1\$/,/^flags/p" "$work/out" | grep -c FastSpatial || true; }
escaped() { sed -n "s/^escaped $1 //p" "$work/out"; }
grep -qx 'version 40400' "$work/out" || fail "this is not Embree 4.4.0"
[ "$(grep -c '^flags kept True error 0$' "$work/out")" = 6 ] || fail "Embree reports a conflict of settings now"
[ "$(splits 'NONE HIGH')" = 1 ] || fail "HIGH alone does not split any more"
[ "$(splits 'NONE MEDIUM')" = 0 ] || fail "MEDIUM splits now"
[ "$(splits 'ROBUST HIGH')" = 0 ] || fail "HIGH with ROBUST splits now"
[ "$(splits 'COMPACT HIGH')" = 0 ] || fail "HIGH with COMPACT splits now"
[ "$(escaped NONE)" -gt 1000 ] || fail "no more than a thousand of 20,000 rays escape without ROBUST"
[ "$(escaped ROBUST)" = 0 ] || fail "rays escape with ROBUST"
echo "as described: HIGH with ROBUST or COMPACT is built as MEDIUM without a word; without ROBUST $(escaped NONE) of 20000 rays escape, with it none"
