use super::record::HitRecord;
use crate::geom::Ray;
use crate::size::beyond;
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
    /// A name that tells devices apart: `cpu`, `opencl:0`.
    fn name(&self) -> &str;
    /// What it is, for people: the processor's own name and driver.
    fn description(&self) -> String;
    /// Why its answers may differ from the CPU's in their last bits; `None` where they must be equal bit for bit.
    fn deviation(&self) -> Option<String>;
    /// Whether, of a triangle that stands in several leaves, it may name another record than the CPU does.
    fn names_any_copy(&self) -> bool {
        false
    }

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
    /// The tree cannot be walked to its end.
    #[error("Cannot trace on {device}.\n{malformed}")]
    Malformed {
        /// The device's name.
        device: String,
        /// What is wrong with the tree.
        malformed: Malformed,
    },
    /// No OpenCL library could be loaded.
    #[error(
        "Cannot use OpenCL: no OpenCL library could be loaded.\n{library} is looked for, and what the variable OPENCL_DYLIB_PATH names."
    )]
    NoLibrary {
        /// The name that is looked for on this system.
        library: &'static str,
    },
    /// There is an OpenCL library, but no device.
    #[error(
        "Cannot use OpenCL: there is no device.\nThe OpenCL library was loaded; {platforms} drivers are registered with it, and none of them has a device."
    )]
    NoDevice {
        /// Drivers that are registered with the library.
        platforms: usize,
    },
    /// The number is beyond those of the devices.
    #[error(
        "Cannot use OpenCL device {index}: there are {count}, numbered from 0.\n{list}",
        count = devices.len(),
        list = numbered(devices)
    )]
    NoSuchDevice {
        /// The number that was asked for.
        index: usize,
        /// What there is, from number 0 on.
        devices: Vec<String>,
    },
    /// The device is there and cannot trace.
    #[error("Cannot use {device}.\n{reason}")]
    Unusable {
        /// The device's name.
        device: String,
        /// Why, as a sentence.
        reason: String,
    },
    /// What tracing needs does not fit into the device.
    #[error(
        "Cannot use {device}: its memory is too small for {what}.\nNeeded are {}, available {}.",
        beyond(*needed, *available)[0], beyond(*needed, *available)[1]
    )]
    OutOfMemory {
        /// The device's name.
        device: String,
        /// What does not fit.
        what: String,
        /// Bytes.
        needed: u64,
        /// Bytes.
        available: u64,
    },
    /// There are more records than the kernels have numbers for.
    #[error("Cannot use {device}: its kernels number {most} {what} records at most.\nThe file has {count}.")]
    TooMany {
        /// The device's name.
        device: String,
        /// Name of the section.
        what: String,
        /// Records of the file.
        count: u64,
        /// Records that can be numbered.
        most: u64,
    },
    /// The driver refuses the kernels.
    #[error("Cannot compile the kernels for {device}: {status}.\n{log}")]
    Build {
        /// The device's name.
        device: String,
        /// Name of the OpenCL error.
        status: String,
        /// What the driver's compiler says.
        log: String,
    },
    /// A call to the driver failed.
    #[error("Cannot trace on {device}: {call} failed with {status}.")]
    Runtime {
        /// The device's name.
        device: String,
        /// The OpenCL function, or what it was called for.
        call: &'static str,
        /// Name of the OpenCL error.
        status: String,
    },
}

fn numbered(devices: &[String]) -> String {
    devices.iter().enumerate().map(|(i, name)| format!("opencl:{i}: {name}")).collect::<Vec<_>>().join("\n")
}
