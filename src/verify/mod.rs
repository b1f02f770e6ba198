//! Verification: does traversing a file give the right hits on the device that will do it?
//!
//! A [`Device`] traces rays through a [`View`](crate::cache::View) and answers in 32-byte records; the CPU is one, its traversal of compact trees
//! another, and so is every OpenCL device. The oracle of [`trace::brute`](crate::trace::brute) judges a sample of the answers, devices are compared with the CPU on all
//! of them, and every difference goes to the oracle.
//!
//! | file | holds |
//! |---|---|
//! | `plan`, `subject`, `stored` | what is traced, through what, and what the file itself says that it holds |
//! | `run`, `outcome`, `class`, `origin` | the pipeline, what it came to, how answers are classed, and which triangle of the scene a hit names |
//! | `placing` | whether the triangles are where the model has them |
//! | `blame` | the record that makes a ray go wrong |
//! | `replay`, `ray_text` | one ray again, with a log; a ray as text |
//! | `record`, `device`, `cpu`, `opencl` | what devices read, write and are |
//! | `answers` | what traversals of others get wrong |
//! | `accuracy` | what other arithmetics would have got wrong |

pub mod accuracy;
pub mod answers;
mod blame;
mod class;
mod cpu;
mod device;
#[cfg(feature = "opencl")]
pub mod opencl;
mod origin;
mod outcome;
#[cfg(feature = "cli")]
mod placing;
mod plan;
#[cfg(feature = "cli")]
mod ray_text;
mod record;
#[cfg(feature = "cli")]
mod replay;
mod run;
mod sets;
#[cfg(feature = "cli")]
mod source;
mod stored;
mod subject;
pub mod watertight;

pub use blame::Blame;
pub use class::{Class, Counts};
pub use cpu::{Compact, Cpu, Turned};
pub use device::{Device, DeviceError, Query};
pub use outcome::{DeviceOutcome, Expected, Got, Mismatch, OracleOutcome, Outcome};
#[cfg(feature = "cli")]
pub(crate) use placing::{Placed, placed};
pub use plan::{Asked, Plan, Reference};
#[cfg(feature = "cli")]
pub(crate) use ray_text::{read_ray, write_ray};
pub use record::{HitRecord, NO_HIT, NO_INSTANCE};
#[cfg(feature = "cli")]
pub(crate) use replay::{Replay, Step, replay};
pub use run::{VerifyError, run};
pub use sets::SETS;
#[cfg(feature = "cli")]
pub(crate) use sets::{set_name, set_named};
#[cfg(feature = "cli")]
pub(crate) use source::is_of_model;
pub use stored::{NotAScene, scene_of_file};
pub use subject::Subject;
