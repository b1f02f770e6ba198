//! Four floats in one vector register, as traversal uses them. Left to itself the compiler takes plain forms apart into scalars.

use super::operations as ops;
use std::ops::{Add, BitAnd, BitXor, Mul, Sub};

/// Four floats in one vector register. For memory: [`Lanes`](super::Lanes).
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Register(ops::Vector);

impl Register {
    /// These four floats, the first in the lowest lane.
    #[inline(always)]
    pub fn of(v: [f32; 4]) -> Register {
        Register(ops::of(v))
    }

    /// The same float in every lane.
    #[inline(always)]
    pub fn splat(v: f32) -> Register {
        Register::of([v; 4])
    }

    /// Each integer rounded to the nearest float.
    #[inline(always)]
    pub fn of_counts(counts: [i32; 4]) -> Register {
        Register(ops::from_counts(counts))
    }

    /// The four floats.
    #[inline(always)]
    pub fn array(self) -> [f32; 4] {
        ops::array(self.0)
    }

    /// `if self < other { self } else { other }` per lane: where one is NaN, `other`.
    #[inline(always)]
    pub fn min(self, other: Register) -> Register {
        Register(ops::min(self.0, other.0))
    }

    /// `if self > other { self } else { other }` per lane: where one is NaN, `other`.
    #[inline(always)]
    pub fn max(self, other: Register) -> Register {
        Register(ops::max(self.0, other.0))
    }

    /// A bit per lane, the first lane's lowest: `self < than`.
    #[inline(always)]
    pub fn less(self, than: Register) -> u32 {
        ops::less(self.0, than.0)
    }

    /// A bit per lane, the first lane's lowest: `self <= than`.
    #[inline(always)]
    pub fn less_or_equal(self, than: Register) -> u32 {
        ops::less_or_equal(self.0, than.0)
    }

    /// `if self < than { x } else { y }` per lane.
    #[inline(always)]
    pub fn if_less(self, than: Register, x: Register, y: Register) -> Register {
        Register(ops::if_less(self.0, than.0, x.0, y.0))
    }

    /// `first·self + second·other` per lane, with products and sum in `f64` and the result rounded once.
    #[inline(always)]
    pub fn mix(self, other: Register, first: f64, second: f64) -> Register {
        Register(ops::mix(self.0, other.0, first, second))
    }

    /// Absolute values.
    #[inline(always)]
    pub fn abs(self) -> Register {
        self & Register::splat(f32::from_bits(0x7FFF_FFFF))
    }

    /// Every sign exchanged, those of zeros and NaN too.
    #[inline(always)]
    pub fn negated(self) -> Register {
        self ^ Register::splat(-0.0)
    }

    /// The first three lanes, and 0.
    #[inline(always)]
    pub fn axes(self) -> Register {
        Register(ops::axes(self.0))
    }

    /// The low byte of each lane's bits.
    #[inline(always)]
    pub fn low_bytes(self) -> [u32; 4] {
        ops::low_bytes(self.0)
    }

    /// Lanes 2, 3, 2, 3.
    #[inline(always)]
    pub fn upper(self) -> Register {
        Register(ops::upper(self.0))
    }

    /// Lanes 2, 0, 1, 1.
    #[inline(always)]
    pub fn previous(self) -> Register {
        Register(ops::previous(self.0))
    }

    /// Columns of the matrix with these rows.
    #[inline(always)]
    pub fn transpose(rows: [Register; 4]) -> [Register; 4] {
        let [a, b, c, d] = rows;
        let [a, b, c, d] = ops::transpose([a.0, b.0, c.0, d.0]);
        [Register(a), Register(b), Register(c), Register(d)]
    }

    /// The first three columns of the matrix with these rows and the last row once more.
    #[inline(always)]
    pub fn transpose_three(rows: [Register; 3]) -> [Register; 3] {
        let [a, b, c] = rows;
        let [a, b, c] = ops::transpose_three([a.0, b.0, c.0]);
        [Register(a), Register(b), Register(c)]
    }
}

macro_rules! operators {
    ($($trait:ident::$method:ident = $operation:ident;)*) => {$(
        impl $trait for Register {
            type Output = Register;

            #[inline(always)]
            fn $method(self, other: Register) -> Register {
                Register(ops::$operation(self.0, other.0))
            }
        }
    )*};
}

operators! {
    Add::add = add;
    Sub::sub = sub;
    Mul::mul = mul;
    BitAnd::bitand = and;
    BitXor::bitxor = xor;
}
