//! Pictures of a tree: the scene through a camera, coloured by what is seen or by the work that each ray makes.
//!
//! A [`Standpoint`] or a camera of one's own and a film make a [`Lens`]; a [`Shot`] is what its rays hit and cost; [`Shade`] gives it colours, by a
//! [`Scale`] where they stand for numbers; the boxes of a level are drawn over it ([`boxes`]); and [`Difference`] compares two trees of one scene.
//! A [`Canvas`] becomes a PNG.

pub mod boxes;
mod canvas;
mod depths;
mod difference;
mod figures;
mod font;
mod lens;
mod panel;
mod place;
mod scale;
mod shade;
mod shot;
mod subtree;

pub use canvas::{Canvas, Rgb};
pub(in crate::report) use canvas::{letters, text_height, text_width};
pub use difference::{Difference, DifferenceFigures};
pub use figures::{Figures, Spread};
pub use lens::Lens;
pub use panel::{beside, heading, stacked};
pub use place::Standpoint;
pub use scale::{BACKGROUND, Scale};
pub use shade::Shade;
pub use shot::{Pixel, Seen, Shot};
pub use subtree::Subtree;
