//! Four floats in one vector register: the door behind which traversal's vector instructions stand.
//!
//! `portable` says what each operation means and runs on any machine; `sse2`, which every x86-64 processor has, is its twin with the
//! same bits, as a test below proves. Left to itself the compiler takes the plain forms apart into scalars.

#[cfg(any(test, not(target_arch = "x86_64")))]
mod portable {
    pub type Lanes = [f32; 4];

    #[inline(always)]
    fn zip(a: Lanes, b: Lanes, f: impl Fn(f32, f32) -> f32) -> Lanes {
        [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
    }

    #[inline(always)]
    fn zip_bits(a: Lanes, b: Lanes, f: impl Fn(u32, u32) -> u32) -> Lanes {
        zip(a, b, |a, b| f32::from_bits(f(a.to_bits(), b.to_bits())))
    }

    #[cfg(not(target_arch = "x86_64"))]
    #[inline(always)]
    pub fn of(v: [f32; 4]) -> Lanes {
        v
    }

    #[cfg(not(target_arch = "x86_64"))]
    #[inline(always)]
    pub fn array(v: Lanes) -> [f32; 4] {
        v
    }

    #[inline(always)]
    pub fn add(a: Lanes, b: Lanes) -> Lanes {
        zip(a, b, |a, b| a + b)
    }

    #[inline(always)]
    pub fn sub(a: Lanes, b: Lanes) -> Lanes {
        zip(a, b, |a, b| a - b)
    }

    #[inline(always)]
    pub fn mul(a: Lanes, b: Lanes) -> Lanes {
        zip(a, b, |a, b| a * b)
    }

    /// `if a > b { a } else { b }`: where one is NaN, `b`.
    #[inline(always)]
    pub fn max(a: Lanes, b: Lanes) -> Lanes {
        zip(a, b, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    pub fn and(a: Lanes, b: Lanes) -> Lanes {
        zip_bits(a, b, |a, b| a & b)
    }

    #[inline(always)]
    pub fn xor(a: Lanes, b: Lanes) -> Lanes {
        zip_bits(a, b, |a, b| a ^ b)
    }

    /// A bit per lane, the first lane's lowest: `a < b`.
    #[inline(always)]
    pub fn less(a: Lanes, b: Lanes) -> u32 {
        (0..4).fold(0, |bits, i| bits | u32::from(a[i] < b[i]) << i)
    }

    /// A bit per lane, the first lane's lowest: `a <= b`.
    #[inline(always)]
    pub fn less_or_equal(a: Lanes, b: Lanes) -> u32 {
        (0..4).fold(0, |bits, i| bits | u32::from(a[i] <= b[i]) << i)
    }

    /// Lanes 2, 3, 2, 3.
    #[inline(always)]
    pub fn upper(a: Lanes) -> Lanes {
        [a[2], a[3], a[2], a[3]]
    }

    /// Lanes 2, 0, 1, 1.
    #[inline(always)]
    pub fn previous(a: Lanes) -> Lanes {
        [a[2], a[0], a[1], a[1]]
    }

    /// Per axis the lanes `a, b, c, d`.
    #[inline(always)]
    pub fn axes_of_four(a: Lanes, b: Lanes, c: Lanes, d: Lanes) -> [Lanes; 3] {
        [0, 1, 2].map(|k| [a[k], b[k], c[k], d[k]])
    }

    /// Per axis the lanes `a, b, c, c`.
    #[inline(always)]
    pub fn axes_of_three(a: Lanes, b: Lanes, c: Lanes) -> [Lanes; 3] {
        [0, 1, 2].map(|k| [a[k], b[k], c[k], c[k]])
    }
}

#[cfg(target_arch = "x86_64")]
mod sse2 {
    use std::arch::x86_64::*;

    pub type Lanes = __m128;

    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn of(v: [f32; 4]) -> Lanes {
        // SAFETY: both are 16 bytes, and every bit pattern is a value of both.
        unsafe { std::mem::transmute(v) }
    }

    #[inline(always)]
    #[allow(unsafe_code)]
    pub fn array(v: Lanes) -> [f32; 4] {
        // SAFETY: as above.
        unsafe { std::mem::transmute(v) }
    }

    macro_rules! operations {
        ($($name:ident($($operand:ident),*) -> $out:ty = $body:expr;)*) => {$(
            #[inline(always)]
            #[allow(unsafe_code)]
            pub fn $name($($operand: Lanes),*) -> $out {
                // SAFETY: the only precondition is SSE2, and that is part of the x86-64 baseline. Nothing here takes a pointer.
                unsafe { $body }
            }
        )*};
    }

    operations! {
        add(a, b) -> Lanes = _mm_add_ps(a, b);
        sub(a, b) -> Lanes = _mm_sub_ps(a, b);
        mul(a, b) -> Lanes = _mm_mul_ps(a, b);
        max(a, b) -> Lanes = _mm_max_ps(a, b);
        and(a, b) -> Lanes = _mm_and_ps(a, b);
        xor(a, b) -> Lanes = _mm_xor_ps(a, b);
        less(a, b) -> u32 = _mm_movemask_ps(_mm_cmplt_ps(a, b)) as u32;
        less_or_equal(a, b) -> u32 = _mm_movemask_ps(_mm_cmple_ps(a, b)) as u32;
        upper(a) -> Lanes = _mm_movehl_ps(a, a);
        previous(a) -> Lanes = _mm_shuffle_ps::<0b01_01_00_10>(a, a);
        axes_of_four(a, b, c, d) -> [Lanes; 3] = {
            let (ab, cd) = (_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d));
            [
                _mm_movelh_ps(ab, cd),
                _mm_movehl_ps(cd, ab),
                _mm_movelh_ps(_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, d)),
            ]
        };
        axes_of_three(a, b, c) -> [Lanes; 3] = {
            let ab = _mm_unpacklo_ps(a, b);
            [
                _mm_shuffle_ps::<0b00_00_01_00>(ab, c),
                _mm_shuffle_ps::<0b01_01_11_10>(ab, c),
                _mm_shuffle_ps::<0b10_10_01_00>(_mm_unpackhi_ps(a, b), c),
            ]
        };
    }
}

#[cfg(not(target_arch = "x86_64"))]
pub use portable::*;
#[cfg(target_arch = "x86_64")]
pub use sse2::*;

#[inline(always)]
pub fn splat(v: f32) -> Lanes {
    of([v; 4])
}

/// Absolute values.
#[inline(always)]
pub fn abs(a: Lanes) -> Lanes {
    and(a, splat(f32::from_bits(0x7FFF_FFFF)))
}

#[inline(always)]
pub fn negated(a: Lanes) -> Lanes {
    xor(a, splat(-0.0))
}

#[cfg(test)]
mod tests {
    use super::portable;

