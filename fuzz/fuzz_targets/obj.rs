#![no_main]

bvhc_fuzz::fuzz!("obj");
