#!/usr/bin/env bash
# Crate gltf 1.4.1: one animation channel without a node makes a whole valid model unreadable, its meshes included.
#
# Expected: a channel's target.node may be absent, and such a channel is to be ignored (glTF 2.0, section 3.11). Extensions that animate
# other things, as KHR_animation_pointer, demand that it is absent.
# Seen: opening fails with "missing field node". The triangle of the file cannot be had, nor the channel that does have a node. The same
# file without that channel opens.
# Hurts: Rust tools that only want the triangles of an animated model; exporters that animate materials or lights by pointers.
# bvhc: reads the animation by structures of its own, passes over such channels, and poses by the others (docs/inputs.md, Animations).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/src"
cat > "$work/Cargo.toml" <<'TOML'
[package]
name = "channel"
version = "0.0.0"
edition = "2021"
[dependencies]
gltf = { version = "=1.4.1", default-features = false, features = ["utils"] }
[workspace]
TOML
cat > "$work/src/main.rs" <<'RUST'
fn model(channels: &str) -> String {
    // 36 bytes of a triangle, then the key times 0 and 1, then two translations: 68 bytes of an outside buffer that is never needed here.
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]}},
        {{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":8}},
        {{"buffer":0,"byteOffset":44,"byteLength":24}}],"buffers":[{{"byteLength":68,"uri":"triangle.bin"}}],
        "animations":[{{"samplers":[{{"input":1,"output":2}}],"channels":[{channels}]}}]}}"#
    )
}

fn main() {
    let with = r#"{"sampler":0,"target":{"node":0,"path":"translation"}}"#;
    let without = r#"{"sampler":0,"target":{"path":"translation"}}"#;
    for (name, channels) in [("all with a node", with.to_string()), ("one without", format!("{with},{without}"))] {
        match gltf::Gltf::from_slice(model(&channels).as_bytes()) {
            Ok(file) => println!("{name}: {} mesh, {} animation", file.meshes().count(), file.animations().count()),
            Err(error) => println!("{name}: {}", error.to_string().replace('`', "").split(" at line").next().unwrap_or_default()),
        }
    }
}
RUST
CARGO_TARGET_DIR="$work/target" cargo run --quiet --manifest-path "$work/Cargo.toml" | tee "$work/out"
expected='all with a node: 1 mesh, 1 animation
one without: missing field node'
if [ "$(cat "$work/out")" != "$expected" ]; then
    printf 'CHANGED: gltf 1.4.1 reads channels without a node otherwise. Seen before:\n%s\n' "$expected" >&2
    exit 1
fi
echo "as described: a channel without a node makes gltf 1.4.1 refuse the model"
