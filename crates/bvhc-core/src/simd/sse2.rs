//! The operations as SSE2 instructions, which every x86-64 processor has. [`portable`](super::portable) says what they mean.

use std::arch::x86_64::*;
use std::mem::transmute;

/// Four floats.
pub type Vector = __m128;

macro_rules! operations {
    ($($name:ident($($operand:ident: $type:ty),*) -> $out:ty = $body:expr;)*) => {$(
        #[inline(always)]
        #[allow(unsafe_code)]
        pub fn $name($($operand: $type),*) -> $out {
            // SAFETY: the only precondition is SSE2, and that is part of the x86-64 baseline. Nothing here takes a pointer. What is transmuted
            // is 16 bytes long on both sides, and every bit pattern is a value of both types.
            unsafe { $body }
        }
    )*};
}

operations! {
    of(v: [f32; 4]) -> Vector = transmute(v);
    array(v: Vector) -> [f32; 4] = transmute(v);
    min(a: Vector, b: Vector) -> Vector = _mm_min_ps(a, b);
    max(a: Vector, b: Vector) -> Vector = _mm_max_ps(a, b);
    add(a: Vector, b: Vector) -> Vector = _mm_add_ps(a, b);
    sub(a: Vector, b: Vector) -> Vector = _mm_sub_ps(a, b);
    mul(a: Vector, b: Vector) -> Vector = _mm_mul_ps(a, b);
    and(a: Vector, b: Vector) -> Vector = _mm_and_ps(a, b);
    xor(a: Vector, b: Vector) -> Vector = _mm_xor_ps(a, b);
    less(a: Vector, b: Vector) -> u32 = _mm_movemask_ps(_mm_cmplt_ps(a, b)) as u32;
    less_or_equal(a: Vector, b: Vector) -> u32 = _mm_movemask_ps(_mm_cmple_ps(a, b)) as u32;
    if_less(a: Vector, b: Vector, x: Vector, y: Vector) -> Vector = {
        let mask = _mm_cmplt_ps(a, b);
        _mm_or_ps(_mm_and_ps(mask, x), _mm_andnot_ps(mask, y))
    };
    axes(a: Vector) -> Vector = _mm_and_ps(a, transmute::<[u32; 4], Vector>([!0, !0, !0, 0]));
    mix(a: Vector, b: Vector, first: f64, second: f64) -> Vector = {
        let (x, y) = (_mm_set1_pd(first), _mm_set1_pd(second));
        let low = _mm_add_pd(_mm_mul_pd(x, _mm_cvtps_pd(a)), _mm_mul_pd(y, _mm_cvtps_pd(b)));
        let (a, b) = (_mm_movehl_ps(a, a), _mm_movehl_ps(b, b));
        let high = _mm_add_pd(_mm_mul_pd(x, _mm_cvtps_pd(a)), _mm_mul_pd(y, _mm_cvtps_pd(b)));
        _mm_movelh_ps(_mm_cvtpd_ps(low), _mm_cvtpd_ps(high))
    };
    low_bytes(a: Vector) -> [u32; 4] =
        transmute(_mm_and_si128(_mm_castps_si128(a), transmute::<[u32; 4], __m128i>([0xff; 4])));
    from_counts(counts: [i32; 4]) -> Vector = _mm_cvtepi32_ps(transmute::<[i32; 4], __m128i>(counts));
    upper(a: Vector) -> Vector = _mm_movehl_ps(a, a);
    previous(a: Vector) -> Vector = _mm_shuffle_ps::<0b01_01_00_10>(a, a);
    transpose(rows: [Vector; 4]) -> [Vector; 4] = {
        let [a, b, c, d] = rows;
        let (ab_low, cd_low) = (_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, d));
        [
            _mm_movelh_ps(ab_low, cd_low),
            _mm_movehl_ps(cd_low, ab_low),
            _mm_movelh_ps(ab_high, cd_high),
            _mm_movehl_ps(cd_high, ab_high),
        ]
    };
    transpose_three(rows: [Vector; 3]) -> [Vector; 3] = {
        let [a, b, c] = rows;
        let low = _mm_unpacklo_ps(a, b);
        [
            _mm_shuffle_ps::<0b00_00_01_00>(low, c),
            _mm_shuffle_ps::<0b01_01_11_10>(low, c),
            _mm_shuffle_ps::<0b10_10_01_00>(_mm_unpackhi_ps(a, b), c),
        ]
    };
}
