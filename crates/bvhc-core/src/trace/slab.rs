//! The box test: slabs that never reject a box which the exact ray meets.
//!
//! Write `u = 2⁻²⁴`. Each slab distance `(plane − origin) · inverse` suffers three relative errors of at most `u`, so a computed entry may
//! exceed a computed exit by a factor `(1 + u)³ / (1 − u)³ < 1 + 7u`; the reciprocal that exits are computed with is therefore larger by
//! `10u`, one of which covers its own rounding (Ize, "Robust BVH Ray Traversal", 2013, does the same). That lengthens distances ahead of the origin;
//! for a ray that starts behind its origin the far side is moved away by `32u` of the way it goes back. What is not relative is put
//! into the origin: each axis has two of them, moved apart so that the box looks larger, by
//! - the rounding of a mapped ray's `f64` origin to `f32`,
//! - `2⁻⁴⁸` of the largest coordinate in play: sixteen times what the triangle test's `f64` arithmetic may be off,
//! - `2⁻¹⁴⁶·|direction|` and at least `2⁻¹⁰⁰`: products that underflow.
//!
//! For all but the tiniest coordinates these moves come to one unit in the last place of the origin.

use super::intersect::larger;
use crate::geom::{Aabb, round_down, round_up};
use crate::layout::Node;
use crate::simd::Register;
use std::marker::PhantomData;

/// `9u`, rounded up to what `1 + WIDEN` can hold: how much of itself the exit distance is widened by.
const WIDEN: f32 = 10.0 * (f32::EPSILON / 2.0);

/// How careful a box test is. Only the set-up of a ray knows the rule; what is done for each node is the same for all.
pub trait Rule {
    /// How much of itself the exit distance is widened by.
    const EXIT: f32;
    /// Whether distances to be compared with it are widened too, and the origin moved apart.
    const GUARDED: bool;

    /// The largest distance that may still be meant by a computed `t`.
    #[inline(always)]
    fn widened(t: f32) -> f32 {
        if Self::GUARDED { t + t.abs() * Self::EXIT } else { t }
    }
}

/// What the head of this file derives: never rejects a box that the exact ray meets.
#[derive(Clone, Copy, Debug)]
pub struct Conservative;

/// The exit two units in the last place farther, and nothing else (Ize, "Robust BVH Ray Traversal", 2013, section 3).
#[derive(Clone, Copy, Debug)]
pub struct TwoUlps;

/// Slabs as `f32` computes them.
#[derive(Clone, Copy, Debug)]
pub struct Plain;

impl Rule for Conservative {
    const EXIT: f32 = WIDEN;
    const GUARDED: bool = true;
}

impl Rule for TwoUlps {
    const EXIT: f32 = 2.0 * f32::EPSILON;
    const GUARDED: bool = false;
}

impl Rule for Plain {
    const EXIT: f32 = 0.0;
    const GUARDED: bool = false;
}

/// A ray made ready for box tests, two boxes `a` and `b` at once.
///
/// Everything stands in the lanes `enter a, enter b, leave a, leave b`, one register an axis. What belongs to leaving is negated, so that
/// the latest entry and the earliest exit are both a maximum.
#[derive(Clone, Copy, Debug)]
pub struct Slabs<R> {
    /// The origin that makes the entry distance smallest, and the one that makes the exit distance largest.
    origins: [Register; 3],
    /// `1 / direction`. Infinite where the ray is parallel to the slab: then an origin inside gives −∞ and +∞, one on a face gives
    /// NaN, which the maximum ignores. NaN where the reciprocal is not a normal number: the axis is not used.
    inverses: [Register; 3],
    /// By axis, all ones where a box's maximum is entered first.
    enters_high: Register,
    t_min: f32,
    rule: PhantomData<R>,
}

