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
        let bound = half + half + Register::splat(Filter::UNDERFLOW);

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
