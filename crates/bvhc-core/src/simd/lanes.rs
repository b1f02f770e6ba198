//! Four floats in memory, as builders use them: every operation loads them, and what is not stored stays in a register.

use super::Register;

/// Four floats at a boundary of 16 bytes: three axes, and a fourth lane that nobody looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub struct Lanes(pub [f32; 4]);

crate::pod::plain! {
    Lanes = [[f32; 4]];
}

impl From<Register> for Lanes {
    #[inline(always)]
    fn from(register: Register) -> Lanes {
        Lanes(register.array())
    }
}

impl Lanes {
    /// The same float in every lane.
    #[inline]
    pub const fn splat(v: f32) -> Lanes {
        Lanes([v; 4])
    }

    /// A point, and 0 in the fourth lane.
    #[inline(always)]
    pub fn of_point(p: [f32; 3]) -> Lanes {
        Lanes([p[0], p[1], p[2], 0.0])
    }

    /// Each integer rounded to the nearest float.
    #[inline(always)]
    pub fn of_counts(counts: [i32; 4]) -> Lanes {
        Register::of_counts(counts).into()
    }

    /// The first three lanes.
    #[inline(always)]
    pub fn point(self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    /// The four floats in a register.
    #[inline(always)]
    pub fn load(self) -> Register {
        Register::of(self.0)
    }

    /// `if self < other { self } else { other }` per lane.
    #[inline(always)]
    pub fn min(self, other: Lanes) -> Lanes {
        self.load().min(other.load()).into()
    }

    /// `if self > other { self } else { other }` per lane.
    #[inline(always)]
    pub fn max(self, other: Lanes) -> Lanes {
        self.load().max(other.load()).into()
    }

    /// The sum per lane.
    #[inline(always)]
    pub fn plus(self, other: Lanes) -> Lanes {
        (self.load() + other.load()).into()
    }

    /// The difference per lane.
    #[inline(always)]
    pub fn minus(self, other: Lanes) -> Lanes {
        (self.load() - other.load()).into()
    }

    /// The product per lane.
    #[inline(always)]
    pub fn times(self, other: Lanes) -> Lanes {
        (self.load() * other.load()).into()
    }

    /// `if self < than { x } else { y }` per lane.
    #[inline(always)]
    pub fn if_less(self, than: Lanes, x: Lanes, y: Lanes) -> Lanes {
        self.load().if_less(than.load(), x.load(), y.load()).into()
    }

    /// The three axes, and 0 in the fourth lane. Needed before a multiplication: a reference's integers are tiny floats
    /// there, and processors take a hundred cycles for a product with one.
    #[inline(always)]
    pub fn axes(self) -> Lanes {
        self.load().axes().into()
    }

    /// The low byte of each lane's bits.
    #[inline(always)]
    pub fn low_bytes(self) -> [u32; 4] {
        self.load().low_bytes()
    }

    /// Columns of the matrix with these rows.
    #[inline(always)]
    pub fn transpose(rows: [Lanes; 4]) -> [Lanes; 4] {
        Register::transpose(rows.map(Lanes::load)).map(Lanes::from)
    }
}
