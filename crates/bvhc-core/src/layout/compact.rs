//! A node of a wide tree in 80 bytes.

use crate::geom::Aabb;

/// A node of up to eight children, with their boxes on a grid of the node's own: eight bits a plane.
///
/// On each axis a plane of number `q` stands at `origin + q·scale`, computed in `f32`: the product is exact, since a scale is a power of two, and
/// the sum is rounded once to the nearest. Near planes are rounded down to the grid and far planes up, by what this gives, so a decoded box holds
/// the box that it was made of.
///
/// Children that are nodes are consecutive records from `first_node` on, in the order of their lanes. The references of leaves are consecutive
/// from `first_ref` on, likewise: so neither needs a number of its own.
#[repr(C, align(8))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct CompactNode {
    /// Bits of the near corner of the node's own box, three `f32`.
    pub origin: [u32; 3],
    /// Exponents of the grid's steps, biased as in an `f32`: a step is 2^(exponent − 127), and 0 where the exponent is 0.
    pub exponents: [u8; 3],
    /// Lanes that are used, the first ones.
    pub children: u8,
    /// Record of the first child that is a node, counted from the tree's own start.
    pub first_node: u32,
    /// First reference of the first child that is a leaf, counted from the tree's own start in its own order.
    pub first_ref: u32,
    /// References of each child: 0 for a node.
    pub counts: [u8; 8],
    /// The near planes of the children's boxes on the axes x, y and z, then the far ones.
    pub planes: [[u8; 8]; 6],
}

const _: () = assert!(size_of::<CompactNode>() == 80);

crate::pod::plain! {
    CompactNode = [[u32; 3], [u8; 4], [u32; 2], [u8; 8], [[u8; 8]; 6]];
}

impl CompactNode {
    /// Where the grid begins on an axis.
    #[inline(always)]
    pub fn corner(&self, axis: usize) -> f32 {
        f32::from_bits(self.origin[axis])
    }

    /// The grid's step on an axis.
    #[inline(always)]
    pub fn scale(&self, axis: usize) -> f32 {
        step(self.exponents[axis])
    }

    /// The box of the child in a lane, as traversal sees it.
    pub fn bounds(&self, lane: usize) -> Aabb {
        let plane = |row: usize| decode(self.corner(row % 3), self.scale(row % 3), self.planes[row][lane]);
        Aabb { min: [0, 1, 2].map(plane), max: [3, 4, 5].map(plane) }
    }

    /// Put the boxes of the children, eight at most, onto the least grid that holds them all.
    pub(crate) fn set_boxes(&mut self, boxes: &[Aabb]) {
        (self.children, self.planes) = (boxes.len() as u8, [[0; 8]; 6]);
        for axis in 0..3 {
            let (origin, end) = span(boxes, axis);
            let exponent = least_exponent(origin, end);
            (self.origin[axis], self.exponents[axis]) = (origin.to_bits(), exponent);
            let scale = step(exponent);
            if exponent == 0 {
                continue;
            }
            for (lane, b) in boxes.iter().enumerate() {
                self.planes[axis][lane] = last_not_above(origin, scale, b.min[axis]);
                self.planes[axis + 3][lane] = first_not_below(origin, scale, b.max[axis]);
            }
        }
    }
}

impl CompactNode {
    /// Where the grid or a plane is not the one that [`CompactNode::set_boxes`] chooses for these boxes, which the decoded ones hold: what it must
    /// be and what it is.
    pub(crate) fn looser_than_needed(&self, boxes: &[Aabb]) -> Option<(String, String)> {
        (0..3).find_map(|axis| {
            let name = ["x", "y", "z"][axis];
            let (least, greatest) = span(boxes, axis);
            let (origin, exponent) = (self.corner(axis), self.exponents[axis]);
            if origin != least {
                return Some((format!("the grid must begin at {least} on axis {name}"), format!("begins at {origin}")));
            }
            let needed = || decode(origin, step(exponent - 1), u8::MAX) < greatest;
            if exponent > 0 && !needed() {
                let expected =
                    format!("the step on axis {name} must have the exponent {}", least_exponent(least, greatest));
                return Some((expected, format!("it has {exponent}")));
            }
            // All planes of a grid without a step are one.
            let at = |number: u8| decode(origin, step(exponent), number);
            boxes.iter().enumerate().find_map(|(lane, b)| {
                let (low, high) = (self.planes[axis][lane], self.planes[axis + 3][lane]);
                let (low_fits, high_fits) = match exponent {
                    0 => (low == 0, high == 0),
                    _ => (low == u8::MAX || at(low + 1) > b.min[axis], high == 0 || at(high - 1) < b.max[axis]),
                };
                let told = |side: &str, bound: f32, number: u8| {
                    let expected = format!(
                        "the {side} plane of child {lane} on axis {name} must be the nearest one outside of {bound}"
                    );
                    (expected, format!("it is number {number}, at {}", at(number)))
                };
                match (low_fits, high_fits) {
                    (false, _) => Some(told("near", b.min[axis], low)),
                    (_, false) => Some(told("far", b.max[axis], high)),
                    _ => None,
                }
            })
        })
    }
}

