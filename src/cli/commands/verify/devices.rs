//! Which devices are asked for, which there are, and opening them.

use crate::cache::{Cache, View};
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::{Context, advice};
use crate::exec::Executor;
use crate::verify::{Compact, Device, DeviceError, Turned};

#[cfg(feature = "opencl")]
use crate::verify::{
    Cpu,
    opencl::{self, OpenCl},
};

/// A device as `--device` names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    Cpu,
    /// The best one.
    OpenCl,
    Number(usize),
    All,
}

pub fn parse(text: &str) -> Result<Wanted, String> {
    match text {
        "cpu" => Ok(Wanted::Cpu),
        "opencl" => Ok(Wanted::OpenCl),
        "all" => Ok(Wanted::All),
        _ => {
            let number = text.strip_prefix("opencl:").and_then(|n| n.parse().ok());
            let unknown = || format!("`{text}` is no device; write cpu, opencl, opencl:N (see --list-devices) or all");
            number.map(Wanted::Number).ok_or_else(unknown)
        }
    }
}

/// Told where devices would be welcome, and there are none.
const NO_DEVICE: &str = "there is no OpenCL device: verifying on the CPU alone";

/// The OpenCL devices of a run, opened once for all files. The CPU needs no opening.
pub struct Bench {
    #[cfg(feature = "opencl")]
    contexts: Vec<opencl::Context>,
}

pub fn failure(error: &DeviceError) -> Failure {
    let exit = match error {
        DeviceError::OutOfMemory { .. } | DeviceError::TooMany { .. } => Exit::Limit,
        DeviceError::Malformed { .. } => Exit::Negative,
        _ => Exit::Unsupported,
    };
    let failure = Failure::new(exit, error.action()).facts(error.facts());
    match advice::for_device(error) {
        Some(help) => failure.help(help),
        None => failure,
    }
}

#[cfg(feature = "opencl")]
impl Bench {
    /// Open what was asked for. A device that was named must be there; others need not, unless `required`.
    pub fn open(wanted: &[Wanted], required: bool, context: &Context) -> Result<Bench, Failure> {
        // Do not wake any driver for the CPU alone.
        if !required && !wanted.is_empty() && wanted.iter().all(|w| *w == Wanted::Cpu) {
            return Ok(Bench { contexts: Vec::new() });
        }
        let listed = opencl::list_devices();
        let best = listed.as_ref().ok().and_then(|all| opencl::preferred(all));
        if required && best.is_none() {
            return Err(match &listed {
                Err(error) => failure(error),
                Ok(all) => failure(&DeviceError::Unusable {
                    device: all.iter().map(|d| d.summary()).collect::<Vec<_>>().join(", "),
                    reason: all.iter().find_map(|d| d.unusable.clone()).unwrap_or_default(),
                }),
            });
        }
        let numbers = match (wanted, best) {
            ([], Some(best)) => vec![best.index],
            ([], None) => {
                context.terminal.note(NO_DEVICE);
                Vec::new()
            }
            _ => numbers(wanted, &listed)?,
        };
        if numbers.is_empty() && wanted.contains(&Wanted::All) {
            context.terminal.note(NO_DEVICE);
        }
        let contexts = numbers.into_iter().map(|n| opencl::Context::open(n, opencl::Options::default()));
        let contexts = contexts.collect::<Result<Vec<_>, _>>().map_err(|e| failure(&e))?;
        Ok(Bench { contexts })
    }

