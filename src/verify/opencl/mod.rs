//! OpenCL devices: [`list_devices`], a [`Context`] for one of them, and [`OpenCl`], which traces one file on it.
//!
//! The kernels in `kernels/` read the file's own records with no conversion and mirror the library's traversal
//! operation by operation, so a device's answers have the CPU's bits; [`Device::deviation`](super::Device::deviation)
//! says where its arithmetic does not allow that, and `self_test` asks a device before it is believed. `driver` is the one place that calls OpenCL. The library is loaded
//! when it is first asked for, so a program with this room starts on a machine without any driver.

mod brute;
mod context;
mod driver;
mod list;
mod probe;
mod scene;
mod self_test;
mod status;
mod trace;
mod watch;

#[cfg(feature = "testing")]
pub use context::Fault;
pub use context::{Context, Options};
pub use list::{DeviceInfo, DeviceKind, list_devices, preferred};
pub use trace::OpenCl;
pub use watch::waiting;
