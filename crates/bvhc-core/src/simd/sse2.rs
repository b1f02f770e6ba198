//! The operations as SSE2 instructions, which every x86-64 processor has. Left to itself the compiler takes some of the
//! plain forms apart into four scalars and branches.

use std::arch::x86_64 as x86;
use std::arch::x86_64::{__m128, __m128i};
use std::mem::transmute;

type V = [f32; 4];

#[inline(always)]
fn to(v: V) -> __m128 {
    // SAFETY: both are 16 bytes, and every bit pattern is a value of both.
    unsafe { transmute(v) }
}

#[inline(always)]
fn from(v: __m128) -> V {
    // SAFETY: as above.
    unsafe { transmute(v) }
}

#[inline(always)]
fn to_integers(v: [u32; 4]) -> __m128i {
    // SAFETY: as above.
    unsafe { transmute(v) }
}

macro_rules! two_operands {
    ($($name:ident = $instruction:ident),*) => {$(
        #[inline(always)]
        pub fn $name(a: V, b: V) -> V {
            // SAFETY: the only precondition is SSE2, and that is part of the x86-64 baseline.
            from(unsafe { x86::$instruction(to(a), to(b)) })
        }
    )*};
}

two_operands!(min = _mm_min_ps, max = _mm_max_ps, add = _mm_add_ps, sub = _mm_sub_ps, mul = _mm_mul_ps);

#[inline(always)]
pub fn if_less(a: V, b: V, x: V, y: V) -> V {
    // SAFETY: as above.
    from(unsafe {
        let mask = x86::_mm_cmplt_ps(to(a), to(b));
        x86::_mm_or_ps(x86::_mm_and_ps(mask, to(x)), x86::_mm_andnot_ps(mask, to(y)))
    })
}

#[inline(always)]
pub fn axes(a: V) -> V {
    // SAFETY: as above.
    from(unsafe { x86::_mm_and_ps(to(a), x86::_mm_castsi128_ps(to_integers([!0, !0, !0, 0]))) })
}

#[inline(always)]
pub fn low_bytes(a: V) -> [u32; 4] {
    // SAFETY: as above.
    unsafe { transmute(x86::_mm_and_si128(x86::_mm_castps_si128(to(a)), to_integers([0xff; 4]))) }
}

#[inline(always)]
pub fn from_counts(counts: [i32; 4]) -> V {
    // SAFETY: as above.
    from(unsafe { x86::_mm_cvtepi32_ps(transmute::<[i32; 4], __m128i>(counts)) })
}

#[inline(always)]
pub fn transpose(r: [V; 4]) -> [V; 4] {
    let [a, b, c, d] = r.map(to);
    // SAFETY: as above.
    unsafe {
        let (ab_low, cd_low) = (x86::_mm_unpacklo_ps(a, b), x86::_mm_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (x86::_mm_unpackhi_ps(a, b), x86::_mm_unpackhi_ps(c, d));
        [
            from(x86::_mm_movelh_ps(ab_low, cd_low)),
            from(x86::_mm_movehl_ps(cd_low, ab_low)),
            from(x86::_mm_movelh_ps(ab_high, cd_high)),
            from(x86::_mm_movehl_ps(cd_high, ab_high)),
        ]
    }
}
