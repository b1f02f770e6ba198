use super::device::{Device, DeviceError, Query};
use super::record::HitRecord;
use crate::cache::View;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::trace::{Malformed, NoObserver, try_any_hit, try_closest_hit};

/// The library's own traversal, on the threads of an executor.
pub struct Cpu<'a> {
    view: View<'a>,
    exec: &'a Executor,
}

impl<'a> Cpu<'a> {
    /// Traces through `view` on the threads of `exec`.
    pub fn new(view: View<'a>, exec: &'a Executor) -> Cpu<'a> {
        Cpu { view, exec }
    }

    /// [`Device::description`] of the CPU with these threads.
    pub fn describe(exec: &Executor) -> String {
        format!("bvhc's own traversal, {} threads", exec.threads())
    }
}

impl Device for Cpu<'_> {
    fn name(&self) -> &str {
        "cpu"
    }

    fn description(&self) -> String {
        Cpu::describe(self.exec)
    }

    fn deviation(&self) -> Option<String> {
        None
    }

    fn trace(&mut self, rays: &[Ray], query: Query) -> Result<Vec<HitRecord>, DeviceError> {
        let one = |ray: &Ray| match query {
            Query::Closest => Ok(try_closest_hit(&self.view, ray, &mut NoObserver)?.into()),
            Query::Any => Ok(HitRecord::any(try_any_hit(&self.view, ray, &mut NoObserver)?)),
        };
        // Collected first, so that of several errors the first ray's is told whatever thread met one first.
        let records: Vec<Result<HitRecord, Malformed>> = self.exec.map_range(rays.len(), |i| one(&rays[i]));
        let failed = |malformed| DeviceError::Malformed { device: "the CPU".into(), malformed };
        records.into_iter().collect::<Result<_, _>>().map_err(failed)
    }
}
