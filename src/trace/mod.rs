//! Traversal on the CPU: closest and any hit over one or two levels, and the brute force it is judged by.
//!
//! Three ideas make a hit certain. The *triangle test* decides every edge as geometry has it, up to the rounding of `f64`: a
//! quick `f32` filter rejects only what it can prove to be a miss, the rest is decided in `f64` (`intersect`). The *box test* is
//! widened by the rounding it can suffer, so that it never rejects what the triangle test would accept (`slab`). And a ray keeps its
//! `t` when an instance maps it, since nothing is normalised.
//!
//! ```
//! use bvhc::geom::Ray;
//! use bvhc::trace::{any_hit, closest_hit};
//! # use bvhc::{cache::Image, scene::{Mesh, Part}, tree::{Accel, Node, Tree}};
//! # let mesh = Mesh {
//! #     positions: vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
//! #     triangles: vec![[0, 1, 2]],
//! #     parts: vec![Part { triangle_count: 1, prim_count: 1, ..Part::default() }],
//! #     ..Mesh::default()
//! # };
//! # let nodes = vec![Node::leaf(mesh.triangle_box(0), 0, 1), Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 }];
//! # let blases = vec![Tree { nodes, refs: vec![0] }];
//! # let exec = bvhc::exec::Executor::sequential();
//! # let image = Image::new(&Accel { meshes: vec![mesh], blases, ..Accel::default() }, &exec).unwrap();
//! # let view = image.view();
//! let ray = Ray::new([0.25, 0.25, 0.0], [0.0, 0.0, 0.5]);
//! let hit = closest_hit(&view, &ray)?.expect("the triangle is right ahead");
//! assert_eq!((hit.t, hit.prim), (2.0, 0)); // t counts in lengths of the direction
//! assert!(any_hit(&view, &ray)? && !any_hit(&view, &ray.until(1.5))?);
//! # Ok::<(), bvhc::trace::Malformed>(())
//! ```
//!
//! `brute`, `rays` and `compare` are the judge: every triangle of the source scene tested in `f64` without any tree, sets of
//! rays that look for trouble, and a verdict per ray.

pub mod arithmetic;
pub mod brute;
pub mod compare;
pub(crate) mod exact;
mod lent;
pub mod probe;
pub mod rays;

pub use bvhc_core::trace::{
    BatchError, Counters, FARTHEST, Hit, Malformed, NoObserver, Observer, SceneVisit, Step, TurnedView, Turns, Visit,
    any_hit, closest_hit, try_any_hit, try_closest_hit, wide,
};
pub(crate) use lent::Lent;
