use super::device::{Device, DeviceError, Query};
use super::record::HitRecord;
use crate::cache::View;
use crate::geom::Ray;
use crate::trace::{Malformed, NoObserver, try_any_hit, try_closest_hit};
use rayon::prelude::*;

/// The library's own traversal, on all threads.
pub struct Cpu<'a> {
    view: View<'a>,
}

impl<'a> Cpu<'a> {
    pub fn new(view: View<'a>) -> Cpu<'a> {
        Cpu { view }
    }
}

impl Device for Cpu<'_> {
    fn name(&self) -> &str {
        "cpu"
    }

    fn description(&self) -> String {
        format!("bvhc's own traversal, {} threads", rayon::current_num_threads())
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
        let records: Vec<Result<HitRecord, Malformed>> = rays.par_iter().map(one).collect();
        let failed = |malformed| DeviceError::Malformed { device: "the CPU".into(), malformed };
        records.into_iter().collect::<Result<_, _>>().map_err(failed)
    }
}
