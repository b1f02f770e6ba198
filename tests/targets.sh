#!/usr/bin/env bash
# Check bvhc-core on WebAssembly and on 64-bit Arm: that it compiles, that its tests pass, and that rays hit the same, bit for bit, as here.
#
# rustc's own targets are used where rustup has them and Arm has a linker and an emulator:
#   rustup target add wasm32-unknown-unknown aarch64-unknown-linux-gnu; apt install gcc-aarch64-linux-gnu qemu-user nodejs
# Otherwise Debian's packages of the same are unpacked below target/targets; nothing is installed and no root is needed.
# Exit status 77: neither can be had, nothing was tested.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD work=$PWD/target/targets
mkdir -p "$work"
wasm=wasm32-unknown-unknown arm=aarch64-unknown-linux-gnu
build_std=""

skip() {
    echo "SKIPPED: $1" >&2
    exit 77
}
need() { command -v "$1" >/dev/null 2>&1 || skip "$1 is missing"; }
need cargo
need node

# rustc with both targets, an Arm linker and an emulator.
use_installed() {
    local target
    for target in $wasm $arm; do
        [ -d "$("${RUSTC:-rustc}" --print target-libdir --target $target 2>/dev/null)" ] || return 1
    done
    command -v aarch64-linux-gnu-gcc >/dev/null 2>&1 || return 1
    emulator=$(command -v qemu-aarch64 || command -v qemu-aarch64-static) || return 1
    emulator="$emulator -L /usr/aarch64-linux-gnu"
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
}

# apt with lists of its own, which has packages for both machines and touches nothing of the system's.
apt() {
    mkdir -p "$work/apt/lists/partial" "$work/apt/cache/archives/partial"
    touch "$work/apt/status"
    printf '%s\n' 'APT::Architecture "amd64";' 'APT::Architectures { "amd64"; "arm64"; };' 'APT::Sandbox::User "";' \
        "Dir::State \"$work/apt\";" "Dir::State::status \"$work/apt/status\";" "Dir::Cache \"$work/apt/cache\";" >"$work/apt.conf"
    APT_CONFIG="$work/apt.conf" "$@"
}
# The package that $1 depends on and whose name is like $2.
dependency() { apt apt-cache depends "$1:amd64" | sed -n "s/^ *Depends: \($2\)\(:amd64\)\?$/\1/p" | head -n 1; }

unpack_debian() {
    local std llvm deb parts=$work/parts.new
    rm -rf "$parts" "$work/deb" && mkdir -p "$parts/amd64" "$parts/arm64" "$work/deb"
    apt apt-get update -q >"$work/apt.log" 2>&1 || return 1
    std=$(dependency libstd-rust-web-dev 'libstd-rust-web-[0-9.]*') && [ -n "$std" ] || return 1
    llvm=$(dependency "$std" 'libllvm[0-9]*') && [ -n "$llvm" ] || return 1
    (cd "$work/deb" && apt apt-get download -q rustc-web:amd64 "$std:amd64" libstd-rust-web-dev:amd64 libstd-rust-web-dev:arm64 \
        rust-web-src:all "$llvm:amd64" "lld-${llvm#libllvm}:amd64" qemu-user-static:amd64 \
        libc6-dev:arm64 libgcc-12-dev:arm64) >>"$work/apt.log" 2>&1 || return 1

    # Of the sources and emulators only what is needed: the others are half a gigabyte.
    for deb in "$work"/deb/*.deb; do
        case $deb in
        */rust-web-src_*) dpkg --fsys-tarfile "$deb" | tar x -C "$parts/amd64" --wildcards './usr/src/rustc-*/library' ./usr/lib/rustlib ;;
        */qemu-user-static_*) dpkg --fsys-tarfile "$deb" | tar x -C "$parts/amd64" ./usr/bin/qemu-aarch64-static ;;
        *_arm64.deb) dpkg -x "$deb" "$parts/arm64" ;;
        *) dpkg -x "$deb" "$parts/amd64" ;;
        esac || return 1
    done
    mv "$parts/arm64/usr/lib/rustlib/$arm" "$parts/amd64/usr/lib/rustlib/" && rm -rf "$work/deb" && mv "$parts" "$work/parts"
}

