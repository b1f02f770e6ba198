#!/usr/bin/env bash
# Crate tinybvh-rs 0.1.0-beta.3: `Ray::new`, a safe function, lets C++ write 128 bytes into a place of 64.
#
# Expected: a type that Rust and C++ share by value has one size and one order of fields in both.
# Seen: the crate's Ray has 64 bytes, aligned to 16, and ends with t, u, v and a triangle. In the header that it compiles, tiny_bvh.h 1.6.8, a ray has 128
# bytes, aligned to 64: there are 64 bytes of the user's own behind the triangle. The C++ function behind `Ray::new` returns that by value and clears it whole,
# so it writes behind the end of the Rust value. What happens then is undefined: in a loop over 400 rays, one program never ended, and in another
# a pointer beside the ray had become null.
# Hurts: every program that traces rays with the crate; building trees and reading nodes is not concerned.
# bvhc: no type is shared with C++. Its benchmarks take the header from the package, and have functions of their own in front of it.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/src"
cat > "$work/Cargo.toml" <<'TOML'
[package]
name = "ray"
version = "0.0.0"
edition = "2021"
[dependencies]
tinybvh-rs = "=0.1.0-beta.3"
[workspace]
TOML
cat > "$work/src/main.rs" <<'RUST'
fn main() {
    let hit = std::mem::offset_of!(tinybvh_rs::Ray, hit);
    println!("Rust: {} bytes, t at {}", std::mem::size_of::<tinybvh_rs::Ray>(), hit);
}
RUST
header=$(cargo metadata --format-version 1 --manifest-path "$work/Cargo.toml" 2> /dev/null |
    tr '"' '\n' | grep 'tinybvh-rs-0.1.0-beta.3/Cargo.toml$' | head -n 1)
cat > "$work/ray.cpp" <<'CPP'
#include "tiny_bvh.h"
#include <cstddef>
#include <cstdio>

int main() {
    printf("C++: %zu bytes, t at %zu\n", sizeof(tinybvh::Ray), offsetof(tinybvh::Ray, hit) + offsetof(tinybvh::Intersection, t));
}
CPP
c++ -std=c++20 -w -I "$(dirname "$header")/ffi/tinybvh" "$work/ray.cpp" -o "$work/ray"
{
    CARGO_TARGET_DIR="$work/target" cargo run --quiet --manifest-path "$work/Cargo.toml"
    "$work/ray"
} | tee "$work/out"
expected='Rust: 64 bytes, t at 48
C++: 128 bytes, t at 48'
if [ "$(cat "$work/out")" != "$expected" ]; then
    printf 'CHANGED: the two rays of tinybvh-rs 0.1.0-beta.3 are no longer of these sizes. Seen before:\n%s\n' "$expected" >&2
    exit 1
fi
echo "as described: C++ fills a ray twice as large as the place that the crate has for it"
