use super::context::Context;
use super::driver::{Arg, Buffer, Kernel, Program, Status};
use super::list::{DeviceKind, failed};
use super::scene::Scene;
use super::status::malformed;
use crate::cache::View;
use crate::geom::Ray;
use crate::verify::record::RayRecord;
use crate::verify::{Device, DeviceError, HitRecord, Query};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// One file on one OpenCL device.
///
/// Rays go in batches: so small at first that even a slow device answers soon, and then as many as take about [`OpenCl::LAUNCH`], because drivers of displays kill
/// what runs for seconds. Each call of [`Device::trace`] begins anew, since the rays of one set may cost a thousand times what those of another do.
pub struct OpenCl<'a> {
    name: String,
    pub(super) view: View<'a>,
    pub(super) scene: Scene<'a>,
    traverse: Kernel,
    pub(super) group_size: usize,
    pub(super) rays: Buffer<'static>,
    pub(super) hits: Buffer<'static>,
    /// Rays that fit the buffers.
    pub(super) room: usize,
    pub(super) program: Arc<Program>,
    pub(super) context: &'a Context,
}

impl<'a> OpenCl<'a> {
    /// The time that a launch is meant to take.
    pub const LAUNCH: Duration = Duration::from_millis(100);
    /// A device that does fewer triangle tests a second in its self-test is slow: others do a hundred times as many even there, where launches are small.
    const SLOW: f64 = 1e6;
    const FIRST_BATCH: usize = 1 << 8;
    const LARGEST_BATCH: usize = 1 << 20;

    /// Bring a file to a device.
    ///
    /// # Errors
    /// Where the device has too little memory or its compiler refuses the kernels.
    pub fn new(context: &'a Context, view: View<'a>) -> Result<OpenCl<'a>, DeviceError> {
        let fails = |status| failed(&context.info.summary(), status);
        let scene = Scene::new(context, &view)?;
        let program = context.program(scene.parts)?;
        let traverse = context.kernel(&program, c"traverse")?;
        let group_size = traverse.group_size(context.id, 64).map_err(fails)?;

        // A sixteenth of what a buffer may have is enough room for rays.
        let most = context.options.max_allocation.unwrap_or(u64::MAX).min(context.info.max_allocation);
        let fitting = (most / 16) as usize / size_of::<RayRecord>();
        let room = fitting.clamp(group_size, Self::LARGEST_BATCH).next_multiple_of(group_size);
        let buffer = |bytes: usize| {
            Buffer::new(&context.handle, bytes)
                .map_err(|status| context.no_room(status, "a batch of rays", bytes as u64))
        };
        Ok(OpenCl {
            name: format!("opencl:{}", context.info.index),
            rays: buffer(room * size_of::<RayRecord>())?,
            hits: buffer(room * size_of::<HitRecord>())?,
            view,
            scene,
            traverse,
            group_size,
            room,
            program,
            context,
        })
    }

    /// Bytes of the file that were copied to the device; 0 where it reads them in place.
    pub fn copied_bytes(&self) -> u64 {
        self.scene.copied
    }

    fn launch(&mut self, rays: &[RayRecord], hits: &mut [HitRecord], query: Query) -> Result<(), Status> {
        self.rays.write(&self.context.queue, 0, rays)?;
        let mut args = self.scene.args();
        args.extend([Arg::Buffer(&self.rays), Arg::Buffer(&self.hits)]);
        args.extend([Arg::U32(rays.len() as u32), Arg::U32(u32::from(query == Query::Any))]);
        let groups = rays.len().div_ceil(self.group_size);

        // SAFETY: these are the kernel's parameters. It checks every index that it takes from the file against the
        // counts given, and its own number against `rays.len()`, for which both buffers have room; its loops are
        // bounded by the counts on any data.
        #[allow(unsafe_code)]
        unsafe {
            self.traverse.run(&self.context.queue, &args, groups, self.group_size)?;
        }
        self.hits.read(&self.context.queue, 0, hits)
    }
}

impl Device for OpenCl<'_> {
    fn name(&self) -> &str {
        &self.name
    }

    fn description(&self) -> String {
        let arithmetic = if self.context.soft_f64 { ", f64 emulated in integers" } else { "" };
        format!("{}{arithmetic}", self.context.info.summary())
    }

    fn deviation(&self) -> Option<String> {
        self.context.deviation.clone()
    }

    fn brute_force(&mut self, rays: &[Ray]) -> Result<Option<Vec<HitRecord>>, DeviceError> {
        OpenCl::brute_force(self, rays).map(Some)
    }

    /// A second or so: a processor does some 10⁸ tests a second, a GPU a thousand times as many. Of a simulator, or a driver without
    /// `f64`, the self-test says what it does in a second.
    fn brute_work(&self) -> u64 {
        let work = match self.context.info.kind {
            DeviceKind::Gpu | DeviceKind::Accelerator => 100_000_000_000,
            DeviceKind::Cpu | DeviceKind::Other => 100_000_000,
        };
        if self.context.brute_rate < Self::SLOW { self.context.brute_rate as u64 } else { work }
    }

    fn trace(&mut self, rays: &[Ray], query: Query) -> Result<Vec<HitRecord>, DeviceError> {
        let mut out = vec![HitRecord::MISS; rays.len()];
        let (mut done, mut next) = (0, Self::FIRST_BATCH.min(self.room));
        while done < rays.len() {
            let end = (done + next).min(rays.len());
            let batch: Vec<RayRecord> = rays[done..end].iter().map(RayRecord::from).collect();
            let began = Instant::now();
            self.launch(&batch, &mut out[done..end], query)
                .map_err(|status| failed(&self.context.info.summary(), status))?;
            if let Some(malformed) = out[done..end].iter().find_map(malformed) {
                return Err(DeviceError::Malformed { device: self.description(), malformed });
            }
            next = next_size(end - done, began.elapsed(), self.room);
            done = end;
        }
        Ok(out)
    }
}

/// How much to do in the next launch, after `size` took `time`: what would take [`OpenCl::LAUNCH`] at that pace, and at most eight times as much, since a launch that
/// is over at once says little about pace.
pub(super) fn next_size(size: usize, time: Duration, most: usize) -> usize {
    let fits = OpenCl::LAUNCH.as_secs_f64() / time.as_secs_f64().max(1e-9);
    let next = (size as f64 * fits.min(8.0)) as usize;
    next.max(64).min(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn launches_grow_while_they_are_short_and_shrink_when_they_are_long() {
        let ms = Duration::from_millis;
        assert_eq!(next_size(1000, ms(1), 1500), 1500);
        assert_eq!(next_size(1000, ms(0), 1 << 20), 8000);
        assert_eq!(next_size(1000, ms(100), 1500), 1000);
        assert_eq!(next_size(1000, ms(500), 1500), 200);
        assert_eq!(next_size(1 << 20, ms(60_000), 1 << 20), 1747, "one long launch is enough");
        assert_eq!(next_size(64, ms(5000), 1500), 64);
    }
}
