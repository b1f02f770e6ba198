use super::driver::{self, DeviceId, Status};
use super::watch::Call;
use crate::verify::DeviceError;
use opencl3::device::*;
use serde::Serialize;
use std::sync::{Mutex, PoisonError};

/// What a device is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum DeviceKind {
    /// `CL_DEVICE_TYPE_CPU`.
    Cpu,
    /// `CL_DEVICE_TYPE_GPU`.
    Gpu,
    /// `CL_DEVICE_TYPE_ACCELERATOR`.
    Accelerator,
    /// Any other type, custom devices among them.
    Other,
}

/// An OpenCL device and what it can do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct DeviceInfo {
    /// `N` of `opencl:N`: the place in [`list_devices`], which goes platform by platform.
    pub index: usize,
    /// What the driver says that it is.
    pub kind: DeviceKind,
    /// `CL_DEVICE_NAME`.
    pub name: String,
    /// `CL_DEVICE_VENDOR`.
    pub vendor: String,
    /// `CL_PLATFORM_NAME` of its driver.
    pub platform: String,
    /// `CL_DRIVER_VERSION`.
    pub driver_version: String,
    /// Such as `OpenCL 3.0 …`.
    pub opencl_version: String,
    /// Bytes.
    pub global_memory: u64,
    /// Bytes that one buffer may have.
    pub max_allocation: u64,
    /// Whether the device computes in `f64` itself; where not, the kernels emulate it in integers.
    pub fp64: bool,
    /// Whether host and device share their memory, so that a mapped file is traversed in place.
    pub unified_memory: bool,
    /// Why it cannot trace: not available now, without a compiler, or big-endian.
    pub unusable: Option<String>,
}

impl DeviceInfo {
    /// One line for people.
    pub fn summary(&self) -> String {
        format!("{} ({}, driver {})", self.name, self.platform, self.driver_version)
    }
}

/// The devices of all platforms, in the platforms' order.
///
/// # Errors
/// [`DeviceError::NoLibrary`] without an OpenCL library, [`DeviceError::NoDevice`] where none of its drivers has a
/// device.
pub fn list_devices() -> Result<Vec<DeviceInfo>, DeviceError> {
    Ok(found()?.into_iter().map(|(info, _)| info).collect())
}

/// The device that a user most likely means: the first usable GPU, accelerator, or device of another kind, in this order.
pub fn preferred(devices: &[DeviceInfo]) -> Option<&DeviceInfo> {
    let rank = |info: &DeviceInfo| match info.kind {
        DeviceKind::Gpu => 0,
        DeviceKind::Accelerator => 1,
        DeviceKind::Cpu | DeviceKind::Other => 2,
    };
    devices.iter().filter(|info| info.unusable.is_none()).min_by_key(|info| (rank(info), info.index))
}

/// As [`list_devices`], with the driver's names for them.
pub(super) fn found() -> Result<Vec<(DeviceInfo, DeviceId)>, DeviceError> {
    // Loaders set themselves up in the first call, and not all of them lock: two threads at once have crashed ocl-icd
    // 2.3.1.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let _call = Call::begin();
    let platforms = match driver::platforms() {
        Ok(platforms) => platforms,
        Err(status) if status.is_missing_library() => return Err(DeviceError::NoLibrary { library: LIBRARY }),
        Err(status) if status.is_missing_platform() => Vec::new(),
        Err(status) => return Err(failed("OpenCL", status)),
    };

    // A platform that fails takes no other down.
    let mut all = Vec::new();
    for platform in &platforms {
        let name = platform.name().unwrap_or_default();
        for id in platform.devices().unwrap_or_default() {
            if let Ok(info) = info(all.len(), &name, id) {
                all.push((info, id));
            }
        }
    }
    if all.is_empty() { Err(DeviceError::NoDevice { platforms: platforms.len() }) } else { Ok(all) }
}

fn info(index: usize, platform: &str, id: DeviceId) -> Result<DeviceInfo, Status> {
    let kind = id.number(CL_DEVICE_TYPE)?;
    let kind = [
        (CL_DEVICE_TYPE_GPU, DeviceKind::Gpu),
        (CL_DEVICE_TYPE_ACCELERATOR, DeviceKind::Accelerator),
        (CL_DEVICE_TYPE_CPU, DeviceKind::Cpu),
    ]
    .into_iter()
    .find(|(bit, _)| kind & bit != 0)
    .map_or(DeviceKind::Other, |(_, kind)| kind);

    // Drivers of OpenCL 1.1 do not know the question about f64; all list it as an extension.
    let extensions = id.text(CL_DEVICE_EXTENSIONS)?;
    let fp64 = extensions.split_whitespace().any(|e| e == "cl_khr_fp64");
    let is = |what| Ok::<bool, Status>(id.number(what)? != 0);
    let unusable = if !is(CL_DEVICE_AVAILABLE)? {
        Some("the driver says that it is not available now")
    } else if !is(CL_DEVICE_COMPILER_AVAILABLE)? {
        Some("its driver has no compiler")
    } else if !is(CL_DEVICE_ENDIAN_LITTLE)? {
        Some("it is big-endian, and the records of a cache file are little-endian")
    } else {
        None
    };
    Ok(DeviceInfo {
        index,
        kind,
        name: id.text(CL_DEVICE_NAME)?,
        vendor: id.text(CL_DEVICE_VENDOR)?,
        platform: platform.to_string(),
        driver_version: id.text(CL_DRIVER_VERSION)?,
        opencl_version: id.text(CL_DEVICE_VERSION)?,
        global_memory: id.number(CL_DEVICE_GLOBAL_MEM_SIZE)?,
        max_allocation: id.number(CL_DEVICE_MAX_MEM_ALLOC_SIZE)?,
        fp64,
        unified_memory: is(CL_DEVICE_HOST_UNIFIED_MEMORY)?,
        unusable: unusable.map(String::from),
    })
}

/// What opencl3 loads.
const LIBRARY: &str = if cfg!(target_os = "windows") {
    "OpenCL.dll"
} else if cfg!(target_os = "macos") {
    "/System/Library/Frameworks/OpenCL.framework/OpenCL"
} else {
    "libOpenCL.so.1"
};

pub(super) fn failed(device: &str, status: Status) -> DeviceError {
    DeviceError::Runtime { device: device.to_string(), call: status.call, status: status.name() }
}
