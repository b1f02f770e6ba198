//! Verification: does traversing a file give the right hits on the device that will do it?
//!
//! A [`Device`] traces rays through a [`View`](crate::cache::View) and answers in 32-byte records; the CPU is one, every OpenCL device
//! another. The oracle of [`trace::brute`](crate::trace::brute) judges a sample of the answers, devices are compared with each other on all
//! of them, and every difference goes to the oracle.

pub mod accuracy;
mod cpu;
mod device;
#[cfg(feature = "opencl")]
pub mod opencl;
mod record;
mod stored;

pub use cpu::Cpu;
pub use device::{Device, DeviceError, Query};
pub use record::{HitRecord, NO_HIT, NO_INSTANCE, RayRecord};
pub use stored::{NotAScene, scene_of_file};