impl<R: Rule> Slabs<R> {
    /// `bounds` contains everything that will be tested.
    pub fn new(origin: [f64; 3], direction: [f64; 3], bounds: &Aabb, t_min: f32) -> Slabs<R> {
        if !R::GUARDED {
            return Slabs::unguarded(origin, direction, t_min);
        }
        let plane = bounds.min.into_iter().chain(bounds.max).fold(0.0, |m, v| larger(f64::from(v).abs(), m));
        let coordinate = origin.into_iter().fold(0.0, |m, v| larger(v.abs(), m));
        let arithmetic = TWO_TO_MINUS_48 * (plane + coordinate);
        let behind = f64::from(-t_min.min(0.0)) * (32.0 * f64::from(f32::EPSILON / 2.0));
        let (mut near, mut far, mut inverses) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let mut enters_high = [0.0; 4];
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            let pad = larger(larger(arithmetic, d.abs() * TWO_TO_MINUS_146), TWO_TO_MINUS_100);
            let far_pad = larger(pad, pad + d.abs() * behind);

            // A ray that goes downward is one that goes upward in a mirror, with signs exchanged in bits, since no processor guesses
            // them. Adding zero makes all zeros positive.
            let flipped = u32::from(d < 0.0).wrapping_neg();
            let mirrored = f64::from_bits(o.to_bits() ^ u64::from(flipped) << 63);
            let back = |v: f32| f32::from_bits(v.to_bits() ^ flipped << 31) + 0.0;
            near[axis] = back(round_up(mirrored + pad));
            far[axis] = back(round_down(mirrored - far_pad));
            enters_high[axis] = f32::from_bits(flipped);
            let inverse = (1.0 / d) as f32;
            let usable = inverse.abs() >= f32::MIN_POSITIVE && inverse.abs() < f32::INFINITY;
            let inverse = if usable { inverse } else { f32::NAN };
            inverses[axis] = if d == 0.0 { f32::INFINITY } else { inverse };
        }
        Slabs {
            origins: [0, 1, 2].map(|a| Register::of([near[a], near[a], far[a], far[a]])),
            inverses: inverses.map(entering_and_leaving::<R>),
            enters_high: Register::of(enters_high),
            t_min,
            rule: PhantomData,
        }
    }

    /// One origin as `f32` rounds it, and reciprocals with the sign of the direction, zeros included.
    fn unguarded(origin: [f64; 3], direction: [f64; 3], t_min: f32) -> Slabs<R> {
        let inverses = direction.map(|d| 1.0 / d as f32);
        let flipped = inverses.map(|i| f32::from_bits(if i < 0.0 { u32::MAX } else { 0 }));
        Slabs {
            origins: origin.map(|o| Register::splat(o as f32)),
            inverses: inverses.map(entering_and_leaving::<R>),
            enters_high: Register::of([flipped[0], flipped[1], flipped[2], 0.0]),
            t_min,
            rule: PhantomData,
        }
    }

    /// [`Fault::SignOfZero`](super::observe::Fault).
    pub fn entering_by_sign(mut self, direction: [f64; 3]) -> Slabs<R> {
        let [x, y, z] = direction.map(|d| f32::from_bits(if d.is_sign_negative() { u32::MAX } else { 0 }));
        self.enters_high = Register::of([x, y, z, 0.0]);
        self
    }

    /// What [`Slabs::pair`] takes as the part of the ray that counts: from its start to `limit`.
    #[inline(always)]
    pub fn reach(&self, limit: f32) -> Register {
        let limit = -R::widened(limit);
        Register::of([self.t_min, self.t_min, limit, limit])
    }

    /// Entry distances of two boxes, and a bit for each that the ray meets: bit 0 for the first, bit 1 for the second.
    #[inline(always)]
    pub fn pair(&self, nodes: &[Node; 2], reach: Register) -> ([f32; 2], u32) {
        // Exchange the planes of the axes that the ray follows downward. The fourth lanes, integers, are left behind.
        let sorted = |node: &Node| {
            let [min, max]: [Register; 2] = bytemuck::cast::<Node, [[f32; 4]; 2]>(*node).map(Register::of);
            let other = (min ^ max) & self.enters_high;
            (min ^ other, max ^ other)
        };
        let ((enter_a, leave_a), (enter_b, leave_b)) = (sorted(&nodes[0]), sorted(&nodes[1]));
        let [x, y, z, _] = Register::transpose([enter_a, enter_b, leave_a, leave_b]);
        let along = |planes: Register, axis: usize| (planes - self.origins[axis]) * self.inverses[axis];

        // A distance that is NaN does not count: the maximum is then its second operand.
        let latest = along(z, 2).max(along(y, 1).max(along(x, 0).max(reach)));
        let leave = latest.upper().negated();
        let [a, b, ..] = latest.array();
        ([a, b], latest.less_or_equal(leave) & 0b11)
    }

    /// Whether the ray meets a box before `limit`.
    pub fn meets(&self, node: &Node, limit: f32) -> bool {
        self.pair(&[*node, *node], self.reach(limit)).1 != 0
    }
}

