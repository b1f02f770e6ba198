//! What a cluster's box is fitted around.

use crate::oriented::{Basis, Extremes, Moments, OrientedBox, ditetrahedron, least};
use std::borrow::Cow;

/// Most parts of an outline that has not all triangles. What it loses is the slack of parts that are much smaller than the whole.
pub(super) const PARTS: usize = 32;

/// A cluster in parts: corners of triangles, and boxes of the clusters below that were not opened.
#[derive(Default)]
pub(super) struct Outline {
    corners: Vec<[f64; 3]>,
    boxes: Vec<OrientedBox>,
}

impl Outline {
    pub fn clear(&mut self) {
        self.corners.clear();
        self.boxes.clear();
    }

    pub fn add_triangle(&mut self, corners: [[f64; 3]; 3]) {
        self.corners.extend(corners);
    }

    pub fn add_box(&mut self, bounds: OrientedBox) {
        self.boxes.push(bounds);
    }

    /// Around all parts.
    fn within(&self, basis: Basis) -> Option<OrientedBox> {
        let corners = OrientedBox::in_basis(basis, &self.corners);
        OrientedBox::around(basis, self.boxes.iter().copied().chain(corners))
    }

    /// The least box along the scene's axes, the spread of the surface, the bases that are given, and DiTO-14's.
    pub fn fit(&self, given: [Basis; 2], surface: &Moments) -> Option<OrientedBox> {
        let mut points = Cow::Borrowed(&self.corners[..]);
        if !self.boxes.is_empty() {
            points.to_mut().extend(self.boxes.iter().flat_map(OrientedBox::corners));
        }
        let extremes = Extremes::of_points(&points)?;
        let dito = least(ditetrahedron(&extremes), |basis| OrientedBox::in_basis(basis, &extremes.points()));
        let suggested = [Some(Basis::AXES), surface.basis(), dito.map(|b| b.basis)];
        least(given.into_iter().chain(suggested.into_iter().flatten()), |basis| self.within(basis))
    }
}
