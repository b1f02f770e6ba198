#!/usr/bin/env bash
# Fuzz every target with inputs that are changed in their own terms. Fails on a panic, a case of more than a second, or more memory than a case may hold.
#
#   fuzz/campaign.sh [CASES] [TARGET…]   so many cases of each target (default 10,000,000); needs a nightly toolchain and cargo-fuzz
#   fuzz/campaign.sh --minute            about a minute in all; on a stable toolchain, where there is no other, a fixed number of cases
#   fuzz/campaign.sh --planted [TARGET…] that planted faults are found
#   fuzz/campaign.sh --minimise [TARGET…] keep of each corpus what its coverage needs
#
# Targets: reader check decoding obj gltf posing. Corpora lie in fuzz/corpus, inputs that fail in fuzz/artifacts. Seeds are made by the targets; with
# them come the corner files below BVHC_MODELS and BVHC_CASES (default ../shared/models and ../shared/cases), where these folders are.
set -euo pipefail
cd "$(dirname "$0")/.."

targets=(reader check decoding obj gltf posing)
mode=cases cases=10000000
case "${1:-}" in
    --minute) mode=minute; shift ;;
    --planted) mode=planted; shift ;;
    --minimise) mode=minimise; shift ;;
    -*) sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 2 ;;
    [0-9]*) cases=$1; shift ;;
esac
[ $# -gt 0 ] && targets=("$@")

# Short runs take what the tests have built already; long ones are optimised more.
profile=(--release)
if [ $mode = planted ] || [ $mode = minute ]; then profile=(--target-dir target); fi
twin() { cargo run --quiet "${profile[@]}" --manifest-path fuzz/Cargo.toml --no-default-features --bin twin -- "$@"; }
# Memory is safe by the language here, so that a sanitizer finds little and halves the speed: BVHC_FUZZ_SANITIZER=address has one.
fuzzer=(cargo +nightly fuzz)
how=(-s "${BVHC_FUZZ_SANITIZER:-none}")
guided=0
if cargo +nightly --version >/dev/null 2>&1 && cargo fuzz --version >/dev/null 2>&1; then guided=1; fi

if [ $mode = planted ]; then
    # From seeds that are all valid, so that the way to each fault is the fuzzer's own.
    twin planted 300000 "${targets[@]}"
    exit
fi
if [ $guided = 0 ]; then
    if [ $mode != minute ]; then
        echo "a nightly toolchain and cargo-fuzz are missing: rustup toolchain install nightly, cargo install cargo-fuzz" >&2
        exit 1
    fi
    echo "no nightly toolchain with cargo-fuzz: the stable twin runs, without coverage"
    twin run 40000 "${targets[@]}"
    exit
fi

"${fuzzer[@]}" build "${how[@]}" >/dev/null
failed=()
for target in "${targets[@]}"; do
    corpus=fuzz/corpus/$target artifacts=fuzz/artifacts/$target
    mkdir -p "$corpus" "$artifacts"
    if [ $mode = minimise ]; then
        "${fuzzer[@]}" cmin "${how[@]}" "$target" >/dev/null 2>&1
        printf '%-9s %6d inputs, %d bytes\n' "$target" "$(find "$corpus" -type f | wc -l)" "$(cat "$corpus"/* | wc -c)"
        continue
    fi
    # A seed file that is there already keeps its name: it is that of its content.
    twin seeds "$corpus" "$target" >/dev/null
    log=$(mktemp)
    limit=(-runs="$cases")
    [ $mode = minute ] && limit=(-max_total_time=10)
    # A case of more than a second is found by the target itself, which measures again on a busy machine; these end what never ends.
    if "${fuzzer[@]}" run "${how[@]}" "$target" "$corpus" -- "${limit[@]}" -max_len=16384 -len_control=0 -timeout=30 \
        -rss_limit_mb=2048 -print_final_stats=1 -artifact_prefix="$artifacts/" >"$log" 2>&1; then
        state=clean
    else
        state=FAILED failed+=("$target")
        grep -aE 'panicked at|^==[0-9]+== ERROR|SUMMARY|Test unit written' -A1 "$log" | head -12 >&2 || true
    fi
    last=$(grep -aoE 'cov: [0-9]+ ft: [0-9]+ corp: [0-9]+' "$log" | tail -n 1 || true)
    done_cases=$(grep -aoE 'number_of_executed_units: [0-9]+' "$log" | grep -oE '[0-9]+$' || echo '?')
    rate=$(grep -aoE 'average_exec_per_sec: *[0-9]+' "$log" | grep -oE '[0-9]+$' || echo '?')
    printf '%-9s %s: %s cases at %s/s, %s\n' "$target" "$state" "$done_cases" "$rate" "${last:-no coverage}"
    rm -f "$log"
done
if [ ${#failed[@]} -gt 0 ]; then
    echo "failed: ${failed[*]}; the inputs are below fuzz/artifacts" >&2
    exit 1
fi