    fn opened<'a>(&'a self, view: View<'a>) -> Result<Vec<Box<dyn Device + 'a>>, DeviceError> {
        self.contexts.iter().map(|c| Ok(Box::new(OpenCl::new(c, view)?) as Box<dyn Device + 'a>)).collect()
    }
}

impl Bench {
    /// What is compared with the CPU: its traversal of compact trees and of turned subtrees, where a file has them, and every device that is open. Devices
    /// read the tree along the axes of the scene, which every file has.
    pub fn devices<'a>(
        &'a self,
        cache: &'a Cache,
        exec: &'a Executor,
    ) -> Result<Vec<Box<dyn Device + 'a>>, DeviceError> {
        let compact = cache.compact().map(|trees| Box::new(Compact::new(trees, exec)) as Box<dyn Device + 'a>);
        let turned = cache.turned().map(|view| Box::new(Turned::new(view, exec)) as Box<dyn Device + 'a>);
        Ok(compact.into_iter().chain(turned).chain(self.opened(cache.view())?).collect())
    }
}

/// The numbers of the OpenCL devices that are asked for, each once and ascending.
#[cfg(feature = "opencl")]
fn numbers(wanted: &[Wanted], listed: &Result<Vec<opencl::DeviceInfo>, DeviceError>) -> Result<Vec<usize>, Failure> {
    let mut numbers = Vec::new();
    for device in wanted {
        match (device, listed) {
            (Wanted::Cpu, _) => {}
            (Wanted::All, Ok(all)) => numbers.extend(all.iter().filter(|d| d.unusable.is_none()).map(|d| d.index)),
            (Wanted::All, Err(DeviceError::NoLibrary { .. } | DeviceError::NoDevice { .. })) => {}
            (Wanted::OpenCl, Ok(all)) => numbers.extend(opencl::preferred(all).or(all.first()).map(|d| d.index)),
            (Wanted::Number(n), Ok(_)) => numbers.push(*n),
            (_, Err(error)) => return Err(failure(error)),
        }
    }
    numbers.sort_unstable();
    numbers.dedup();
    Ok(numbers)
}

/// `--list-devices`. That there is none is an answer, and no error, to the question which there are.
#[cfg(feature = "opencl")]
pub fn list(context: &Context) -> Result<Exit, Failure> {
    #[derive(serde::Serialize)]
    struct Document<'a> {
        schema: &'static str,
        devices: &'a [opencl::DeviceInfo],
    }
    let devices = match opencl::list_devices() {
        Ok(devices) => devices,
        Err(error @ (DeviceError::NoLibrary { .. } | DeviceError::NoDevice { .. })) => {
            context.terminal.note(&error.action());
            error.facts().iter().for_each(|fact| context.terminal.note(fact));
            Vec::new()
        }
        Err(error) => return Err(failure(&error)),
    };
    if context.terminal.json {
        context.terminal.document(&Document { schema: "bvhc.devices.v1", devices: &devices })?;
        return Ok(Exit::Success);
    }
    for device in &devices {
        context.terminal.print(&described(device))?;
    }
    context.terminal.result(&format!("cpu       {}", Cpu::describe(&context.exec)))?;
    Ok(Exit::Success)
}

#[cfg(feature = "opencl")]
fn described(device: &opencl::DeviceInfo) -> String {
    use crate::cli::names;
    use crate::size::bytes;
    let (memory, buffer) = (bytes(device.global_memory), bytes(device.max_allocation));
    let facts = [
        format!("{}, {}", names::escape(&device.vendor), names::escape(&device.opencl_version)),
        format!("{memory} of memory, {buffer} in one buffer"),
        if device.fp64 { "computes in f64" } else { "emulates f64 in integers" }.to_string(),
        if device.unified_memory { "reads files in place" } else { "gets a copy of files" }.to_string(),
    ];
    let mut text = format!("opencl:{}  {}\n", device.index, names::escape(&device.summary()));
    for fact in facts {
        text.push_str(&format!("          {fact}\n"));
    }
    if let Some(reason) = &device.unusable {
        text.push_str(&format!("          not usable: {reason}\n"));
    }
    text
}

#[cfg(not(feature = "opencl"))]
impl Bench {
    pub fn open(wanted: &[Wanted], required: bool, context: &Context) -> Result<Bench, Failure> {
        let named = wanted.iter().any(|w| matches!(w, Wanted::OpenCl | Wanted::Number(_)));
        if required || named {
            return Err(left_out());
        }
        if wanted.contains(&Wanted::All) {
            context.terminal.note(NO_DEVICE);
        }
        Ok(Bench {})
    }

    fn opened<'a>(&'a self, _: View<'a>) -> Result<Vec<Box<dyn Device + 'a>>, DeviceError> {
        Ok(Vec::new())
    }
}

#[cfg(not(feature = "opencl"))]
pub fn list(_: &Context) -> Result<Exit, Failure> {
    Err(left_out())
}

#[cfg(not(feature = "opencl"))]
fn left_out() -> Failure {
    Failure::new(Exit::Unsupported, "cannot use OpenCL")
        .fact("this program was built without it")
        .help("build it with the feature `opencl`, which is on by default")
}
