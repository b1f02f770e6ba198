use super::record::HitRecord;
use crate::geom::Ray;
use crate::size::beyond;
use crate::trace::Malformed;
use std::fmt;

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
/// It is an [action](DeviceError::action) that failed and the [facts](DeviceError::facts) that stopped it; its text is both in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DeviceError {
    /// The tree cannot be walked to its end.
    Malformed {
        /// The device's name.
        device: String,
        /// What is wrong with the tree.
        malformed: Malformed,
    },
    /// No OpenCL library could be loaded.
    NoLibrary {
        /// The name that is looked for on this system.
        library: &'static str,
    },
    /// There is an OpenCL library, but no device.
    NoDevice {
        /// Drivers that are registered with the library.
        platforms: usize,
    },
    /// The number is beyond those of the devices.
    NoSuchDevice {
        /// The number that was asked for.
        index: usize,
        /// What there is, from number 0 on.
        devices: Vec<String>,
    },
    /// The device is there and cannot trace.
    Unusable {
        /// The device's name.
        device: String,
        /// Why, as a sentence.
        reason: String,
    },
    /// What tracing needs does not fit into the device.
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
    Build {
        /// The device's name.
        device: String,
        /// Name of the OpenCL error.
        status: String,
        /// What the driver's compiler says.
        log: String,
    },
    /// It answers rays of known scenes otherwise than the CPU, so that no answer of it can be believed.
    SelfTest {
        /// The device's name.
        device: String,
        /// Questions that were asked: whether and where each ray hits.
        asked: usize,
        /// Questions that were answered otherwise.
        wrong: usize,
        /// The first of them, and both answers.
        first: String,
    },
    /// A call to the driver failed.
    Runtime {
        /// The device's name.
        device: String,
        /// The OpenCL function, or what it was called for.
        call: &'static str,
        /// Name of the OpenCL error.
        status: String,
    },
}

impl DeviceError {
    /// What could not be done, beginning with "cannot".
    pub fn action(&self) -> String {
        match self {
            DeviceError::Malformed { device, .. } | DeviceError::Runtime { device, .. } => {
                format!("cannot trace on {device}")
            }
            DeviceError::NoLibrary { .. } | DeviceError::NoDevice { .. } => "cannot use OpenCL".to_owned(),
            DeviceError::NoSuchDevice { index, .. } => format!("cannot use OpenCL device {index}"),
            DeviceError::Unusable { device, .. }
            | DeviceError::OutOfMemory { device, .. }
            | DeviceError::SelfTest { device, .. }
            | DeviceError::TooMany { device, .. } => format!("cannot use {device}"),
            DeviceError::Build { device, .. } => format!("cannot compile the kernels for {device}"),
        }
    }

    /// What stopped it, with the values that decide, each one line.
    pub fn facts(&self) -> Vec<String> {
        match self {
            DeviceError::Malformed { malformed, .. } => vec![malformed.to_string()],
            DeviceError::NoLibrary { library } => vec![
                "no OpenCL library could be loaded".to_owned(),
                format!("{library} is looked for, and what the variable OPENCL_DYLIB_PATH names"),
            ],
            DeviceError::NoDevice { platforms } => vec![
                "there is no device".to_owned(),
                format!(
                    "the OpenCL library was loaded; {platforms} drivers are registered with it, and none of them has a device"
                ),
            ],
            DeviceError::NoSuchDevice { devices, .. } => {
                let count = format!("there are {}, numbered from 0", devices.len());
                let numbered = devices.iter().enumerate().map(|(i, name)| format!("opencl:{i}: {name}"));
                std::iter::once(count).chain(numbered).collect()
            }
            DeviceError::Unusable { reason, .. } => vec![reason.clone()],
            DeviceError::OutOfMemory { what, needed, available, .. } => {
                let [needed, available] = beyond(*needed, *available);
                vec![
                    format!("its memory is too small for {what}"),
                    format!("needed are {needed}, available {available}"),
                ]
            }
            DeviceError::TooMany { what, count, most, .. } => {
                vec![format!("its kernels number {most} {what} records at most"), format!("the file has {count}")]
            }
            DeviceError::Build { status, log, .. } => {
                let lines = log.lines().map(str::trim).filter(|line| !line.is_empty());
                std::iter::once(status.as_str()).chain(lines).map(str::to_owned).collect()
            }
            DeviceError::SelfTest { asked, wrong, first, .. } => vec![
                format!("it fails its self-test: of {asked} answers about known scenes, {wrong} are not the CPU's"),
                format!("the first is the one about the ray {first}"),
            ],
            DeviceError::Runtime { call, status, .. } => vec![format!("{call} failed with {status}")],
        }
    }
}

impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.action(), self.facts().join("; "))
    }
}

impl std::error::Error for DeviceError {}
