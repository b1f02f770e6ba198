//! The operations as NEON instructions, which every 64-bit Arm processor that runs programs has. [`portable`](super::portable) says what they mean.
//!
//! Arm's own minimum and maximum return NaN where one operand is NaN and order the two zeros, so both are a comparison and a choice.

use std::arch::aarch64::*;
use std::mem::transmute;

/// Four floats.
pub type Vector = float32x4_t;

macro_rules! operations {
    ($($name:ident($($operand:ident: $type:ty),*) -> $out:ty = $body:expr;)*) => {$(
        #[inline(always)]
        #[allow(unsafe_code)]
        pub fn $name($($operand: $type),*) -> $out {
            // SAFETY: the only precondition is NEON, and that is part of the baseline of all targets with a standard library. Nothing here takes a pointer. What is transmuted
            // is 16 bytes long on both sides, and every bit pattern is a value of both types.
            unsafe { $body }
        }
    )*};
}

/// A bit per lane of a comparison's result.
#[inline(always)]
#[allow(unsafe_code)]
fn mask_bits(mask: uint32x4_t) -> u32 {
    // SAFETY: as of the operations below.
    unsafe { vaddvq_u32(vandq_u32(mask, transmute::<[u32; 4], uint32x4_t>([1, 2, 4, 8]))) }
}

operations! {
    of(v: [f32; 4]) -> Vector = transmute(v);
    array(v: Vector) -> [f32; 4] = transmute(v);
    min(a: Vector, b: Vector) -> Vector = vbslq_f32(vcltq_f32(a, b), a, b);
    max(a: Vector, b: Vector) -> Vector = vbslq_f32(vcgtq_f32(a, b), a, b);
    add(a: Vector, b: Vector) -> Vector = vaddq_f32(a, b);
    sub(a: Vector, b: Vector) -> Vector = vsubq_f32(a, b);
    mul(a: Vector, b: Vector) -> Vector = vmulq_f32(a, b);
    and(a: Vector, b: Vector) -> Vector =
        vreinterpretq_f32_u32(vandq_u32(vreinterpretq_u32_f32(a), vreinterpretq_u32_f32(b)));
    xor(a: Vector, b: Vector) -> Vector =
        vreinterpretq_f32_u32(veorq_u32(vreinterpretq_u32_f32(a), vreinterpretq_u32_f32(b)));
    less(a: Vector, b: Vector) -> u32 = mask_bits(vcltq_f32(a, b));
    less_or_equal(a: Vector, b: Vector) -> u32 = mask_bits(vcleq_f32(a, b));
    if_less(a: Vector, b: Vector, x: Vector, y: Vector) -> Vector = vbslq_f32(vcltq_f32(a, b), x, y);
    axes(a: Vector) -> Vector = vsetq_lane_f32::<3>(0.0, a);
    mix(a: Vector, b: Vector, first: f64, second: f64) -> Vector = {
        let (x, y) = (vdupq_n_f64(first), vdupq_n_f64(second));
        let (a_low, b_low) = (vcvt_f64_f32(vget_low_f32(a)), vcvt_f64_f32(vget_low_f32(b)));
        let low = vaddq_f64(vmulq_f64(x, a_low), vmulq_f64(y, b_low));
        let high = vaddq_f64(vmulq_f64(x, vcvt_high_f64_f32(a)), vmulq_f64(y, vcvt_high_f64_f32(b)));
        vcombine_f32(vcvt_f32_f64(low), vcvt_f32_f64(high))
    };
    low_bytes(a: Vector) -> [u32; 4] = transmute(vandq_u32(vreinterpretq_u32_f32(a), vdupq_n_u32(0xff)));
    from_counts(counts: [i32; 4]) -> Vector = vcvtq_f32_s32(transmute::<[i32; 4], int32x4_t>(counts));
    upper(a: Vector) -> Vector = vcombine_f32(vget_high_f32(a), vget_high_f32(a));
    previous(a: Vector) -> Vector = {
        // Lane 1 twice, behind lanes 2 and 0.
        let first_two = vset_lane_f32::<0>(vgetq_lane_f32::<2>(a), vdup_laneq_f32::<0>(a));
        vcombine_f32(first_two, vdup_laneq_f32::<1>(a))
    };
    transpose(rows: [Vector; 4]) -> [Vector; 4] = {
        let [a, b, c, d] = rows;
        let (ab_low, cd_low) = (vzip1q_f32(a, b), vzip1q_f32(c, d));
        let (ab_high, cd_high) = (vzip2q_f32(a, b), vzip2q_f32(c, d));
        [
            vcombine_f32(vget_low_f32(ab_low), vget_low_f32(cd_low)),
            vcombine_f32(vget_high_f32(ab_low), vget_high_f32(cd_low)),
            vcombine_f32(vget_low_f32(ab_high), vget_low_f32(cd_high)),
            vcombine_f32(vget_high_f32(ab_high), vget_high_f32(cd_high)),
        ]
    };
    transpose_three(rows: [Vector; 3]) -> [Vector; 3] = {
        let [a, b, c] = rows;
        let low = vzip1q_f32(a, b);
        [
            vcombine_f32(vget_low_f32(low), vdup_laneq_f32::<0>(c)),
            vcombine_f32(vget_high_f32(low), vdup_laneq_f32::<1>(c)),
            vcombine_f32(vget_low_f32(vzip2q_f32(a, b)), vdup_laneq_f32::<2>(c)),
        ]
    };
}
