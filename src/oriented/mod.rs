//! Bounds that need not lie along the axes: boxes in a basis of their own, and slabs in directions that are the same for all.
//!
//! A box along the axes stands around a slanted thin thing like fog: rays enter it and find nothing. What bounds closer costs more to
//! ask, so each kind of bounds says by [`BoundingVolume`] what it costs. An [`OrientedBox`] has a [`Basis`], and [`fit`] looks for one
//! that suits what is bounded. A [`Dop14`] needs no search, since its directions are fixed.
//!
//! All of it is in `f64` and without fused multiply-add, so it is the same on every machine. Bounds are outward: what was bounded is
//! inside, whatever was rounded.

mod axes;
mod basis;
mod candidates;
mod choose;
mod dop;
mod extremes;
mod fit;
mod moments;
mod oriented_box;
mod polytope;
#[cfg(test)]
mod tests;
mod turned;
mod volume;

pub use basis::Basis;
pub use candidates::{ditetrahedron, hull_facets};
pub use choose::{Choice, discrete, orient};
pub use dop::Dop14;
pub use extremes::{DIRECTIONS, Extremes};
pub use fit::{fit, least};
pub use moments::Moments;
pub use oriented_box::OrientedBox;
pub use turned::{NODE, Segment, TURN, Turned, Work};
pub use volume::BoundingVolume;