    /// NaN made by arithmetic has no specified bits.
    fn same(a: super::Lanes, b: [f32; 4]) -> bool {
        super::array(a).iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()))
    }

    #[test]
    fn both_twins_give_the_same_bits() {
        let special = [
            0.0,
            -0.0,
            1.0,
            -1.5,
            0.1,
            1e-45,
            -1e-40,
            f32::MAX,
            f32::MIN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
            -f32::NAN,
        ];
        let vector = |i: usize| [0, 1, 2, 3].map(|k| special[(i * (k + 1) + k) % special.len()]);
        for i in 0..special.len() {
            for j in 0..special.len() {
                let (a, b, c, d) = (vector(i), vector(j), vector(i + j), vector(i * j + 1));
                let [va, vb, vc, vd] = [a, b, c, d].map(super::of);
                assert!(same(super::add(va, vb), portable::add(a, b)) && same(super::sub(va, vb), portable::sub(a, b)));
                assert!(same(super::mul(va, vb), portable::mul(a, b)) && same(super::max(va, vb), portable::max(a, b)));
                assert!(same(super::and(va, vb), portable::and(a, b)) && same(super::xor(va, vb), portable::xor(a, b)));
                assert_eq!(super::less(va, vb), portable::less(a, b), "{a:?} {b:?}");
                assert_eq!(super::less_or_equal(va, vb), portable::less_or_equal(a, b), "{a:?} {b:?}");
                assert!(same(super::upper(va), portable::upper(a)) && same(super::previous(va), portable::previous(a)));
                let (four, three) = (super::axes_of_four(va, vb, vc, vd), super::axes_of_three(va, vb, vc));
                assert!(four.into_iter().zip(portable::axes_of_four(a, b, c, d)).all(|(x, y)| same(x, y)));
                assert!(three.into_iter().zip(portable::axes_of_three(a, b, c)).all(|(x, y)| same(x, y)));
            }
        }
    }
}
