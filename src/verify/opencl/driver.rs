//! The OpenCL calls that this room makes, as safe functions: the only file of it that is `unsafe`.
//!
//! Handles are owned (`Drop` gives them back and, unlike those of opencl3, does not panic where a driver refuses that).
//! Every transfer blocks and every launch is waited for, so no command outlives the borrow of the memory it works on.

use super::watch::Call;
use bytemuck::Pod;
use opencl3::command_queue as queues;
use opencl3::context::context as contexts;
use opencl3::error_codes::{DLOPEN_FUNCTION_NOT_AVAILABLE, DLOPEN_RUNTIME_LOAD_FAILED, error_text};
use opencl3::types::*;
use opencl3::{device as devices, event as events, kernel as kernels, memory, platform, program as programs};
use std::ffi::{CStr, c_void};
use std::marker::PhantomData;
use std::ptr;

/// Why a call failed: OpenCL's own status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Status {
    pub call: &'static str,
    pub code: i32,
}

impl Status {
    /// No library, or one that lacks the function.
    pub fn is_missing_library(self) -> bool {
        [DLOPEN_RUNTIME_LOAD_FAILED, DLOPEN_FUNCTION_NOT_AVAILABLE].contains(&self.code)
    }

    /// The library is there, but no driver is registered.
    pub fn is_missing_platform(self) -> bool {
        self.code == opencl3::error_codes::CL_PLATFORM_NOT_FOUND_KHR
    }

    /// The device or the host has no room for what was asked.
    pub fn is_out_of_memory(self) -> bool {
        use opencl3::error_codes::*;
        [CL_MEM_OBJECT_ALLOCATION_FAILURE, CL_OUT_OF_HOST_MEMORY, CL_OUT_OF_RESOURCES, CL_INVALID_BUFFER_SIZE]
            .contains(&self.code)
    }

    /// The name of the code in `cl.h`.
    pub fn name(self) -> String {
        match error_text(self.code) {
            text if text.starts_with("CL_") => text.to_string(),
            _ => format!("OpenCL error {}", self.code),
        }
    }
}

pub(super) type Result<T> = std::result::Result<T, Status>;

/// Names the call in an error.
fn named<T>(call: &'static str, result: std::result::Result<T, cl_int>) -> Result<T> {
    result.map_err(|code| Status { call, code })
}

