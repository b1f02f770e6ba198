//! The boxes of a wide node against a ray, all at once.

use super::record::WideRecord;
use crate::simd::Floats;
use crate::trace::slab::{Rule, Slab, Slabs};

/// A ray made ready for boxes of wide nodes: the numbers of [`Slabs`], each in all lanes. So what that proves of a box holds here as well.
pub struct WideSlabs<V, const N: usize> {
    axes: [Axis<V>; 3],
    t_min: V,
}

struct Axis<V> {
    near: V,
    far: V,
    enter: V,
    leave: V,
    /// The rows of a node's planes that are entered and left by.
    rows: [usize; 2],
}

impl<V: Floats<N>, const N: usize> WideSlabs<V, N> {
    #[inline(always)]
    pub fn new<R: Rule>(door: V::Door, slabs: &Slabs<R>) -> WideSlabs<V, N> {
        let [x, y, z] = slabs.axes();
        let axis = |slab: Slab, number: usize| Axis {
            near: V::splat(door, slab.near),
            far: V::splat(door, slab.far),
            enter: V::splat(door, slab.enter),
            leave: V::splat(door, slab.leave),
            rows: if slab.enters_high { [number + 3, number] } else { [number, number + 3] },
        };
        WideSlabs { axes: [axis(x, 0), axis(y, 1), axis(z, 2)], t_min: V::splat(door, slabs.t_min()) }
    }

    /// Entry distances of the children, and a bit for each that the ray meets before `-end`. A lane that nobody uses may have any bit: on axes that
    /// do not count its box is not empty.
    #[inline(always)]
    pub fn test(&self, door: V::Door, node: &impl WideRecord<N>, end: V) -> ([f32; N], u32) {
        // A distance that is NaN does not count: the maximum is then its second operand.
        let (mut enter, mut leave) = (self.t_min, end);
        for (number, axis) in self.axes.iter().enumerate() {
            let (first, second) = node.planes::<V>(door, number, axis.rows);
            enter = V::max(V::times(V::minus(first, axis.near), axis.enter), enter);
            leave = V::max(V::times(V::minus(second, axis.far), axis.leave), leave);
        }
        (V::array(enter), V::less_or_equal(enter, V::negated(leave)))
    }
}
