//! Building: a [`Mesh`](crate::scene::Mesh) becomes a [`Tree`], a [`Scene`] becomes an [`Accel`].
//!
//! Four roles never mix. The *driver* owns the work stack, node emission, the depth guarantee and leaf creation; a *strategy* (binned, spatial)
//! answers one question, where to split this range; *cost* is the only place that knows the SAH; the *executor* is the only
//! place that knows threads. A method name is a recipe in the *registry*, which also feeds `--help` and the build key.

mod options;

pub use options::{Axes, BuildOptions, Clip, Levels, Method, Preset};