/// From where to where some boxes reach on an axis.
fn span(boxes: &[Aabb], axis: usize) -> (f32, f32) {
    boxes.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(least, greatest), b| {
        (
            if b.min[axis] < least { b.min[axis] } else { least },
            if b.max[axis] > greatest { b.max[axis] } else { greatest },
        )
    })
}

/// The step of an exponent.
#[inline(always)]
fn step(exponent: u8) -> f32 {
    f32::from_bits(u32::from(exponent) << 23)
}

/// Where a plane stands. Grows with its number, since rounding keeps the order of numbers.
#[inline(always)]
fn decode(origin: f32, scale: f32, number: u8) -> f32 {
    origin + f32::from(number) * scale
}

/// The least exponent whose last plane is not below `end`. The largest step has its last planes at infinity, so there is one.
fn least_exponent(origin: f32, end: f32) -> u8 {
    NUMBERS[..255].partition_point(|exponent| decode(origin, step(*exponent), u8::MAX) < end) as u8
}

/// The last plane that is not above `at`; the first is not.
fn last_not_above(origin: f32, scale: f32, at: f32) -> u8 {
    NUMBERS.partition_point(|number| decode(origin, scale, *number) <= at).saturating_sub(1) as u8
}

/// The first plane that is not below `at`; the last is not.
fn first_not_below(origin: f32, scale: f32, at: f32) -> u8 {
    NUMBERS.partition_point(|number| decode(origin, scale, *number) < at) as u8
}

const NUMBERS: [u8; 256] = {
    let mut numbers = [0; 256];
    let mut i = 0;
    while i < 256 {
        numbers[i] = i as u8;
        i += 1;
    }
    numbers
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Numbers of all sizes, many of them special.
    fn special(random: &mut Random) -> f32 {
        match random.below(8) {
            0 => 0.0,
            1 => -0.0,
            2 => f32::MAX,
            3 => f32::MIN,
            4 => f32::from_bits(random.below(1 << 23) as u32),
            5 => 1e30 * (random.unit() as f32 - 0.5),
            6 => 12_345_678.0 + random.below(8) as f32,
            _ => 2.0 * random.unit() as f32 - 1.0,
        }
    }

    #[test]
    fn a_decoded_box_holds_the_box_it_was_made_of_and_no_finer_grid_would() {
        let mut random = Random::new(8);
        for _ in 0..50_000 {
            let count = 1 + random.below(8) as usize;
            let boxes: Vec<Aabb> =
                (0..count).map(|_| Aabb::from_points(&[0; 2].map(|_| [0; 3].map(|_| special(&mut random))))).collect();
            let mut node = CompactNode::default();
            node.set_boxes(&boxes);
            assert_eq!(node.children as usize, count);
            for (lane, b) in boxes.iter().enumerate() {
                let decoded = node.bounds(lane);
                for axis in 0..3 {
                    assert!(
                        decoded.min[axis] <= b.min[axis] && decoded.max[axis] >= b.max[axis],
                        "{node:?} of {boxes:?}"
                    );
                    // The next planes inward would cut it.
                    let (origin, scale) = (node.corner(axis), node.scale(axis));
                    let [low, high] = [node.planes[axis][lane], node.planes[axis + 3][lane]];
                    assert!(low == 255 || decode(origin, scale, low + 1) > b.min[axis] || scale == 0.0, "{node:?}");
                    assert!(high == 0 || decode(origin, scale, high - 1) < b.max[axis], "{node:?}");
                }
            }
            for axis in 0..3 {
                let end = boxes.iter().map(|b| b.max[axis]).fold(f32::NEG_INFINITY, f32::max);
                let finer = node.exponents[axis].checked_sub(1);
                assert!(finer.is_none_or(|e| decode(node.corner(axis), step(e), 255) < end), "{node:?} of {boxes:?}");
            }
        }
    }
}
