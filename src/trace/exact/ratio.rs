use super::whole::parts;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// A rational number: `top / bottom · 2^exponent` with a positive `bottom`. Compared by value.
#[derive(Clone, Debug)]
pub struct Ratio {
    top: BigInt,
    bottom: BigInt,
    exponent: i32,
}

impl Ratio {
    /// `bottom` is not zero.
    pub(super) fn new(top: BigInt, bottom: BigInt, exponent: i32) -> Ratio {
        if bottom.sign() == Sign::Minus {
            Ratio { top: -top, bottom: -bottom, exponent }
        } else {
            Ratio { top, bottom, exponent }
        }
    }

    /// Compare with a float, infinities included; `None` for NaN.
    pub fn compare(&self, v: f32) -> Option<Ordering> {
        if v.is_nan() {
            return None;
        }
        if v.is_infinite() {
            return Some(if v > 0.0 { Ordering::Less } else { Ordering::Greater });
        }
        let (m, e) = parts(v);
        Some(self.cmp(&Ratio { top: BigInt::from(m), bottom: BigInt::from(1), exponent: e }))
    }

    /// The nearest `f32`, of two equally near the even one; infinite beyond the largest.
    pub fn to_f32(&self) -> f32 {
        // 53 bits rounded to odd hold all that the second rounding asks for.
        self.to_f64() as f32
    }

    /// An `f64` within one unit in the last place: rounded to odd, so that rounding it on to 24 bits equals rounding once.
    pub fn to_f64(&self) -> f64 {
        let (top, bottom) = (self.top.magnitude(), self.bottom.magnitude());
        if top.bits() == 0 {
            return 0.0;
        }

        // A quotient of 65 to 67 bits, of which the first 53 are kept.
        let raise = 66 - (top.bits() as i64 - bottom.bits() as i64);
        let (top, bottom) = if raise >= 0 { (top << raise, bottom.clone()) } else { (top.clone(), bottom << -raise) };
        let quotient = &top / &bottom;
        let exact = &quotient * &bottom == top;
        let drop = quotient.bits() - 53;
        let kept = &quotient >> drop;
        let inexact = !exact || &kept << drop != quotient;
        let kept = kept.iter_u64_digits().next().unwrap_or(0) | u64::from(inexact);
        let value = scaled(kept as f64, drop as i64 - raise + i64::from(self.exponent));
        if self.top.sign() == Sign::Minus { -value } else { value }
    }
}

/// `v · 2^exponent`, in steps that do not overflow on the way to a finite result.
fn scaled(mut v: f64, mut exponent: i64) -> f64 {
    while exponent != 0 && v != 0.0 && v.is_finite() {
        let step = exponent.clamp(-1000, 1000);
        v *= 2f64.powi(step as i32);
        exponent -= step;
    }
    v
}

impl Ord for Ratio {
    fn cmp(&self, other: &Ratio) -> Ordering {
        let (left, right) = (self.top.sign(), other.top.sign());
        if left != right || left == Sign::NoSign {
            return left.cmp(&right);
        }
        let (left, right) = (&self.top * &other.bottom, &other.top * &self.bottom);
        match self.exponent - other.exponent {
            shift @ 0.. => (left << shift).cmp(&right),
            shift => left.cmp(&(right << -shift)),
        }
    }
}

impl PartialOrd for Ratio {
    fn partial_cmp(&self, other: &Ratio) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ratio {
    fn eq(&self, other: &Ratio) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ratio {}
