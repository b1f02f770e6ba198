use super::driver::{Arg, Buffer, Status};
use super::list::failed;
use super::trace::{OpenCl, next_size};
use crate::geom::Ray;
use crate::trace::Malformed;
use crate::verify::record::RayRecord;
use crate::verify::{Device, DeviceError, HitRecord};
use std::time::Instant;

/// A slot of the triangle list as one instance shows it: the instance's record, 0 in a one-level file, and the slot in
/// its BLAS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Place {
    instance: u32,
    slot: u32,
}

impl OpenCl<'_> {
    const BRUTE_RAYS: usize = 1 << 14;
    const FIRST_TESTS: usize = 1 << 10;
    const LARGEST_TESTS: usize = 1 << 24;
    /// What mapping a ray into an instance is worth in triangle tests.
    const INSTANCE: usize = 16;

    /// The closest hits without the tree: each ray against each triangle slot of each instance, by the same triangle
    /// test. Where the tree loses nothing, every field but `triangle` equals that of [`Device::trace`]; `triangle` is
    /// the first slot of a duplicated triangle, of which a traversal may meet only a later one.
    ///
    /// The work is cut into launches of about [`OpenCl::LAUNCH`] by slots as well as by rays.
    ///
    /// # Errors
    /// As [`Device::trace`].
    pub fn brute_force(&mut self, rays: &[Ray]) -> Result<Vec<HitRecord>, DeviceError> {
        let slots =
            self.slots().map_err(|malformed| DeviceError::Malformed { device: self.description(), malformed })?;
        let mut out = vec![HitRecord::MISS; rays.len()];
        let mut tests = Self::FIRST_TESTS;
        for (rays, out) in
            rays.chunks(Self::BRUTE_RAYS.min(self.room)).zip(out.chunks_mut(Self::BRUTE_RAYS.min(self.room)))
        {
            let rays: Vec<RayRecord> = rays.iter().map(RayRecord::from).collect();
            self.brute_batch(&rays, out, &slots, &mut tests)
                .map_err(|status| failed(&self.context.info.summary(), status))?;
        }
        Ok(out)
    }

    /// References of each instance's BLAS, or of the only BLAS.
    pub(super) fn slots(&self) -> Result<Vec<u32>, Malformed> {
        let of = |instance: usize, blas: u32| match self.view.blas(blas as usize) {
            Some(blas) => Ok(blas.triangles.len() as u32),
            None => Err(Malformed::BlasOutOfRange { instance, blas }),
        };
        if !self.view.tlas_nodes.is_empty() {
            self.view.instances.iter().enumerate().map(|(i, instance)| of(i, instance.blas)).collect()
        } else if self.view.blases.is_empty() {
            Ok(Vec::new())
        } else {
            Ok(vec![of(0, 0)?])
        }
    }

    fn brute_batch(
        &mut self,
        rays: &[RayRecord],
        out: &mut [HitRecord],
        slots: &[u32],
        tests: &mut usize,
    ) -> Result<(), Status> {
        let (context, count) = (self.context, rays.len());
        let mut kernel = self.program.kernel(c"brute")?;
        let group_size = kernel.group_size(context.id, self.group_size)?;
        let distances = Buffer::new(&context.handle, count * size_of::<u64>())?;
        self.rays.write(&context.queue, 0, rays)?;
        let mut from = Place { instance: 0, slot: 0 };
        let mut fresh = true;
        while (from.instance as usize) < slots.len() {
            let to = advance(slots, from, *tests, Self::INSTANCE);
            let began = Instant::now();
            let mut args = self.scene.args();
            args.extend([Arg::Buffer(&self.rays), Arg::Buffer(&self.hits), Arg::Buffer(&distances)]);
            let numbers = [count as u32, u32::from(fresh), from.instance, from.slot, to.instance, to.slot];
            args.extend(numbers.map(Arg::U32));

            // SAFETY: these are the kernel's parameters. It checks instance, BLAS and slots against the counts given,
            // and its own number against `count`, for which the three buffers have room.
            #[allow(unsafe_code)]
            unsafe {
                kernel.run(&context.queue, &args, count.div_ceil(group_size), group_size)?;
            }
            *tests = next_size(*tests, began.elapsed(), Self::LARGEST_TESTS);
            (from, fresh) = (to, false);
        }
        if fresh { Ok(()) } else { self.hits.read(&context.queue, 0, out) }
    }
}

/// Where a launch that begins at `from` and may do `tests` triangle tests ends: before that place.
fn advance(slots: &[u32], from: Place, mut tests: usize, instance_cost: usize) -> Place {
    let mut at = from;
    while let Some(&count) = slots.get(at.instance as usize) {
        let left = count.saturating_sub(at.slot) as usize;
        if left > tests {
            return Place { slot: at.slot + tests as u32, ..at };
        }
        at = Place { instance: at.instance + 1, slot: 0 };
        tests -= left;
        if tests <= instance_cost {
            break;
        }
        tests -= instance_cost;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn launches_cover_every_slot_once_and_none_is_empty() {
        let slots = [5, 0, 0, 300, 1, 40, 0];
        for tests in [1, 2, 7, 64, 1000] {
            let (mut at, mut seen) = (Place { instance: 0, slot: 0 }, 0);
            while (at.instance as usize) < slots.len() {
                let to = advance(&slots, at, tests, 16);
                assert!((to.instance, to.slot) > (at.instance, at.slot), "{at:?}");
                let before = |p: Place| slots[..p.instance as usize].iter().sum::<u32>() + p.slot;
                assert!(before(to) - before(at) <= tests as u32);
                seen += before(to) - before(at);
                at = to;
            }
            assert_eq!(seen, slots.iter().sum::<u32>());
        }
    }
}
