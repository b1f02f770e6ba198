use super::record::HitRecord;
use crate::geom::Ray;
use crate::trace::Malformed;

/// What is asked about each ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The nearest hit.
    Closest,
    /// Whether there is any.
    Any,
}

/// Something that traces rays through one view, which it was made for.
pub trait Device {
    /// As `--device` names it: `cpu`, `opencl:0`.
    fn name(&self) -> &str;
    /// What it is, for people: the processor's own name and driver.
    fn description(&self) -> String;
    /// Why its answers may differ from the CPU's in their last bits; `None` where they must be equal bit for bit.
    fn deviation(&self) -> Option<String>;
    /// One record per ray, in order.
    fn trace(&mut self, rays: &[Ray], query: Query) -> Result<Vec<HitRecord>, DeviceError>;

    /// The closest hits without the tree, by the same triangle test; `None` on a device that has no such thing. Of a triangle that stands in
    /// several slots any may be named.
    fn brute_force(&mut self, _rays: &[Ray]) -> Result<Option<Vec<HitRecord>>, DeviceError> {
        Ok(None)
    }

    /// Triangle tests that a verification may spend on [`Device::brute_force`].
    fn brute_work(&self) -> u64 {
        0
    }
}

/// Why a device gave no answer.
///
/// The text of each is the failed action and facts, one a line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    #[error("Cannot trace on {device}.\n{malformed}")]
    Malformed { device: String, malformed: Malformed },
    #[error(
        "Cannot use OpenCL: no OpenCL library could be loaded.\n{library} is looked for, and what the variable OPENCL_DYLIB_PATH names."
    )]
    NoLibrary { library: &'static str },
    #[error(
        "Cannot use OpenCL: there is no device.\nThe OpenCL library was loaded; {platforms} drivers are registered with it, and none of them has a device."
    )]
    NoDevice { platforms: usize },
    #[error(
        "Cannot use OpenCL device {index}: there are {count}, numbered from 0.\n{list}",
        count = devices.len(),
        list = numbered(devices)
    )]
    NoSuchDevice { index: usize, devices: Vec<String> },
    #[error("Cannot use {device}.\n{reason}")]
    Unusable { device: String, reason: String },
    #[error(
        "Cannot use {device}: its memory is too small for {what}.\nNeeded are {needed} bytes, available {available}."
    )]
    OutOfMemory { device: String, what: String, needed: u64, available: u64 },
    #[error("Cannot compile the kernels for {device}: {status}.\n{log}")]
    Build { device: String, status: String, log: String },
    #[error("Cannot trace on {device}: {call} failed with {status}.")]
    Runtime { device: String, call: &'static str, status: String },
}

fn numbered(devices: &[String]) -> String {
    devices.iter().enumerate().map(|(i, name)| format!("opencl:{i}: {name}")).collect::<Vec<_>>().join("\n")
}
