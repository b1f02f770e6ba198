//! The basis that suits points best, among those that are suggested.

use super::basis::Basis;
use super::candidates::ditetrahedron;
use super::extremes::Extremes;
use super::moments::Moments;
use super::oriented_box::OrientedBox;
use super::volume::BoundingVolume;

/// The least box around points among those in the scene's axes, in DiTO-14's basis, and along the spread of the surface if that is
/// given; nothing around no points.
///
/// DiTO-14's bases are compared over fourteen extreme points, and only the best of them is asked about all points, as its authors do.
pub fn fit(points: &[[f64; 3]], surface: Option<&Moments>) -> Option<OrientedBox> {
    let extremes = Extremes::of_points(points)?;
    let dito = least(ditetrahedron(&extremes), |basis| OrientedBox::in_basis(basis, &extremes.points()));
    let others = [Some(Basis::AXES), dito.map(|b| b.basis), surface.and_then(Moments::basis)];
    least(others.into_iter().flatten(), |basis| OrientedBox::in_basis(basis, points))
}

/// The box of least area that the bases lead to; the first of equal ones.
pub fn least(
    bases: impl IntoIterator<Item = Basis>,
    mut of: impl FnMut(Basis) -> Option<OrientedBox>,
) -> Option<OrientedBox> {
    let mut best: Option<OrientedBox> = None;
    for found in bases.into_iter().filter_map(&mut of) {
        if best.is_none_or(|best| found.half_area() < best.half_area()) {
            best = Some(found);
        }
    }
    best
}

impl BoundingVolume for OrientedBox {
    /// A box along the axes, after the ray was turned: six coordinates of three products and two sums, and three divisions.
    const OPERATIONS: u32 = 57;

    /// The basis is [fitted](fit).
    fn of_points(points: &[[f64; 3]]) -> Option<OrientedBox> {
        fit(points, None)
    }

    /// Along one of the two, whichever is less.
    fn merged(&self, other: &OrientedBox) -> OrientedBox {
        self.merged_along_one(other)
    }

    fn area(&self) -> f64 {
        2.0 * self.half_area()
    }
}
