#!/usr/bin/env bash
# Run every test. On a Debian or Ubuntu machine, as root or with passwordless sudo, this also installs what the tests need.
#
#   tests/run.sh            everything
#   tests/run.sh --quick    what cargo test runs: every test that is not long
#
# Environment: BVHC_MODELS  folder of real scenes for the long tests (default ../shared/models; skipped when absent)
#              BVHC_CASES   folder of inputs that were once read wrongly (default ../shared/cases; skipped when absent)
#              BVHC_SEQUENCES  folder of animated situations (default ../shared/sequences; skipped when absent)
#              BVHC_STRICT  1: a skipped part fails the run
set -euo pipefail
cd "$(dirname "$0")/.."
# Scripts look there for what was built.
export CARGO_TARGET_DIR="$PWD/target"

quick=0
[ "${1:-}" = "--quick" ] && quick=1
began=$SECONDS
done_parts=() skipped=()

part() {
    printf '\n=== %s\n' "$1"
    local name=$1 start=$SECONDS
    shift
    "$@" || return $?
    done_parts+=("$(printf '%5d s  %s' $((SECONDS - start)) "$name")")
}
skip() {
    printf '\n=== SKIPPED: %s\n' "$1"
    skipped+=("$1")
}

# Install the tools that are missing. Only cargo itself and a C compiler are needed to go on.
packages=()
need() { command -v "$1" >/dev/null 2>&1 || packages+=("$2"); }
need cc build-essential
need make make
need ninja ninja-build
need node nodejs
need npm npm
# An OpenCL loader and PoCL, the driver that runs on any processor: without them the tests of OpenCL devices skip themselves.
library() { PATH=$PATH:/usr/sbin:/sbin ldconfig -p 2>/dev/null | grep -F "$1" >/dev/null || packages+=("$2"); }
library libOpenCL.so.1 ocl-icd-libopencl1
ls /etc/OpenCL/vendors/*.icd >/dev/null 2>&1 || packages+=(pocl-opencl-icd)
python3 -c 'import venv, ensurepip' >/dev/null 2>&1 || packages+=(python3 python3-venv)
if [ ${#packages[@]} -gt 0 ]; then
    echo "missing: ${packages[*]}"
    root=""
    [ "$(id -u)" = 0 ] || root="sudo -n"
    if command -v apt-get >/dev/null 2>&1 && $root true 2>/dev/null; then
        export DEBIAN_FRONTEND=noninteractive
        $root apt-get update -q || echo "apt-get update failed; trying with the lists at hand"
        $root apt-get install -y -q --no-install-recommends "${packages[@]}" ||
            skip "installing ${packages[*]}: apt-get failed; tests that need them are left out"
    else
        skip "installing ${packages[*]}: neither root nor passwordless sudo with apt-get; tests that need them are left out"
    fi
fi
if ! command -v cargo >/dev/null 2>&1; then
    echo "cargo is missing: install Rust $(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml) or newer with rustup, then run this again" >&2
    exit 1
fi

export BVHC_CASES="${BVHC_CASES:-$PWD/../shared/cases}"
if [ ! -d "$BVHC_CASES" ]; then
    skip "inputs that were once read wrongly: no folder at BVHC_CASES"
    unset BVHC_CASES
fi
export BVHC_SEQUENCES="${BVHC_SEQUENCES:-$PWD/../shared/sequences}"
if [ ! -d "$BVHC_SEQUENCES" ]; then
    skip "animated situations: no folder at BVHC_SEQUENCES"
    unset BVHC_SEQUENCES
fi
part "unit, integration and documentation tests" cargo test --workspace --no-fail-fast

# The integration tests that have long ones: `tests/NAME.rs` or the folder `tests/NAME`.
with_long=()
for file in $(grep -rl 'fn long_' tests --include='*.rs' | sort); do
    name=${file#tests/}
    name=${name%%/*}
    [[ " ${with_long[*]:-} " == *" ${name%.rs} "* ]] || with_long+=(--test "${name%.rs}")
done
if [ ${#with_long[@]} = 0 ]; then
    echo "no long tests were found below tests/" >&2
    exit 1
fi

if [ $quick = 0 ]; then
    # The long tests go over the samples and, where the folder is there, over real scenes.
    export BVHC_MODELS="${BVHC_MODELS:-$PWD/../shared/models}"
    if [ -d "$BVHC_MODELS" ]; then
        echo "real scenes: $(find "$BVHC_MODELS" -mindepth 1 -maxdepth 1 -type d | wc -l) folders found"
    else
        skip "tests on real scenes: no folder at BVHC_MODELS"
        unset BVHC_MODELS
    fi
    # With the examples that later parts run: alone, the program would be built twice, since examples ask the library for more features.
    part "the program, optimised" cargo build --release --bin bvhc --example trace_ray --example hits
    # Those of the library were built above. Of the others only what has long tests is built again, optimised.
    part "long tests of the library" cargo test --workspace --lib --no-fail-fast -- --ignored long_
    part "long tests" cargo test --release --no-fail-fast "${with_long[@]}" -- --ignored long_
    part "the library without the command line" cargo test --no-default-features --lib
    part "tests of bvhc-core with every feature" cargo test -p bvhc-core --all-features --no-fail-fast

    # A build that only wants caches must not pull the command line's crates.
    if cargo tree --no-default-features -e normal | grep -E '^[^a-z]*(clap|indicatif|ctrlc) '; then
        echo "the library alone must not depend on the crates above" >&2
        exit 1
    fi
    part "the crates below bvhc-core" tests/core_build.sh --count
    part "the packages" tests/package.sh
    part "tests of bvhc-core as a program links it" cargo test -p bvhc-core --no-fail-fast
    status=0
    part "bvhc-core on WebAssembly and 64-bit Arm" tests/targets.sh || status=$?
    if [ $status = 77 ]; then
        skip "bvhc-core on WebAssembly and 64-bit Arm: no compiler for them could be had, see above"
    elif [ $status != 0 ]; then
        exit $status
    fi
    if python3 -c 'import venv, ensurepip' >/dev/null 2>&1 && command -v npm >/dev/null 2>&1; then
        status=0
        part "the format: reference reader and Kaitai description" format-spec/test.sh || status=$?
        if [ $status = 77 ]; then
            skip "the format tests: their packages could not be installed, see above"
        elif [ $status != 0 ]; then
            exit $status
        fi
    else
        skip "the format tests: python3-venv or npm is missing"
    fi
    status=0
    page() { BVHC_TOOL=target/release/bvhc tests/page/run.sh; }
    part "the page in a browser" page || status=$?
    if [ $status = 77 ]; then
        skip "the page in a browser: no Chromium or no Node could be had, see above"
    elif [ $status != 0 ]; then
        exit $status
    fi
    # What an asset engineer and a CI engineer do with the program.
    for user in build_systems ci; do
        status=0
        part "users: $user" tests/users/$user.sh target/release/bvhc || status=$?
        if [ $status = 77 ]; then
            skip "users: $user: nothing that it needs is there, see above"
        elif [ $status != 0 ]; then
            exit $status
        fi
    done
    if python3 -c 'import venv, ensurepip' >/dev/null 2>&1; then
        status=0
        part "OpenCL drivers" tests/users/drivers.py target/release/bvhc pocl intel oclgrind || status=$?
        if [ $status = 77 ]; then
            skip "OpenCL drivers: none could be had, see above"
        elif [ $status != 0 ]; then
            exit $status
        fi
        status=0
        log=$(mktemp)
        independent() { BVHC_TOOL=target/release/bvhc tests/independent/run.sh 2>&1 | tee "$log"; }
        part "the independent reading: a second reader of OBJ and glTF" independent || status=$?
        if [ $status = 77 ]; then
            skip "the independent reading: its packages could not be installed, see above"
        elif [ $status != 0 ]; then
            exit $status
        fi
        while read -r line; do skip "the independent reading: ${line#SKIPPED: }"; done < <([ $status = 77 ] || grep '^SKIPPED: ' "$log")
        rm -f "$log"
    else
        skip "the independent reading: python3-venv is missing"
    fi
    part "fuzzing: planted faults" fuzz/campaign.sh --planted
    part "fuzzing: every target for a while" fuzz/campaign.sh --minute
    if ls benches/*.rs >/dev/null 2>&1; then
        for bench in benches/*.rs; do
            bench=$(basename "$bench" .rs)
            part "benchmark $bench, once through" env BVHC_BENCH_SMOKE=1 cargo bench --bench "$bench" -- --test
        done
    fi
fi

printf '\n=== Passed in %d s\n' $((SECONDS - began))
printf '  %s\n' "${done_parts[@]}"
if [ ${#skipped[@]} -gt 0 ]; then
    printf '=== SKIPPED\n'
    printf '  - %s\n' "${skipped[@]}"
    if [ "${BVHC_STRICT:-0}" = 1 ]; then
        echo "BVHC_STRICT=1: skipped parts count as failures" >&2
        exit 1
    fi
fi
