//! Whole numbers, of 128 bits and of any size, and floats as such.

use num_bigint::{BigInt, Sign};

/// What the predicates need of a number.
pub(super) trait Whole: Sized {
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// −1, 0 or 1.
    fn sign(&self) -> i32;
    fn big(self) -> BigInt;
}

impl Whole for i128 {
    fn plus(&self, other: &i128) -> i128 {
        self + other
    }

    fn minus(&self, other: &i128) -> i128 {
        self - other
    }

    fn times(&self, other: &i128) -> i128 {
        self * other
    }

    fn sign(&self) -> i32 {
        self.signum() as i32
    }

    fn big(self) -> BigInt {
        BigInt::from(self)
    }
}

impl Whole for BigInt {
    fn plus(&self, other: &BigInt) -> BigInt {
        self + other
    }

    fn minus(&self, other: &BigInt) -> BigInt {
        self - other
    }

    fn times(&self, other: &BigInt) -> BigInt {
        self * other
    }

    fn sign(&self) -> i32 {
        match BigInt::sign(self) {
            Sign::Minus => -1,
            Sign::NoSign => 0,
            Sign::Plus => 1,
        }
    }

    fn big(self) -> BigInt {
        self
    }
}

/// A finite float as an odd whole number (or 0) and the power of two that it is multiplied by.
pub(super) fn parts(v: f32) -> (i64, i32) {
    let bits = v.to_bits();
    let (exponent, fraction) = ((bits >> 23 & 0xFF) as i32, i64::from(bits & 0x7F_FFFF));
    let (m, e) = if exponent == 0 { (fraction, -149) } else { (fraction | 1 << 23, exponent - 150) };
    if m == 0 {
        return (0, 0);
    }
    let odd = m >> m.trailing_zeros();
    (if v < 0.0 { -odd } else { odd }, e + m.trailing_zeros() as i32)
}

/// The numbers over their smallest power of two, if none then exceeds 2⁴⁰: differences are below 2⁴¹, what [`crossing`](super::crossing) multiplies and
/// adds up below `3 · 2·2⁸² · 2⁴¹ < 2¹²⁶`.
pub(super) fn fit<const N: usize>(numbers: &[(i64, i32); N]) -> Option<([i128; N], i32)> {
    let least = least_exponent(numbers);
    let mut out = [0; N];
    for (slot, &(m, e)) in out.iter_mut().zip(numbers) {
        let bits = 64 - m.unsigned_abs().leading_zeros() as i32;
        if m != 0 {
            if e - least + bits > 40 {
                return None;
            }
            *slot = i128::from(m) << (e - least);
        }
    }
    Some((out, least))
}

/// The numbers over their smallest power of two.
pub(super) fn aligned(numbers: &[(i64, i32)]) -> (Vec<BigInt>, i32) {
    let least = least_exponent(numbers);
    let scaled = |&(m, e): &(i64, i32)| if m == 0 { BigInt::ZERO } else { BigInt::from(m) << (e - least) };
    (numbers.iter().map(scaled).collect(), least)
}

fn least_exponent(numbers: &[(i64, i32)]) -> i32 {
    numbers.iter().filter(|(m, _)| *m != 0).map(|(_, e)| *e).min().unwrap_or(0)
}
