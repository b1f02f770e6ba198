//! The boxes of a wide node against a ray, all at once.
//!
//! Distances are widened as in [`slab`](crate::trace::slab), and what that derives of them holds here too. The two origins of each axis are computed in `f32`,
//! which is quicker and moves them a little farther apart. Write `u = 2⁻²⁴`, and `p` for the most that [`slab`](crate::trace::slab) moves an origin by, but for its own rounding to
//! `f32`. Each is `fl(fl(o) ± s)`, where `s` is `4u·|fl(o)| + 2p`, off by less than `4u` of itself. Rounding `o` and the sum is off by at most
//! `u·|o| + u·(|fl(o)| + s)`, so what is left of `s` is more than `p`.

use super::record::WideRecord;
use crate::geom::Aabb;
use crate::simd::Floats;
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

impl Axis<f32> {
    #[inline(always)]
    fn new(o: f32, direction: f64, arithmetic: f64, behind: f32) -> Axis<f32> {
        let length = direction.abs();
        let pad = o.abs() * (2.0 * f32::EPSILON) + (arithmetic + length * power_of_two(-145)) as f32;
        let is_down = direction < 0.0;
        let signed = u32::from(is_down) << 31;
        let near = o + f32::from_bits(pad.to_bits() ^ signed);
        let far = o - f32::from_bits((pad + length as f32 * behind).to_bits() ^ signed);
        let inverse = (1.0 / direction) as f32;
        let is_normal = inverse.abs() >= f32::MIN_POSITIVE && inverse.abs() < f32::INFINITY;
        let inverse = if is_normal { inverse } else { f32::NAN };
        let inverse = if direction == 0.0 { f32::INFINITY } else { inverse };
        let leave = -inverse * (1.0 + Conservative::EXIT);
        Axis { near: -near, far: -far, enter: inverse, leave, enters_high: is_down }
    }

    /// Whether no ray meets an empty box for this axis' sake.
    #[inline(always)]
    fn counts(&self) -> bool {
        (self.near - self.far).is_finite() && !self.enter.is_nan()
    }

    #[inline(always)]
    fn in_all_lanes<V: Floats<N>, const N: usize>(self, door: V::Door) -> Axis<V> {
        Axis {
            near: V::splat(door, self.near),
            far: V::splat(door, self.far),
            enter: V::splat(door, self.enter),
            leave: V::splat(door, self.leave),
            enters_high: self.enters_high,
        }
    }
}

impl<V> Axis<V> {
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
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let [[a, b, c], [d, e, f]] = [bounds.min, bounds.max];
        let plane = larger(larger(larger(a.abs(), b.abs()), larger(c.abs(), d.abs())), larger(e.abs(), f.abs()));
        let [x, y, z] = [origin[0] as f32, origin[1] as f32, origin[2] as f32];
        let coordinate = larger(larger(x.abs(), y.abs()), z.abs());
        // In `f64`, since a product that is a tiny `f32` takes processors a hundred cycles.
        let arithmetic = f64::from(plane + coordinate) * power_of_two(-47) + power_of_two(-99);
        let behind = larger(-t_min, 0.0) * (32.0 * (f32::EPSILON / 2.0));
        let x = Axis::new(x, direction[0], arithmetic, behind);
        let y = Axis::new(y, direction[1], arithmetic, behind);
        let z = Axis::new(z, direction[2], arithmetic, behind);
        if !(x.counts() || y.counts() || z.counts()) {
            return None;
        }
        let axes = [x.in_all_lanes(door), y.in_all_lanes(door), z.in_all_lanes(door)];
        Some(WideSlabs { axes, t_min: V::splat(door, t_min) })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::WideNode;
    use crate::random::Random;
    use crate::simd::Register;

    fn special(random: &mut Random) -> f32 {
        match random.below(8) {
            0 => 0.0,
            1 => -0.0,
            2 => 1.0,
            3 => 0.25 * random.below(8) as f32 - 1.0,
            4 => 1e30 * (random.unit() as f32 - 0.5),
            5 => 1e-30 * (random.unit() as f32 - 0.5),
            _ => 2.0 * random.unit() as f32 - 1.0,
        }
    }

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
