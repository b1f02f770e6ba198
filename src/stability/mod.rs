//! Scenes on which builders are known to fail, and how every method does on them.
//!
//! ```text
//! scenes ──▶ judge: a Row for each recipe, in two sizes ──▶ report: a SceneReport ◀── gates: what each scene is held to
//! motion ──▶ a MotionReport · refused ──▶ a Refusal
//! ```
//!
//! On all scenes by all recipes hits are right, and depth, leaves, references, time and memory stay within bounds. What a ray costs differs: where a method
//! does badly, the [reason](report::Grown::poor) is told, and `auto` is held to avoid it.
//!
//! ```
//! use bvhc::exec::Executor;
//! use bvhc::stability::{Effort, Failure, SceneReport};
//!
//! let needles = Failure::named("needles").expect("it is in the list");
//! let effort = Effort { sizes: [40, 160], rays: 60, judged_rays: 60, rounds: 0 };
//! let report = SceneReport::of(needles, &effort, &Executor::sequential(), |_| true)?.expect("nobody stopped it");
//! assert!(report.recipes.iter().all(|row| row.large.wrong == 0 && row.large.depth <= 64));
//! # Ok::<(), bvhc::stability::JudgeError>(())
//! ```

mod clock;
mod effort;
mod gates;
pub mod heap;
mod judge;
pub mod motion;
mod recipes;
pub mod refused;
pub mod report;
pub mod scenes;

pub use effort::Effort;
pub use gates::{AUTO_MARGIN, GROWTH, GROWTH_OF_RAYS, Gate, Kept, POOR, asks_rays, gates, time_growth};
pub use judge::{Judge, JudgeError, Row};
pub use motion::{MOTIONS, MotionReport, SplitReport, splits};
pub use recipes::{AUTO, Kind, Recipe, recipes};
pub use refused::{REFUSED, Refusal};
pub use report::{Grown, SceneReport};
pub use scenes::{FAILURES, Failure};
