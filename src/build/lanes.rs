/// Four floats in one vector register: three axes, and a fourth lane that nobody looks at.
///
/// Plain array code with the semantics of SSE's `minps` and `maxps`, which the compiler turns into exactly those (and into their
/// NEON counterparts): one source, the same bits on every machine, nothing to keep in step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(16))]
pub(super) struct Lanes(pub [f32; 4]);

impl Lanes {
    pub const fn splat(v: f32) -> Lanes {
        Lanes([v; 4])
    }

    pub fn of_point(p: [f32; 3]) -> Lanes {
        Lanes([p[0], p[1], p[2], 0.0])
    }

    pub fn point(self) -> [f32; 3] {
        [self.0[0], self.0[1], self.0[2]]
    }

    #[inline(always)]
    pub fn zip(self, other: Lanes, f: impl Fn(f32, f32) -> f32) -> Lanes {
        let (a, b) = (self.0, other.0);
        Lanes([f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])])
    }

    #[inline(always)]
    pub fn min(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    pub fn max(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    pub fn plus(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| a + b)
    }

    #[inline(always)]
    pub fn minus(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| a - b)
    }

    #[inline(always)]
    pub fn times(self, other: Lanes) -> Lanes {
        self.zip(other, |a, b| a * b)
    }
}

/// A box in two registers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LaneBox {
    pub min: Lanes,
    pub max: Lanes,
}

impl LaneBox {
    pub const EMPTY: LaneBox = LaneBox { min: Lanes::splat(f32::INFINITY), max: Lanes::splat(f32::NEG_INFINITY) };

    #[inline(always)]
    pub fn union(self, other: LaneBox) -> LaneBox {
        LaneBox { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    #[inline(always)]
    pub fn grow(self, p: Lanes) -> LaneBox {
        LaneBox { min: self.min.min(p), max: self.max.max(p) }
    }

    /// See [`Aabb::half_area`](crate::geom::Aabb::half_area); the box must not be empty. Edges are scaled first.
    #[inline(always)]
    pub fn scaled_half_area(self, scale: f32) -> f32 {
        let [x, y, z, _] = self.max.minus(self.min).times(Lanes::splat(scale)).0;
        x * y + y * z + z * x
    }

    pub fn aabb(self) -> crate::geom::Aabb {
        crate::geom::Aabb { min: self.min.point(), max: self.max.point() }
    }
}

impl super::prim_ref::PrimRef {
    /// The box with the two integers in the fourth lanes.
    #[inline(always)]
    pub(super) fn lanes(&self) -> LaneBox {
        let [min, max]: [[f32; 4]; 2] = bytemuck::cast(*self);
        LaneBox { min: Lanes(min), max: Lanes(max) }
    }
}
