use super::driver::{Context as Handle, DeviceId, Kernel, Program, Queue, Status};
use super::list::{DeviceInfo, failed, found};
use super::probe::{Deviation, concerns_f64, probe, sentence};
use crate::verify::DeviceError;
use std::ffi::{CStr, CString};
use std::sync::{Arc, Mutex};

/// How a device is used; the default asks the device itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Emulate `f64` in integers although the device has it.
    pub soft_f64: bool,
    /// Take this for the size that one buffer may have, in bytes, where the device allows more.
    pub max_allocation: Option<u64>,
    /// Copy the file to the device although it could be read in place.
    pub copy: bool,
    /// Compile the kernels with a mistake in them: for tests that verification finds it.
    #[cfg(feature = "testing")]
    pub fault: Option<Fault>,
    /// Leave out the self-test: for tests that verification finds what it would find.
    #[cfg(feature = "testing")]
    pub believed: bool,
}

/// A mistake to plant.
#[cfg(feature = "testing")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Where the ray meets both children, the far one is forgotten.
    DroppedChild,
    /// The planes that a ray enters and leaves a box by are exchanged.
    WrongOctant,
}

/// A device made ready: opened, its arithmetic probed, the kernels compiled for it. Any number of files can be traced
/// with one.
pub struct Context {
    pub(super) info: DeviceInfo,
    pub(super) options: Options,
    pub(super) id: DeviceId,
    pub(super) soft_f64: bool,
    pub(super) deviation: Option<String>,
    /// Triangle tests in a second, as the self-test found; without limit where there was none.
    pub(super) brute_rate: f64,
    /// What was compiled so far; most files need the same.
    programs: Mutex<Vec<(Parts, Arc<Program>)>>,
    /// Last, in this order, so that what belongs to the context goes before it.
    pub(super) queue: Queue,
    pub(super) handle: Handle,
}

impl Context {
    /// Device `index` of [`list_devices`](super::list_devices), not yet asked whether it can be believed.
    pub(super) fn new(index: usize, options: Options) -> Result<Context, DeviceError> {
        let found = found()?;
        let Some((info, id)) = found.get(index).cloned() else {
            let devices = found.iter().map(|(info, _)| info.summary()).collect();
            return Err(DeviceError::NoSuchDevice { index, devices });
        };
        if let Some(reason) = &info.unusable {
            return Err(DeviceError::Unusable { device: info.summary(), reason: reason.clone() });
        }
        let fails = |status| failed(&info.summary(), status);
        let handle = Handle::new(id).map_err(fails)?;
        let queue = handle.queue(id).map_err(fails)?;
        let soft_f64 = options.soft_f64 || !info.fp64;
        let mut context = Context {
            info,
            options,
            id,
            soft_f64,
            deviation: None,
            brute_rate: f64::INFINITY,
            programs: Mutex::default(),
            queue,
            handle,
        };

        // Probe the arithmetic. Where only the device's f64 is not what it should be, do without it.
        let mut deviations = context.probe()?;
        if !context.soft_f64 && concerns_f64(&deviations) {
            context.soft_f64 = true;
            deviations = context.probe()?;
        }
        context.deviation = sentence(&deviations);
        Ok(context)
    }

    fn probe(&self) -> Result<Vec<Deviation>, DeviceError> {
        let program = self.compile_text(PROBE, "")?;
        probe(&self.handle, &self.queue, self.id, &program).map_err(|status| failed(&self.info.summary(), status))
    }

    /// The device that was opened.
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// The kernels for sections cut into `parts`, compiled when first asked for.
    pub(super) fn program(&self, parts: Parts) -> Result<Arc<Program>, DeviceError> {
        // A panic while the lock was held would have been between two whole states of the list.
        let mut programs = self.programs.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some((_, program)) = programs.iter().find(|(of, _)| *of == parts) {
            return Ok(Arc::clone(program));
        }
        let program = Arc::new(self.compile(parts)?);
        programs.push((parts, Arc::clone(&program)));
        Ok(program)
    }

    fn compile(&self, parts: Parts) -> Result<Program, DeviceError> {
        #[cfg(feature = "testing")]
        let fault = match self.options.fault {
            None => "",
            Some(Fault::DroppedChild) => " -D DROPPED_CHILD",
            Some(Fault::WrongOctant) => " -D WRONG_OCTANT",
        };
        #[cfg(not(feature = "testing"))]
        let fault = "";
        let Parts { count, node_shift, triangle_shift } = parts;
        let options = format!(" -D PARTS={count} -D NODE_SHIFT={node_shift} -D TRIS_SHIFT={triangle_shift}{fault}");
        self.compile_text(&[TRIANGLE, TRAVERSE, BRUTE].join("\n"), &options)
    }

    fn compile_text(&self, kernels: &str, options: &str) -> Result<Program, DeviceError> {
        let real = if self.soft_f64 { SOFT_DOUBLE } else { DOUBLE };
        let source = format!("{CONTRACTION}{real}\n{kernels}");
        // Written in this file, without a NUL.
        let options = CString::new(format!("-cl-std=CL1.2{options}")).unwrap_or_default();
        self.handle.compile(self.id, &source, &options).map_err(|(status, log)| match log {
            Some(log) => DeviceError::Build { device: self.info.summary(), status: status.name(), log },
            None => failed(&self.info.summary(), status),
        })
    }

    /// A call that failed while memory for `what` was asked.
    pub(super) fn no_room(&self, status: Status, what: &str, needed: u64) -> DeviceError {
        let device = self.info.summary();
        if status.is_out_of_memory() {
            let available = self.info.global_memory;
            return DeviceError::OutOfMemory { device, what: what.to_string(), needed, available };
        }
        failed(&device, status)
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
    /// The kernels' parameter lists name as many. OpenCL lets one buffer have at least a quarter of a device's memory,
    /// and cutting at a power of two may halve that.
    pub const MANY: u32 = 8;
}

/// No product and sum may be one operation: the CPU rounds twice.
const CONTRACTION: &str = "#pragma OPENCL FP_CONTRACT OFF\n";
const DOUBLE: &str = include_str!("kernels/double.cl");
const SOFT_DOUBLE: &str = include_str!("kernels/soft_double.cl");
const PROBE: &str = include_str!("kernels/probe.cl");
const TRIANGLE: &str = include_str!("kernels/triangle.cl");
const TRAVERSE: &str = include_str!("kernels/traverse.cl");
const BRUTE: &str = include_str!("kernels/brute.cl");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refused_kernel_shows_the_compilers_log() {
        let Ok(context) = Context::open(0, Options::default()) else { return println!("skipped: no device") };
        match context.compile_text("__kernel void k(__global int *a) { a[0] = no_such_name; }", "") {
            Err(error @ DeviceError::Build { .. }) => {
                let text = error.to_string();
                assert!(text.contains("no_such_name") && text.contains("CL_BUILD_PROGRAM_FAILURE"), "{text}");
            }
            Err(error) => panic!("{error}"),
            Ok(_) => panic!("it compiled"),
        }
    }
}
