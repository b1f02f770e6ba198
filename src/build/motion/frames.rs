use crate::geom::{Aabb, Point};
use crate::scene::GeometryError;
use crate::simd::{LaneBox, Lanes};
use std::fmt;

/// The triangles of a mesh, and where its vertices stand in several frames.
///
/// ```
/// use bvhc::build::motion::Motion;
///
/// let triangles = [[0, 1, 2]];
/// let frames = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 1.0, 5.0]]];
/// let mut motion = Motion::new(&triangles);
/// for positions in &frames {
///     motion.push(positions)?;
/// }
/// assert_eq!(motion.frames(), 2);
/// assert!(motion.push(&frames[0][..2]).is_err(), "a corner has no position");
/// # Ok::<(), bvhc::build::motion::MotionError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Motion<'a> {
    triangles: &'a [[u32; 3]],
    frames: Vec<&'a [Point]>,
}

/// A frame that cannot be taken, with what is wrong in it.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionError {
    /// The frame, counted from 0.
    pub frame: usize,
    /// What is wrong; its `mesh` is 0.
    pub fault: GeometryError,
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot take frame {}: {}", self.frame, self.fault)
    }
}

impl std::error::Error for MotionError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.fault)
    }
}

impl<'a> Motion<'a> {
    /// Without frames so far. `triangles` are indices into the positions of each frame.
    pub fn new(triangles: &'a [[u32; 3]]) -> Motion<'a> {
        Motion { triangles, frames: Vec::new() }
    }

    /// Add a frame.
    ///
    /// # Errors
    /// Where a triangle has a corner without a position, or one that is not finite.
    pub fn push(&mut self, positions: &'a [Point]) -> Result<(), MotionError> {
        let fault = |(triangle, corners): (usize, &[u32; 3])| {
            corners.iter().find_map(|&index| match positions.get(index as usize) {
                None => Some(GeometryError::IndexOutOfRange { mesh: 0, triangle, index, positions: positions.len() }),
                Some(&p) if p.iter().any(|c| !c.is_finite()) => {
                    Some(GeometryError::NotFinite { mesh: 0, triangle, index, position: p })
                }
                Some(_) => None,
            })
        };
        if let Some(fault) = self.triangles.iter().enumerate().find_map(fault) {
            return Err(MotionError { frame: self.frames.len(), fault });
        }
        self.frames.push(positions);
        Ok(())
    }

    /// Some of the frames, in this order.
    pub(super) fn of(&self, frames: impl Iterator<Item = usize>) -> Motion<'a> {
        Motion { triangles: self.triangles, frames: frames.map(|frame| self.frames[frame]).collect() }
    }

    /// How many frames there are.
    pub fn frames(&self) -> usize {
        self.frames.len()
    }

    /// The triangles, as given.
    pub fn triangles(&self) -> &'a [[u32; 3]] {
        self.triangles
    }

    /// The positions of a frame, as given.
    ///
    /// # Panics
    /// Where there is no such frame.
    pub fn positions(&self, frame: usize) -> &'a [Point] {
        self.frames[frame]
    }

    /// The corners of a triangle in a frame.
    ///
    /// # Panics
    /// Where there is no such frame or triangle.
    #[inline]
    pub fn corners(&self, frame: usize, triangle: usize) -> [Point; 3] {
        self.triangles[triangle].map(|v| self.frames[frame][v as usize])
    }

    /// The box around all triangles in a frame.
    pub(super) fn bounds(&self, frame: usize) -> Aabb {
        let positions = self.frames[frame];
        let corners = self.triangles.as_flattened().iter().map(|v| Lanes::of_point(positions[*v as usize]));
        corners.fold(LaneBox::EMPTY, LaneBox::grow).aabb()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_that_do_not_fit_are_refused_with_their_number() {
        let good = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN; 3]];
        let mut motion = Motion::new(&[[0, 1, 2]]);
        motion.push(&good).expect("no triangle uses what is no number");
        let bad = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]];
        let error = motion.push(&bad).unwrap_err();
        assert_eq!(error.frame, 1);
        assert!(matches!(error.fault, GeometryError::NotFinite { triangle: 0, index: 2, .. }), "{error}");
        let error = motion.push(&good[..1]).unwrap_err();
        assert!(matches!(error.fault, GeometryError::IndexOutOfRange { index: 1, positions: 1, .. }), "{error}");
        assert_eq!(motion.frames(), 1);
    }
}
