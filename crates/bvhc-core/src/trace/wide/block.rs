//! Four triangles at once: most misses are proved in `f32` for all of them together.

use crate::layout::TriangleRecord;
use crate::simd::Register;
use crate::trace::intersect::Filter;

/// Triangles of a block. More lanes would gain little, since most leaves have fewer triangles than eight.
pub const LANES: usize = 4;

/// The corners of up to four triangles, a lane for each: what rays that come to a leaf read.
///
/// By axis, then corner. A lane that nobody uses has the last triangle once more.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleBlock([[[f32; LANES]; 3]; 3]);

impl TriangleBlock {
    /// Of at most four triangles, and at least one.
    #[inline(always)]
    pub(super) fn new(triangles: &[TriangleRecord]) -> TriangleBlock {
        let last = triangles.len() - 1;
        let rows: &[[[f32; 4]; 3]] = bytemuck::cast_slice(triangles);
        let [a, b, c, d] = [&rows[0], &rows[last.min(1)], &rows[last.min(2)], &rows[last.min(3)]];
        let mut axes = [[[0.0; LANES]; 3]; 3];
        for corner in 0..3 {
            let rows =
                [Register::of(a[corner]), Register::of(b[corner]), Register::of(c[corner]), Register::of(d[corner])];
            let [x, y, z, _] = Register::transpose(rows);
            (axes[0][corner], axes[1][corner], axes[2][corner]) = (x.array(), y.array(), z.array());
        }
        TriangleBlock(axes)
    }

    /// One of the triangles, without its numbers.
    #[inline(always)]
    pub(super) fn triangle(&self, lane: usize) -> TriangleRecord {
        let [x, y, z] = &self.0;
        let lane = lane % LANES;
        TriangleRecord {
            v0: [x[0][lane], y[0][lane], z[0][lane]],
            prim: 0,
            v1: [x[1][lane], y[1][lane], z[1][lane]],
            geom: 0,
            v2: [x[2][lane], y[2][lane], z[2][lane]],
            flags: 0,
        }
    }

    /// A bit for each triangle whose miss is not proved.
    ///
    /// It is the arithmetic of `EdgeRay::surely_misses`, but that one bound serves for the three edges of a triangle: that of the farthest reach and the
    /// greatest depth of its corners. Sums and products grow with their operands, when rounded too, so it is not below any of the three, and what is
    /// rejected here is rejected there. Of a triangle with a corner that became no number, one edge function at most is a number, and that is not on both sides.
    ///
    /// Nothing here maps an array or is a closure: that is a call where it stands in code for wider vectors.
    #[inline(always)]
    pub(super) fn may_cross(&self, ray: &Filter) -> u32 {
        let ([kx, ky, kz], [x, y, z], [shear_x, shear_y]) = (ray.axes, ray.origin, ray.shear);
        let sheared = Sheared {
            axes: [&self.0[kx], &self.0[ky], &self.0[kz]],
            origin: [Register::splat(x), Register::splat(y), Register::splat(z)],
            shear: [Register::splat(shear_x), Register::splat(shear_y)],
        };
        let ([ax, ay, a_reach, a_depth], [bx, by, b_reach, b_depth], [cx, cy, c_reach, c_depth]) =
            (sheared.corner(0), sheared.corner(1), sheared.corner(2));
        let reach = a_reach.max(b_reach).max(c_reach);
        let depth = a_depth.max(b_depth).max(c_depth);
        let error = (reach + depth) * Register::splat(Filter::RELATIVE) + Register::splat(ray.slack);
        let half = (reach + error) * error;
        let overflow = reach * reach * Register::splat(0.0);
        let bound = half + half + Register::splat(Filter::UNDERFLOW) + overflow;

        let (u, v, w) = (ax * cy - ay * cx, bx * ay - by * ax, cx * by - cy * bx);
        let (least, most) = (u.min(v).min(w), u.max(v).max(w));
        !(bound.less(most) & least.less(bound.negated()))
    }
}

/// The corners as the ray sees them.
struct Sheared<'a> {
    axes: [&'a [[f32; LANES]; 3]; 3],
    origin: [Register; 3],
    shear: [Register; 2],
}

impl Sheared<'_> {
    /// One corner of each triangle: where it is, how far it reaches from the ray, and its depth.
    #[inline(always)]
    fn corner(&self, corner: usize) -> [Register; 4] {
        let [p, q, r] = self.axes;
        let z = Register::of(r[corner]) - self.origin[2];
        let x = Register::of(p[corner]) - self.origin[0] - self.shear[0] * z;
        let y = Register::of(q[corner]) - self.origin[1] - self.shear[1] * z;
        [x, y, x.abs() + y.abs(), z.abs()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::trace::intersect::EdgeRay;
    use crate::trace::test::TriangleTest;
    use bytemuck::Zeroable;

    /// What the filter of four rejects, that of one does too, and what `decide` accepts, neither rejects.
    #[test]
    fn four_at_once_reject_no_more_than_one_by_one() {
        let mut random = Random::new(10);
        let special = |among: u64, random: &mut Random| match random.below(among) + 6 * u64::from(among == 1) {
            0 => 0.0,
            1 => 1.0,
            2 => f32::MAX,
            3 => -3.0e38,
            4 => 1e-30,
            // Whose products overflow, or nearly so.
            5 | 7 => 2.5e19 * (2.0 * random.unit() as f32 - 1.0),
            _ => 2.0 * random.unit() as f32 - 1.0,
        };
        let (mut rejected, mut more) = (0, 0);
        for case in 0..40_000 {
            // Half of them of ordinary numbers.
            let among = [1, 12][case / 8 % 2];
            let point = |random: &mut Random| [0; 3].map(|_| special(among, random));
            let count = 1 + case % LANES;
            let triangles: Vec<TriangleRecord> = (0..count)
                .map(|_| {
                    let [v0, v1, v2] = [0; 3].map(|_| point(&mut random));
                    TriangleRecord { v0, v1, v2, ..TriangleRecord::zeroed() }
                })
                .collect();
            let shift = [0.0, 1e-9][case % 2];
            let origin = point(&mut random).map(|v| f64::from(v) * (1.0 + shift));
            let direction = point(&mut random).map(f64::from);
            if direction == [0.0; 3] {
                continue;
            }
            let ray = EdgeRay::new(origin, direction);
            let met = TriangleBlock::new(&triangles).may_cross(&ray.filter());
            for (lane, triangle) in triangles.iter().enumerate() {
                let (one, exact) = match ray.axis() {
                    0 => (ray.surely_misses::<0>(triangle), ray.decide::<0>(triangle)),
                    1 => (ray.surely_misses::<1>(triangle), ray.decide::<1>(triangle)),
                    _ => (ray.surely_misses::<2>(triangle), ray.decide::<2>(triangle)),
                };
                let four = met & 1 << lane == 0;
                assert!(!four || (one && exact.is_none()), "{origin:?} {direction:?} {triangle:?}");
                rejected += u32::from(four && among == 1);
                more += u32::from(one && !four && among == 1);
            }
        }
        assert!(rejected > 10_000 && more < rejected / 100, "{rejected} rejected, {more} by the other alone");
    }
}
