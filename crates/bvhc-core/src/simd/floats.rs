//! As many floats at once as a wide node has children, whatever registers hold them.

use super::Register;

/// `N` floats in registers. Every implementation gives the same bits.
///
/// The operations are functions without `self`, so that all of them have one form.
pub trait Floats<const N: usize>: Copy {
    /// What shows that the processor has the registers.
    type Door: Copy;

    /// The same float in every lane.
    fn splat(door: Self::Door, v: f32) -> Self;
    /// These floats, the first in the lowest lane.
    fn of(door: Self::Door, v: &[f32; N]) -> Self;
    /// These small numbers.
    fn of_bytes(door: Self::Door, v: &[u8; N]) -> Self;
    /// The floats.
    fn array(v: Self) -> [f32; N];
    /// The sum per lane.
    fn plus(a: Self, b: Self) -> Self;
    /// The difference per lane.
    fn minus(a: Self, b: Self) -> Self;
    /// The product per lane.
    fn times(a: Self, b: Self) -> Self;
    /// `if a > b { a } else { b }` per lane: where one is NaN, `b`.
    fn max(a: Self, b: Self) -> Self;
    /// Every sign exchanged, those of zeros and NaN too.
    fn negated(v: Self) -> Self;
    /// A bit per lane, the first lane's lowest: `a <= b`.
    fn less_or_equal(a: Self, b: Self) -> u32;
}

impl Floats<4> for Register {
    type Door = ();

    #[inline(always)]
    fn splat(_: (), v: f32) -> Register {
        Register::splat(v)
    }

    #[inline(always)]
    fn of(_: (), v: &[f32; 4]) -> Register {
        Register::of(*v)
    }

    #[inline(always)]
    fn of_bytes(_: (), v: &[u8; 4]) -> Register {
        Register::of_counts(v.map(i32::from))
    }

    #[inline(always)]
    fn plus(a: Register, b: Register) -> Register {
        a + b
    }

    #[inline(always)]
    fn array(v: Register) -> [f32; 4] {
        v.array()
    }

    #[inline(always)]
    fn minus(a: Register, b: Register) -> Register {
        a - b
    }

    #[inline(always)]
    fn times(a: Register, b: Register) -> Register {
        a * b
    }

    #[inline(always)]
    fn max(a: Register, b: Register) -> Register {
        a.max(b)
    }

    #[inline(always)]
    fn negated(v: Register) -> Register {
        v.negated()
    }

    #[inline(always)]
    fn less_or_equal(a: Register, b: Register) -> u32 {
        a.less_or_equal(b)
    }
}

/// Eight floats in two registers of four.
impl Floats<8> for [Register; 2] {
    type Door = ();

    #[inline(always)]
    fn splat(_: (), v: f32) -> [Register; 2] {
        [Register::splat(v); 2]
    }

    #[inline(always)]
    fn of(_: (), v: &[f32; 8]) -> [Register; 2] {
        let halves: [[f32; 4]; 2] = bytemuck::cast(*v);
        halves.map(Register::of)
    }

    #[inline(always)]
    fn of_bytes(_: (), v: &[u8; 8]) -> [Register; 2] {
        let halves: [[u8; 4]; 2] = bytemuck::cast(*v);
        halves.map(|half| Register::of_counts(half.map(i32::from)))
    }

    #[inline(always)]
    fn plus(a: [Register; 2], b: [Register; 2]) -> [Register; 2] {
        [a[0] + b[0], a[1] + b[1]]
    }

    #[inline(always)]
    fn array(v: [Register; 2]) -> [f32; 8] {
        bytemuck::cast(v.map(Register::array))
    }

    #[inline(always)]
    fn minus(a: [Register; 2], b: [Register; 2]) -> [Register; 2] {
        [a[0] - b[0], a[1] - b[1]]
    }

    #[inline(always)]
    fn times(a: [Register; 2], b: [Register; 2]) -> [Register; 2] {
        [a[0] * b[0], a[1] * b[1]]
    }

    #[inline(always)]
    fn max(a: [Register; 2], b: [Register; 2]) -> [Register; 2] {
        [a[0].max(b[0]), a[1].max(b[1])]
    }

    #[inline(always)]
    fn negated(v: [Register; 2]) -> [Register; 2] {
        v.map(Register::negated)
    }

    #[inline(always)]
    fn less_or_equal(a: [Register; 2], b: [Register; 2]) -> u32 {
        a[0].less_or_equal(b[0]) | a[1].less_or_equal(b[1]) << 4
    }
}
