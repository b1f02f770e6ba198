#!/usr/bin/env bash
# Read every model with a second reader, written from the specifications alone in another language, and compare each cache with it:
# small models made here, the samples, and where they are there the shared models and cases.
#
#   tests/independent/run.sh [-v]
#
# Environment: BVHC_MODELS  folder of real scenes (default ../shared/models); BVHC_CASES  folder of cases (default ../shared/cases)
#              BVHC_SEQUENCES  folder of animated situations (default ../shared/sequences)
#              BVHC_TOOL    the program (default: it is built, optimised); BVHC_HITS  the example `hits` (default: it is built with it)
#
# Everything is installed below target/independent-tests. Exit status 77: the packages could not be installed, nothing was tested.
set -euo pipefail
cd "$(dirname "$0")/../.."
work=target/independent-tests
mkdir -p "$work"

# The reference reader's packages are all that is needed. Install them once; again when the list changes.
stamp="$(cksum <format-spec/requirements.txt)"
if [ "$(cat "$work/stamp" 2>/dev/null)" != "$stamp" ]; then
    {
        python3 -m venv --clear "$work/venv" &&
            "$work/venv/bin/python" -m pip install --quiet --disable-pip-version-check -r format-spec/requirements.txt
    } || {
        echo "SKIPPED: the packages of format-spec/requirements.txt could not be installed" >&2
        exit 77
    }
    echo "$stamp" >"$work/stamp"
fi
python="$work/venv/bin/python"
export PYTHONDONTWRITEBYTECODE=1

tool="${BVHC_TOOL:-}" hits="${BVHC_HITS:-}"
if [ -z "$tool" ] || [ -z "$hits" ]; then
    cargo build --quiet --release --bin bvhc --example hits
    tool="${tool:-target/release/bvhc}" hits="${hits:-target/release/examples/hits}"
fi

status=0
judge() {
    "$python" tests/independent/run.py --tool "$tool" "$@" || status=1
}
"$python" tests/independent/selftest.py
rm -rf "$work/corners"
"$python" tests/independent/corners.py "$work/corners"
judge "$@" "$work/corners" samples
judge "$@" --flag=--degenerate=keep "$work/corners"

# From hits back to the models: normals, texture coordinates, materials and front sides.
lead_back() {
    "$python" tests/independent/origins.py --tool "$tool" --hits "$hits" "$@" || status=1
}
lead_back --count 3000
lead_back --count 3000 samples/colonnade.obj samples/forest.gltf
models="${BVHC_MODELS:-../shared/models}"
if [ -d "$models" ]; then
    for model in sponza_dabrovic/sponza.obj legocar/legocar.obj anim_cesium_milk_truck/CesiumMilkTruck.glb \
        anim_interpolation_test/InterpolationTest.gltf anim_morph_stress/MorphStressTest.gltf tinybvh_balloon/scene.gltf \
        ldraw_eiffel_tower/ldraw_eiffel_tower.glb; do
        if [ -f "$models/$model" ]; then lead_back "$models/$model"; else echo "SKIPPED: hits of $model: there is no such model"; fi
    done
else
    echo "SKIPPED: hits of models of $models: there is no such folder"
fi

for folder in "${BVHC_MODELS:-../shared/models}" "${BVHC_CASES:-../shared/cases}"; do
    if [ -d "$folder" ]; then
        judge "$@" "$folder"
    else
        echo "SKIPPED: models of $folder: there is no such folder"
    fi
done

# At moments of animations: each model and situation that has so many, the others are refused.
moments() {
    if [ ! -d "$1" ]; then
        echo "SKIPPED: animations of $1: there is no such folder"
        return
    fi
    for moment in "0 0.25" "0 1.5" "1 0.61" "2 0.05"; do
        # shellcheck disable=SC2086 # a number and a time
        judge --moment $moment "$1"
    done
}
moments "${BVHC_SEQUENCES:-../shared/sequences}/situations"
for model in anim_cesiumman anim_fox anim_interpolation_test anim_morph_cube anim_morph_stress anim_cesium_milk_truck anim_soldier sf_pigman; do
    moments "${BVHC_MODELS:-../shared/models}/$model"
done
exit $status
