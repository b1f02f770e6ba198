#[cfg(feature = "opencl")]
use crate::geom::Ray;
use crate::trace::Hit;
use bytemuck::{Pod, Zeroable};

/// "Nothing was hit" in [`HitRecord::triangle`].
pub const NO_HIT: u32 = u32::MAX;
/// "One level" in [`HitRecord::instance`].
pub const NO_INSTANCE: u32 = u32::MAX;

/// A ray as devices read it: 32 bytes, two aligned 16-byte loads.
#[cfg(feature = "opencl")]
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RayRecord {
    pub origin: [f32; 3],
    pub t_min: f32,
    pub direction: [f32; 3],
    pub t_max: f32,
}

#[cfg(feature = "opencl")]
impl From<&Ray> for RayRecord {
    fn from(ray: &Ray) -> RayRecord {
        RayRecord { origin: ray.origin, t_min: ray.t_min, direction: ray.direction, t_max: ray.t_max }
    }
}

/// A hit as devices write it: 32 bytes. Two devices agree when the bytes are equal.
///
/// For [`Query::Any`](super::Query::Any) only `triangle` counts, and only whether it is [`NO_HIT`]: which triangle a shadow ray ends at is not
/// promised.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct HitRecord {
    /// The bits of the `f32` distance; 0 for a miss, as all fields but `triangle` and `instance`.
    pub t: u32,
    /// The bits of the `f32` weight of the second corner.
    pub u: u32,
    /// The bits of the `f32` weight of the third corner.
    pub v: u32,
    /// Number of the triangle in its source mesh.
    pub prim: u32,
    /// Row of `GEOM`.
    pub geom: u32,
    /// [`NO_INSTANCE`] in a one-level file and for a miss.
    pub instance: u32,
    /// Index in the whole file's `TRIS`; [`NO_HIT`] for a miss.
    pub triangle: u32,
    /// 0: the tree was walked to its end. Anything else says why not; see the device.
    pub status: u32,
}

impl HitRecord {
    /// The ray meets nothing.
    pub const MISS: HitRecord =
        HitRecord { t: 0, u: 0, v: 0, prim: 0, geom: 0, instance: NO_INSTANCE, triangle: NO_HIT, status: 0 };

    /// The answer to [`Query::Any`](super::Query::Any).
    pub fn any(hit: bool) -> HitRecord {
        HitRecord { triangle: if hit { 0 } else { NO_HIT }, ..HitRecord::MISS }
    }

    /// Whether the ray meets something.
    pub fn is_hit(&self) -> bool {
        self.triangle != NO_HIT
    }

    /// The record as traversal on the CPU returns it.
    pub fn hit(&self) -> Option<Hit> {
        self.is_hit().then(|| Hit {
            t: f32::from_bits(self.t),
            u: f32::from_bits(self.u),
            v: f32::from_bits(self.v),
            prim: self.prim,
            geom: self.geom,
            instance: (self.instance != NO_INSTANCE).then_some(self.instance),
            triangle: self.triangle as usize,
        })
    }
}

impl From<Option<Hit>> for HitRecord {
    fn from(hit: Option<Hit>) -> HitRecord {
        hit.map_or(HitRecord::MISS, |h| HitRecord {
            t: h.t.to_bits(),
            u: h.u.to_bits(),
            v: h.v.to_bits(),
            prim: h.prim,
            geom: h.geom,
            instance: h.instance.unwrap_or(NO_INSTANCE),
            triangle: h.triangle as u32,
            status: 0,
        })
    }
}
