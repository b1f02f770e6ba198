use super::driver::{Context as Handle, DeviceId, Kernel, Program, Queue};
use super::list::{DeviceInfo, failed, found};
use crate::verify::DeviceError;
use std::ffi::{CStr, CString};

/// How a device is used; the default asks the device itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Take this for the size that one buffer may have, in bytes, where the device allows more.
    pub max_allocation: Option<u64>,
    /// Copy the file to the device although it could be read in place.
    pub copy: bool,
}

/// A device made ready: opened, its arithmetic probed, the kernels compiled for it. Any number of files can be traced with one.
pub struct Context {
    pub(super) info: DeviceInfo,
    pub(super) options: Options,
    pub(super) id: DeviceId,
    pub(super) deviation: Option<String>,
    /// In this order, so that what belongs to the context goes before it.
    pub(super) queue: Queue,
    pub(super) handle: Handle,
}

impl Context {
    /// Open device `index` of [`list_devices`](super::list_devices).
    ///
    /// # Errors
    /// Where there is no OpenCL or no such device, and where it is unusable.
    pub fn open(index: usize, options: Options) -> Result<Context, DeviceError> {
        let found = found()?;
        let Some((info, id)) = found.get(index).cloned() else {
            let devices = found.iter().map(|(info, _)| info.summary()).collect();
            return Err(DeviceError::NoSuchDevice { index, devices });
        };
        if let Some(reason) = &info.unusable {
            return Err(DeviceError::Unusable { device: info.summary(), reason: reason.clone() });
        }
        if !info.fp64 {
            let reason = "it has no f64 arithmetic (cl_khr_fp64)".to_string();
            return Err(DeviceError::Unusable { device: info.summary(), reason });
        }
        let handle = Handle::new(id).map_err(|status| failed(&info.summary(), status))?;
        let queue = handle.queue(id).map_err(|status| failed(&info.summary(), status))?;
        Ok(Context { info, options, id, deviation: None, queue, handle })
    }

    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// Compile kernels that read sections cut into `parts`.
    pub(super) fn compile(&self, parts: Parts) -> Result<Program, DeviceError> {
        let source = format!("{CONTRACTION}{DOUBLE}\n{TRIANGLE}\n{TRAVERSE}");
        let options = format!(
            "-cl-std=CL1.2 -D PARTS={} -D NODE_SHIFT={} -D TRIS_SHIFT={}",
            parts.count, parts.node_shift, parts.triangle_shift
        );
        // Written here, without a NUL.
        let options = CString::new(options).unwrap_or_default();
        self.handle.compile(self.id, &source, &options).map_err(|(status, log)| match log {
            Some(log) => DeviceError::Build { device: self.info.summary(), status: status.name(), log },
            None => failed(&self.info.summary(), status),
        })
    }

    pub(super) fn kernel(&self, program: &Program, name: &CStr) -> Result<Kernel, DeviceError> {
        program.kernel(name).map_err(|status| failed(&self.info.summary(), status))
    }
}

/// How the two large sections are cut: into one buffer each, or into [`Parts::MANY`] of 2^shift records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Parts {
    pub count: u32,
    pub node_shift: u32,
    pub triangle_shift: u32,
}

impl Parts {
    /// The kernels' parameter lists name as many. OpenCL lets one buffer have at least a quarter of a device's memory, and cutting at a
    /// power of two may halve that.
    pub const MANY: u32 = 8;
}

/// No product and sum may be one operation: the CPU rounds twice.
const CONTRACTION: &str = "#pragma OPENCL FP_CONTRACT OFF\n";
const DOUBLE: &str = include_str!("kernels/double.cl");
const TRIANGLE: &str = include_str!("kernels/triangle.cl");
const TRAVERSE: &str = include_str!("kernels/traverse.cl");
