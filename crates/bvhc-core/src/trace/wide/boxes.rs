//! The boxes of a wide node against a ray, all at once.
//!
//! Distances are widened as in [`slab`](crate::trace::slab), and what that derives of them holds here too. The two origins of each axis are computed in `f32`,
//! which is quicker and moves them a little farther apart. Write `u = 2⁻²⁴`, and `p` for the most that [`slab`](crate::trace::slab) moves an origin by, but for its own rounding to
//! `f32`. Each is `fl(fl(o) ± s)`, where `s` is `4u·|fl(o)| + 2p`, off by less than `4u` of itself. Rounding `o` and the sum is off by at most
//! `u·|o| + u·(|fl(o)| + s)`, so what is left of `s` is more than `p`.

use super::record::WideRecord;
use crate::geom::Aabb;
use crate::simd::{Floats, Register};
use crate::trace::intersect::larger;
use crate::trace::slab::{Conservative, Rule, power_of_two};

/// A ray made ready for boxes of wide nodes.
pub struct WideSlabs<V, const N: usize> {
    axes: [Axis<V>; 3],
    t_min: V,
}

/// A ray on one axis: a box is entered at `(plane + near)·enter` and left at `−(plane + far)·leave`.
struct Axis<V> {
    near: V,
    far: V,
    enter: V,
    leave: V,
    /// Whether the maximum is entered first.
    enters_high: bool,
}

impl<V> Axis<V> {
    #[inline(always)]
    fn new<const N: usize>(door: V::Door, [near, far, enter, leave]: [f32; 4], enters_high: bool) -> Axis<V>
    where
        V: Floats<N>,
    {
        Axis {
            near: V::splat(door, near),
            far: V::splat(door, far),
            enter: V::splat(door, enter),
            leave: V::splat(door, leave),
            enters_high,
        }
    }

    /// The latest entry and the negated earliest exit of each box, with those on this axis.
    #[inline(always)]
    fn narrowed<const N: usize>(
        &self,
        door: V::Door,
        node: &impl WideRecord<N>,
        number: usize,
        [enter, leave]: [V; 2],
    ) -> [V; 2]
    where
        V: Floats<N>,
    {
        // A distance that is NaN does not count: the maximum is then its second operand.
        let (first, second) = node.planes::<V>(door, number, self.enters_high);
        [
            V::max(V::times(V::plus(first, self.near), self.enter), enter),
            V::max(V::times(V::plus(second, self.far), self.leave), leave),
        ]
    }
}

impl<V: Floats<N>, const N: usize> WideSlabs<V, N> {
    /// `bounds` contains everything that will be tested. `None` where no axis counts, and the ray meets every box, those of lanes without a child too.
    #[inline(always)]
    pub fn new(
        door: V::Door,
        origin: [f64; 3],
        direction: [f64; 3],
        bounds: &Aabb,
        t_min: f32,
    ) -> Option<WideSlabs<V, N>> {
        // The three axes in three lanes of a register; what is in the fourth, nobody looks at.
        let ([ox, oy, oz], [dx, dy, dz]) = (origin, direction);
        let o = Register::of([ox as f32, oy as f32, oz as f32, 0.0]);
        let d = Register::of([dx as f32, dy as f32, dz as f32, 0.0]);
        let inverse = inverse_of(direction);

        let ([a, b, c], [e, f, g]) = (bounds.min, bounds.max);
        let plane = Register::of([a, b, c, 0.0]).abs().max(Register::of([e, f, g, 0.0]).abs());
        // In `f64`, since a product that is a tiny `f32` takes processors a hundred cycles.
        let length = larger(larger(dx.abs(), dy.abs()), dz.abs());
        let arithmetic = f64::from(largest(plane) + largest(o.abs())) * power_of_two(-47);
        let arithmetic = (arithmetic + (length * power_of_two(-145) + power_of_two(-99))) as f32;
        let pad = o.abs() * Register::splat(2.0 * f32::EPSILON) + Register::splat(arithmetic);
        let behind = if t_min < 0.0 { -t_min * (32.0 * (f32::EPSILON / 2.0)) } else { 0.0 };
        let far_pad = pad + d.abs() * Register::splat(behind);
        let zero = Register::splat(0.0);
        let sign = d.if_less(zero, Register::splat(-0.0), zero);
        let (near, far) = ((o + (pad ^ sign)).negated(), (o - (far_pad ^ sign)).negated());

        // Whether both origins are finite and the axis is used.
        let is_finite = (near - far).abs().less(Register::splat(f32::INFINITY));
        if is_finite & inverse.less_or_equal(inverse) & 0b111 == 0 {
            return None;
        }
        let leave = inverse * Register::splat(-(1.0 + Conservative::EXIT));
        let ([nx, ny, nz, _], [fx, fy, fz, _]) = (near.array(), far.array());
        let ([ex, ey, ez, _], [lx, ly, lz, _]) = (inverse.array(), leave.array());
        let splat = [
            Axis::new(door, [nx, fx, ex, lx], dx < 0.0),
            Axis::new(door, [ny, fy, ey, ly], dy < 0.0),
            Axis::new(door, [nz, fz, ez, lz], dz < 0.0),
        ];
        Some(WideSlabs { axes: splat, t_min: V::splat(door, t_min) })
    }

