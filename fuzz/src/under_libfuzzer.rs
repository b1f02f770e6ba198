//! A target as libFuzzer wants it: one function for a case, one for a change.

use crate::mutate::{Bytes, Dice};
use crate::planted::Plan;
use crate::{guard, targets};
use std::sync::OnceLock;

/// The two functions of a target.
#[macro_export]
macro_rules! fuzz {
    ($name:literal) => {
        libfuzzer_sys::fuzz_target!(|input: &[u8]| $crate::under_libfuzzer::case($name, input));
        libfuzzer_sys::fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
            $crate::under_libfuzzer::change($name, data, size, max_size, seed)
        });
    };
}

/// Run one case. `BVHC_PLANT` names a planted fault that it shall find.
pub fn case(name: &str, input: &[u8]) {
    static PLAN: OnceLock<Plan> = OnceLock::new();
    let target = targets::by_name(name).expect("a target of this name");
    let plan = PLAN.get_or_init(|| Plan::of(target, std::env::var("BVHC_PLANT").ok().as_deref()));
    guard::hold(target, input, plan);
}

/// Change the input in its own terms, or as libFuzzer changes any bytes.
pub fn change(name: &str, data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let target = targets::by_name(name).expect("a target of this name");
    let mut input = data[..size].to_vec();
    let mut any = |bytes: &mut Vec<u8>, room: usize| {
        let len = bytes.len().min(room);
        bytes.resize(room.max(1), 0);
        let changed = libfuzzer_sys::fuzzer_mutate(bytes, len, room.max(1));
        bytes.truncate(changed);
    };
    (target.change)(&mut input, &mut Dice::new(u64::from(seed)), &mut Bytes { room: max_size, any: &mut any });
    let len = input.len().min(max_size);
    data[..len].copy_from_slice(&input[..len]);
    len
}
