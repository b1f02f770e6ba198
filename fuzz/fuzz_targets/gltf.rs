#![no_main]

bvhc_fuzz::fuzz!("gltf");