    /// Entry distances of the children, and a bit for each that the ray meets before `-end`.
    #[inline(always)]
    pub fn test(&self, door: V::Door, node: &impl WideRecord<N>, end: V) -> ([f32; N], u32) {
        // Written out: a loop over the axes would keep them in memory.
        let [x, y, z] = &self.axes;
        let range = x.narrowed(door, node, 0, [self.t_min, end]);
        let range = y.narrowed(door, node, 1, range);
        let [enter, leave] = z.narrowed(door, node, 2, range);
        (V::array(enter), V::less_or_equal(enter, V::negated(leave)) & node.used())
    }
}

/// `1 / direction`. Infinite where the ray is parallel to the slab, and NaN where it is not a normal number: the axis is not used.
#[inline(always)]
fn inverse_of([x, y, z]: [f64; 3]) -> Register {
    let inverse = Register::of([(1.0 / x) as f32, (1.0 / y) as f32, (1.0 / z) as f32, 0.0]);
    let (size, none) = (inverse.abs(), Register::splat(f32::NAN));
    let inverse = size.if_less(Register::splat(f32::MIN_POSITIVE), none, inverse);
    let inverse = size.if_less(Register::splat(f32::INFINITY), inverse, none);
    if (x != 0.0) & (y != 0.0) & (z != 0.0) {
        return inverse;
    }
    let [a, b, c, _] = inverse.array();
    let unless_zero = |d: f64, inverse: f32| if d == 0.0 { f32::INFINITY } else { inverse };
    Register::of([unless_zero(x, a), unless_zero(y, b), unless_zero(z, c), 0.0])
}

/// The largest of the first three lanes, which are not negative.
#[inline(always)]
fn largest(v: Register) -> f32 {
    let [x, y, z, _] = v.array();
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    larger(larger(x, y), z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::WideNode;
    use crate::random::Random;
    use crate::trace::slab::tests::special;

    /// Forward or back, from an origin that `f32` holds or does not.
    #[test]
    fn a_ray_aimed_at_a_point_of_a_box_meets_the_box_and_no_empty_one() {
        let mut random = Random::new(3);
        let mut unusable = 0;
        for case in 0..200_000 {
            let point = |random: &mut Random| [0; 3].map(|_| special(random));
            let bounds = Aabb::from_points(&[point(&mut random), point(&mut random)]);
            let on = |lo: f32, hi: f32, random: &mut Random| {
                [lo, hi, lo + (hi - lo) * random.unit() as f32][random.below(3) as usize]
            };
            let target = [0, 1, 2].map(|a| f64::from(on(bounds.min[a], bounds.max[a], &mut random)));
            let shift = [0.0, 3e-9][case % 2];
            let origin = point(&mut random).map(|v| f64::from(v) * (1.0 + shift));
            let way = [1.0, -1.0][case / 2 % 2];
            let direction = [0, 1, 2].map(|a| (target[a] - origin[a]) * way);
            let whole = bounds.grow(target.map(|v| v as f32));
            let Some(slabs) = WideSlabs::<Register, 4>::new((), origin, direction, &whole, way.min(0.0) as f32) else {
                unusable += 1;
                continue;
            };
            let mut node = WideNode::<4>::EMPTY;
            node.set(1, &bounds, 0, 1);
            let end = Register::splat(-Conservative::widened(way as f32));
            assert_eq!(slabs.test((), &node, end).1, 0b10, "{origin:?} {direction:?} {bounds:?}");
        }
        assert!(unusable < 20_000, "{unusable}");
    }
}
