//! Traversal on the CPU: closest and any hit over one or two levels.
//!
//! Three ideas make a hit certain. The *triangle test* decides every edge as geometry has it, up to the rounding of `f64`: a
//! quick `f32` filter rejects only what it can prove to be a miss, the rest is decided in `f64` (`intersect`). The *box test* is
//! widened by the rounding it can suffer, so that it never rejects what the triangle test would accept (`slab`). And a ray keeps its
//! `t` when an instance maps it, since nothing is normalised.
//!
//! [`arithmetic`] holds the parts that [`closest_hit`] is made of, for those who measure other triangle tests or box tests.

mod batch;
mod between;
mod bounds;
mod cached;
mod hit;
mod intersect;
mod moving;
mod observe;
mod of_frame;
mod place;
mod slab;
mod source;
mod test;
mod traverse;
mod turned;
mod visit;
mod visit_scene;
mod way_back;
pub mod wide;

pub use hit::{BatchError, Hit, Malformed};
#[cfg(feature = "testing")]
pub use observe::Fault;
pub use observe::{Counters, NoObserver, Observer};
pub use traverse::{FARTHEST, any_hit, closest_hit, try_any_hit, try_closest_hit};
pub use turned::{TurnedView, Turns};
pub use visit::{Step, Visit};
pub use visit_scene::SceneVisit;

/// The walk and its parts: traversal by any triangle test and any box test.
pub mod arithmetic {
    pub use super::intersect::EdgeRay;
    pub use super::slab::{Conservative, Plain, Rule, TwoUlps};
    pub use super::test::{Crossing, TriangleTest, dominant, others};
    pub use super::traverse::trace;
}