/// Handles are pointers that only the driver follows, which may be asked from any thread.
macro_rules! handle {
    ($(#[$doc:meta])* $name:ident, $raw:ty, $release:path) => {
        $(#[$doc])*
        #[derive(Debug)]
        pub(super) struct $name($raw);

        // SAFETY: OpenCL 1.2 is thread-safe for all objects but kernels whose arguments are being set (specification,
        // A.2), and those are borrowed mutably for it.
        #[allow(unsafe_code)]
        unsafe impl Send for $name {}
        #[allow(unsafe_code)]
        unsafe impl Sync for $name {}

        impl Drop for $name {
            #[allow(unsafe_code)]
            fn drop(&mut self) {
                // SAFETY: the handle came from its create call and is given back once. A refusal leaves nothing to do.
                let _ = unsafe { $release(self.0) };
            }
        }
    };
}

/// A platform, that is, a driver.
#[derive(Clone, Copy, Debug)]
pub(super) struct Platform(cl_platform_id);

/// A device of a platform. Never given back: root devices live as long as the process.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeviceId(cl_device_id);

// SAFETY: as for the handles above; both are plain names.
#[allow(unsafe_code)]
unsafe impl Send for DeviceId {}
#[allow(unsafe_code)]
unsafe impl Sync for DeviceId {}

pub(super) fn platforms() -> Result<Vec<Platform>> {
    let found = named("clGetPlatformIDs", platform::platform::get_platform_ids())?;
    Ok(found.into_iter().map(Platform).collect())
}

impl Platform {
    pub fn name(self) -> Result<String> {
        let bytes = platform::platform::get_platform_data(self.0, platform::platform::CL_PLATFORM_NAME);
        Ok(text(&named("clGetPlatformInfo", bytes)?))
    }

    /// All devices of any type; empty where the driver finds none.
    pub fn devices(self) -> Result<Vec<DeviceId>> {
        let found = named("clGetDeviceIDs", devices::get_device_ids(self.0, devices::CL_DEVICE_TYPE_ALL))?;
        Ok(found.into_iter().map(DeviceId).collect())
    }
}

impl DeviceId {
    pub fn text(self, what: cl_device_info) -> Result<String> {
        Ok(text(&named("clGetDeviceInfo", devices::get_device_data(self.0, what))?))
    }

    /// A `cl_uint`, `cl_bool`, `cl_ulong` or `size_t`.
    pub fn number(self, what: cl_device_info) -> Result<u64> {
        let bytes = named("clGetDeviceInfo", devices::get_device_data(self.0, what))?;
        let mut padded = [0; 8];
        for (to, from) in padded.iter_mut().zip(&bytes) {
            *to = *from;
        }
        Ok(u64::from_ne_bytes(padded)) // A shorter number fills the low bytes on a little-endian host alone.
    }
}

fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim().to_string()
}

handle!(
    /// What programs and buffers belong to.
    Context, cl_context, contexts::release_context
);
handle!(
    /// Commands for one device, done in order.
    Queue, cl_command_queue, queues::release_command_queue
);
handle!(
    /// Compiled sources.
    Program, cl_program, programs::release_program
);
handle!(
    /// An entry point of a program.
    Kernel, cl_kernel, kernels::release_kernel
);
handle!(Memory, cl_mem, memory::release_mem_object);

impl Context {
    pub fn new(device: DeviceId) -> Result<Context> {
        let raw = contexts::create_context(&[device.0], ptr::null(), None, ptr::null_mut());
        Ok(Context(named("clCreateContext", raw)?))
    }

    pub fn queue(&self, device: DeviceId) -> Result<Queue> {
        // OpenCL 2.0's successor of this call is not there on the 1.2 drivers that this room is for.
        #[allow(deprecated, unsafe_code)]
        // SAFETY: context and device are alive and belong together; no properties, so commands run in order.
        let raw = unsafe { queues::create_command_queue(self.0, device.0, 0) };
        Ok(Queue(named("clCreateCommandQueue", raw)?))
    }

    /// Compile one source text. The error carries the compiler's log where it refused the text.
    pub fn compile(
        &self,
        device: DeviceId,
        source: &str,
        options: &CStr,
    ) -> std::result::Result<Program, (Status, Option<String>)> {
        let _call = Call::begin();
        // One string: opencl3 takes a slice of them, but hands the driver an array of Rust slices for it, of which only
        // the first is right.
        let raw = programs::create_program_with_source(self.0, &[source]);
        let program = Program(named("clCreateProgramWithSource", raw).map_err(|status| (status, None))?);
        let built = programs::build_program(program.0, &[device.0], options, None, ptr::null_mut());
        named("clBuildProgram", built).map_err(|status| {
            let log = programs::get_program_build_data(program.0, device.0, programs::CL_PROGRAM_BUILD_LOG);
            (status, Some(log.map(|bytes| text(&bytes)).unwrap_or_default()))
        })?;
        Ok(program)
    }
}

impl Program {
    pub fn kernel(&self, name: &CStr) -> Result<Kernel> {
        Ok(Kernel(named("clCreateKernel", kernels::create_kernel(self.0, name))?))
    }
}

/// Memory that kernels work on: the device's own, or for `'a` the host's.
pub(super) struct Buffer<'a> {
    memory: Memory,
    bytes: usize,
    host: PhantomData<&'a [u8]>,
}