# Debian's rustc, run from where it was unpacked. It brings no library for WebAssembly, so cargo compiles one from its source.
use_debian() {
    command -v apt-get >/dev/null 2>&1 && [ "$(dpkg --print-architecture)" = amd64 ] ||
        skip "no rustc for $wasm and $arm, and no Debian on x86-64 to take one from"
    if [ ! -d "$work/parts" ]; then
        echo "unpacking Debian's rustc for other targets below target/targets, about 250 MB"
        unpack_debian || { tail -n 5 "$work/apt.log" >&2 && skip "Debian's packages could not be had, see above"; }
    fi
    local amd64=$work/parts/amd64 arm64=$work/parts/arm64 bin=$work/bin
    local gcc=$arm64/usr/lib/gcc/aarch64-linux-gnu/12 libc=$arm64/usr/lib/aarch64-linux-gnu
    mkdir -p "$bin"
    wrap() {
        printf '#!/bin/sh\nLD_LIBRARY_PATH=%s exec %s\n' "$amd64/usr/lib/x86_64-linux-gnu" "$2" >"$bin/$1"
        chmod +x "$bin/$1"
    }
    wrap rustc "$amd64/usr/bin/rustc \"\$@\""
    wrap wasm-ld "$(echo "$amd64"/usr/bin/wasm-ld-*) \"\$@\""
    wrap arm-ld "$(echo "$amd64"/usr/bin/ld.lld-*) -static $libc/crt1.o $libc/crti.o $gcc/crtbeginT.o -L$gcc -L$libc \"\$@\" \
--start-group -lgcc -lgcc_eh -lc --end-group $gcc/crtend.o $libc/crtn.o"
    emulator=$amd64/usr/bin/qemu-aarch64-static
    export RUSTC=$bin/rustc RUSTC_BOOTSTRAP=1
    export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER=$bin/wasm-ld
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=$bin/arm-ld
    export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUSTFLAGS="-Clinker-flavor=ld -Ctarget-feature=+crt-static -Crelocation-model=static"
    build_std=-Zbuild-std=std,panic_abort,test
}

use_installed || use_debian
export CARGO_TARGET_DIR=$work/cargo
export CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUNNER="node $root/tests/client/run.mjs"
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER=$emulator
"${RUSTC:-rustc}" --version

ran=()
step() {
    printf '\n--- %s\n' "$1"
    local name=$1 start=$SECONDS
    shift
    "$@"
    ran+=("$(printf '%4d s  %s' $((SECONDS - start)) "$name")")
}

for target in $wasm $arm; do
    std="" by=$emulator
    [ $target = $wasm ] && std=$build_std by=node
    step "bvhc-core without default features compiles for $target" \
        cargo build $std --target $target -p bvhc-core --no-default-features --features pure
    step "tests of bvhc-core on $target, run by $(basename "${by%% *}")" cargo test $std --target $target -p bvhc-core --lib
done
step "the client compiles for $wasm" cargo rustc $build_std --target $wasm -p bvhc-test-client --lib --crate-type cdylib
step "the client compiles for $arm" cargo build --target $arm -p bvhc-test-client
step "the client compiles for this machine" cargo build -p bvhc-test-client

# What rays hit, by SSE2, by NEON and by plain code. The vectors are tiny; where the program was built, samples are traced too.
files=(format-spec/vectors/valid/*.bvhc)
if [ -x target/release/bvhc ]; then
    for model in samples/forest.glb samples/curtain.obj; do
        target/release/bvhc build "$model" -o "$work/$(basename "$model").bvhc" --preset draft --force -q
        files+=("$work/$(basename "$model").bvhc")
    done
fi
compare() {
    local cargo=$CARGO_TARGET_DIR rays=5000
    "$cargo/debug/bvhc-test-client" $rays "${files[@]}" >"$work/here.txt"
    $emulator "$cargo/$arm/debug/bvhc-test-client" $rays "${files[@]}" >"$work/arm.txt"
    node tests/client/run.mjs "$cargo/$wasm/debug/bvhc_test_client.wasm" $rays "${files[@]}" >"$work/wasm.txt"
    local hits
    hits=$(grep -c '^[0-9a-f]\{8\} ' "$work/here.txt")
    echo "${#files[@]} files, $rays rays each, $hits hits"
    [ "$hits" -gt $rays ] || { echo "too few hits to compare" >&2 && return 1; }
    diff "$work/here.txt" "$work/arm.txt" >&2 && diff "$work/here.txt" "$work/wasm.txt" >&2
}
step "rays hit the same on all three, bit for bit" compare

printf '\n'
printf '%s\n' "${ran[@]}"
