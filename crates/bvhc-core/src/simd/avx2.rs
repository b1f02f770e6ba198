//! Work compiled for processors with AVX2, chosen at run time, and eight floats in one register of theirs.

use super::floats::Floats;
use std::arch::x86_64::*;
use std::mem::transmute;

/// Run `work`, which the compiler inlines here and so translates for eight lanes. FMA is not asked for: every operation rounds as it
/// does elsewhere.
#[target_feature(enable = "avx2")]
pub fn run<R>(work: impl FnOnce(Door) -> R) -> R {
    work(Door(()))
}

/// Shows that the processor has AVX2: [`run`] alone makes one, and may only be called where that is so.
#[derive(Clone, Copy, Debug)]
pub struct Door(());

/// Eight floats in one register. There is none without a [`Door`].
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Octet(__m256);

macro_rules! operations {
    ($($name:ident($($operand:ident: $type:ty),*) -> $out:ty = $body:expr;)*) => {$(
        #[inline(always)]
        #[allow(unsafe_code)]
        fn $name($($operand: $type),*) -> $out {
            // SAFETY: the only precondition is AVX2. A door among the operands, or a register, which is made by one, shows that it was asked
            // for. Nothing here takes a pointer. What is transmuted is 32 bytes long on both sides, and every bit pattern is a value of both types.
            unsafe { $body }
        }
    )*};
}

impl Floats<8> for Octet {
    type Door = Door;

    operations! {
        splat(_door: Door, v: f32) -> Octet = Octet(_mm256_set1_ps(v));
        of(_door: Door, v: &[f32; 8]) -> Octet = Octet(transmute::<[f32; 8], __m256>(*v));
        of_bytes(_door: Door, v: &[u8; 8]) -> Octet =
            Octet(_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(i64::from_le_bytes(*v)))));
        array(v: Octet) -> [f32; 8] = transmute(v.0);
        plus(a: Octet, b: Octet) -> Octet = Octet(_mm256_add_ps(a.0, b.0));
        minus(a: Octet, b: Octet) -> Octet = Octet(_mm256_sub_ps(a.0, b.0));
        times(a: Octet, b: Octet) -> Octet = Octet(_mm256_mul_ps(a.0, b.0));
        max(a: Octet, b: Octet) -> Octet = Octet(_mm256_max_ps(a.0, b.0));
        negated(v: Octet) -> Octet = Octet(_mm256_xor_ps(v.0, _mm256_set1_ps(-0.0)));
        less_or_equal(a: Octet, b: Octet) -> u32 =
            _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a.0, b.0)) as u32;
    }
}
