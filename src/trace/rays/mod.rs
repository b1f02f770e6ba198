//! Ray sets: fair samples and seekers of trouble, the same bits on every machine for the same seed.
//!
//! `sampler` draws the rays of a [`RaySet`] from a scene, with the aims of `aim` and the cameras of `pinhole`; [`grid`] makes whole scenes. Only
//! additions, products, quotients and square roots are used, which IEEE 754 rounds alike everywhere.

mod aim;
pub mod grid;
mod pinhole;
mod sampler;
mod sets;

pub use pinhole::camera;
pub use sampler::Sampler;
pub(crate) use sampler::{barycentric, cosine_ray};
pub use sets::RaySet;