impl<'a> Buffer<'a> {
    /// Memory of the device's, not yet written.
    pub fn new(context: &Context, bytes: usize) -> Result<Buffer<'static>> {
        // SAFETY: no host pointer is passed. OpenCL refuses a size of 0 by itself.
        #[allow(unsafe_code)]
        let raw = unsafe { memory::create_buffer(context.0, memory::CL_MEM_READ_WRITE, bytes, ptr::null_mut()) };
        Ok(Buffer { memory: Memory(named("clCreateBuffer", raw)?), bytes, host: PhantomData })
    }

    /// The host's own memory, read in place by a device that shares it; other devices copy it when a kernel first needs
    /// it.
    pub fn share<T: Pod>(context: &Context, data: &'a [T]) -> Result<Buffer<'a>> {
        let bytes = size_of_val(data);
        let flags = memory::CL_MEM_READ_ONLY | memory::CL_MEM_USE_HOST_PTR | memory::CL_MEM_HOST_NO_ACCESS;
        // SAFETY: the driver reads `data` until the buffer is released, which `'a` outlives, and never writes it:
        // kernels see it read-only, and no map or transfer that could write it back is allowed on it. That holds for
        // read-only pages of a mapped file, too.
        #[allow(unsafe_code)]
        let raw = unsafe { memory::create_buffer(context.0, flags, bytes, data.as_ptr().cast_mut().cast()) };
        Ok(Buffer { memory: Memory(named("clCreateBuffer", raw)?), bytes, host: PhantomData })
    }

    /// Write `data` from byte `offset` on, and wait for it.
    pub fn write<T: Pod>(&mut self, queue: &Queue, offset: usize, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        if bytes.is_empty() {
            return Ok(());
        }
        self.assert_holds(offset, bytes.len());
        let _call = Call::begin();
        // SAFETY: blocking, so `bytes` is read before this returns, and the range was just checked.
        #[allow(unsafe_code)]
        let event = unsafe {
            let from = bytes.as_ptr().cast::<c_void>();
            queues::enqueue_write_buffer(queue.0, self.memory.0, CL_TRUE, offset, bytes.len(), from, 0, ptr::null())
        };
        release(named("clEnqueueWriteBuffer", event)?);
        Ok(())
    }

    /// Read `data.len()` items from byte `offset` on, and wait for them.
    pub fn read<T: Pod>(&self, queue: &Queue, offset: usize, data: &mut [T]) -> Result<()> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(data);
        if bytes.is_empty() {
            return Ok(());
        }
        self.assert_holds(offset, bytes.len());
        let _call = Call::begin();
        // SAFETY: blocking, so `bytes` is written before this returns; any bytes are a value of a `Pod` type; the range
        // was just checked.
        #[allow(unsafe_code)]
        let event = unsafe {
            let to = bytes.as_mut_ptr().cast::<c_void>();
            queues::enqueue_read_buffer(queue.0, self.memory.0, CL_TRUE, offset, bytes.len(), to, 0, ptr::null())
        };
        release(named("clEnqueueReadBuffer", event)?);
        Ok(())
    }

    /// A driver would refuse the range, too; this crate never asks for a wrong one.
    fn assert_holds(&self, offset: usize, bytes: usize) {
        let end = offset.checked_add(bytes);
        assert!(end.is_some_and(|end| end <= self.bytes), "{bytes} bytes at {offset} of a buffer of {}", self.bytes);
    }
}

/// An argument of a kernel.
pub(super) enum Arg<'b> {
    Buffer(&'b Buffer<'b>),
    U32(u32),
    U64(u64),
}

impl Kernel {
    /// The largest power of two up to `limit` that a work group of this kernel may have.
    pub fn group_size(&self, device: DeviceId, limit: usize) -> Result<usize> {
        let what = kernels::CL_KERNEL_WORK_GROUP_SIZE;
        let bytes = named("clGetKernelWorkGroupInfo", kernels::get_kernel_work_group_data(self.0, device.0, what))?;
        let largest = bytes.first_chunk::<{ size_of::<usize>() }>().map_or(1, |b| usize::from_ne_bytes(*b));
        Ok(1 << largest.clamp(1, limit.max(1)).ilog2())
    }

    /// Run `groups` work groups of `group_size` items each, and wait for their end.
    ///
    /// # Safety
    /// `args` are those that the kernel declares, in number, order and type, and with them the kernel stays within its
    /// buffers and ends.
    #[allow(unsafe_code)]
    pub unsafe fn run(&mut self, queue: &Queue, args: &[Arg<'_>], groups: usize, group_size: usize) -> Result<()> {
        for (index, arg) in (0..).zip(args) {
            let (size, value) = match arg {
                Arg::Buffer(buffer) => (size_of::<cl_mem>(), (&raw const buffer.memory.0).cast::<c_void>()),
                Arg::U32(value) => (4, ptr::from_ref(value).cast()),
                Arg::U64(value) => (8, ptr::from_ref(value).cast()),
            };
            // SAFETY: the driver copies `size` bytes from `value`, which points at that many; that they suit the kernel
            // is the caller's promise.
            named("clSetKernelArg", unsafe { kernels::set_kernel_arg(self.0, index, size, value) })?;
        }
        let _call = Call::begin();
        let (global, local) = (groups * group_size, group_size);
        // SAFETY: one dimension, so each of the pointers names one number. The arguments are borrowed until the wait
        // below is over.
        let event = unsafe {
            queues::enqueue_nd_range_kernel(queue.0, self.0, 1, ptr::null(), &global, &local, 0, ptr::null())
        };
        release(named("clEnqueueNDRangeKernel", event)?);
        queue.finish()
    }
}

impl Queue {
    fn finish(&self) -> Result<()> {
        named("clFinish", queues::finish(self.0))
    }
}

/// Nobody asks for events.
#[allow(unsafe_code)]
fn release(event: cl_event) {
    // SAFETY: the event came from the call just made, and is given back once.
    let _ = unsafe { events::release_event(event) };
}