#[inline(always)]
fn entering_and_leaving<R: Rule>(inverse: f32) -> Register {
    let leaving = -inverse * (1.0 + R::EXIT);
    Register::of([inverse, inverse, leaving, leaving])
}

pub const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

const TWO_TO_MINUS_48: f64 = power_of_two(-48);
const TWO_TO_MINUS_100: f64 = power_of_two(-100);
const TWO_TO_MINUS_146: f64 = power_of_two(-146);

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::random::Random;

    /// Numbers that planes and rays share often, and very large and small ones.
    pub fn special(random: &mut Random) -> f32 {
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

    /// A box around points, some of them equal, so that many boxes are flat.
    fn some_box(random: &mut Random) -> Node {
        let points = [0; 2].map(|_| [0; 3].map(|_| special(random)));
        Node::leaf(Aabb::from_points(&points), random.bits() as u32, random.bits() as u32)
    }

    /// The test of one box as the head of this file has it, an axis after the other.
    fn plain(slabs: &Slabs<Conservative>, node: &Node, limit: f32) -> (f32, bool) {
        let (mut near, mut far) = (slabs.t_min, Conservative::widened(limit));
        for axis in 0..3 {
            let high = slabs.enters_high.array()[axis].to_bits() != 0;
            let (low, top) = (node.min[axis], node.max[axis]);
            let (enter, leave) = if high { (top, low) } else { (low, top) };
            let ([near_origin, _, far_origin, _], [inverse, _, leaving, _]) =
                (slabs.origins[axis].array(), slabs.inverses[axis].array());
            let (t_enter, t_leave) = ((enter - near_origin) * inverse, (leave - far_origin) * -leaving);
            near = if t_enter > near { t_enter } else { near };
            far = if t_leave < far { t_leave } else { far };
        }
        (near, near <= far)
    }

    #[test]
    fn the_vector_form_gives_the_bits_of_the_plain_one() {
        let mut random = Random::new(1);
        for _ in 0..200_000 {
            let nodes = [some_box(&mut random), some_box(&mut random)];
            let [origin, direction] = [0; 2].map(|_| [0; 3].map(|_| f64::from(special(&mut random))));
            let slabs = Slabs::<Conservative>::new(origin, direction, &nodes[0].bounds(), special(&mut random));
            let limit = [special(&mut random), 1e38, 2.0][random.below(3) as usize];
            let (near, hits) = slabs.pair(&nodes, slabs.reach(limit));
            for i in 0..2 {
                let (near_plain, hit_plain) = plain(&slabs, &nodes[i], limit);
                assert_eq!(hits & 1 << i != 0, hit_plain, "{slabs:?} {nodes:?} {limit}");
                // Which zero a maximum of two zeros is depends on the order of the operands, and matters to no comparison.
                assert!(!hit_plain || near[i] == near_plain, "{slabs:?} {nodes:?} {limit}");
            }
        }
    }

    /// Origins and reciprocals written down as the head of this file has them, case by case.
    #[test]
    fn the_set_up_has_the_bits_of_the_cases() {
        let up = |v: f64| (if f64::from(v as f32) < v { (v as f32).next_up() } else { v as f32 }) + 0.0;
        let down = |v: f64| (if f64::from(v as f32) > v { (v as f32).next_down() } else { v as f32 }) + 0.0;
        let mut random = Random::new(5);
        for _ in 0..100_000 {
            let bounds = some_box(&mut random).bounds();
            let [origin, direction] = [0; 2].map(|_| [0; 3].map(|_| f64::from(special(&mut random)) * 1.000000001));
            let t_min = special(&mut random);
            let slabs = Slabs::<Conservative>::new(origin, direction, &bounds, t_min);
            let planes = bounds.min.iter().chain(&bounds.max).fold(0.0, |m: f32, v| m.max(v.abs()));
            let coordinates = f64::from(planes) + origin.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            for axis in 0..3 {
                let (o, d) = (origin[axis], direction[axis]);
                let pad = (TWO_TO_MINUS_48 * coordinates).max(d.abs() * TWO_TO_MINUS_146).max(TWO_TO_MINUS_100);
                let far_pad = pad + d.abs() * f64::from(-t_min.min(0.0)) * (16.0 * f64::from(f32::EPSILON));
                let (near, far) =
                    if d < 0.0 { (down(o - pad), up(o + far_pad)) } else { (up(o + pad), down(o - far_pad)) };
                let inverse = if d == 0.0 { f32::INFINITY } else { (1.0 / d) as f32 };
                let leaving = -inverse * (1.0 + WIDEN);
                let same =
                    |register: Register, want: [f32; 4]| register.array().map(f32::to_bits) == want.map(f32::to_bits);
                assert!(
                    same(slabs.origins[axis], [near, near, far, far]),
                    "{origin:?} {direction:?} {bounds:?} {t_min}"
                );
                let usable = d == 0.0 || inverse.is_normal();
                let inverses = slabs.inverses[axis].array();
                assert!(!usable || inverses == [inverse, inverse, leaving, leaving], "{direction:?}");
                assert!(usable || inverses.iter().all(|i| i.is_nan()), "{direction:?}");
            }
        }
    }

    #[test]
    fn a_ray_aimed_at_a_point_of_a_box_meets_the_box() {
        let mut random = Random::new(2);
        for _ in 0..200_000 {
            let node = some_box(&mut random);
            let origin = [0; 3].map(|_| special(&mut random));
            let on = |lo: f32, hi: f32, random: &mut Random| {
                [lo, hi, lo + (hi - lo) * random.unit() as f32][random.below(3) as usize]
            };
            let target = [0, 1, 2].map(|a| on(node.min[a], node.max[a], &mut random));

            // The direction in f64 is exact up to 2⁻⁵³ of the coordinates, far less than the origin's pad.
            let direction = [0, 1, 2].map(|a| f64::from(target[a]) - f64::from(origin[a]));
            let bounds = node.bounds().grow(target);
            let slabs = Slabs::<Conservative>::new(origin.map(f64::from), direction, &bounds, 0.0);
            assert!(slabs.meets(&node, 1.0), "{origin:?} to {target:?} in {node:?}");
            assert_eq!(slabs.pair(&[node, node], slabs.reach(1.0)).1, 0b11);
        }
    }

    #[test]
    fn a_ray_that_starts_behind_its_origin_meets_what_lies_there() {
        let mut random = Random::new(4);
        for _ in 0..200_000 {
            let node = some_box(&mut random);
            let origin = [0; 3].map(|_| special(&mut random));
            let target = [0, 1, 2].map(|a| [node.min[a], node.max[a]][random.below(2) as usize]);
            let direction = [0, 1, 2].map(|a| f64::from(origin[a]) - f64::from(target[a]));
            let slabs = Slabs::<Conservative>::new(origin.map(f64::from), direction, &node.bounds(), -1.0);
            assert!(slabs.meets(&node, -1.0), "{origin:?} back to {target:?} in {node:?}");
            assert!(slabs.meets(&node, 1.0));
        }
    }

    #[test]
    fn a_parallel_ray_on_a_face_meets_the_box_and_one_beside_it_does_not() {
        let node = Node::leaf(Aabb { min: [0.0, 0.0, 2.0], max: [1.0, 1.0, 3.0] }, 0, 1);
        for zero in [0.0, -0.0] {
            for (x, meets) in [(0.0, true), (1.0, true), (0.5, true), (-1e-3, false), (1.0 + 1e-6, false)] {
                let slabs = Slabs::<Conservative>::new([x, 0.0, 0.0], [zero, zero, 1.0], &node.bounds(), 0.0);
                assert_eq!(slabs.meets(&node, f32::MAX / 4.0), meets, "x = {x}, zero = {zero}");
            }
        }
    }
}
