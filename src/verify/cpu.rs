use super::device::{Device, DeviceError, Query};
use super::record::{HitRecord, NO_HIT};
use crate::cache::View;
use crate::geom::Ray;
use crate::trace::{NoObserver, try_any_hit, try_closest_hit};
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
        let one = |ray: &Ray| -> Result<HitRecord, DeviceError> {
            Ok(match query {
                Query::Closest => try_closest_hit(&self.view, ray, &mut NoObserver)?.into(),
                Query::Any if try_any_hit(&self.view, ray, &mut NoObserver)? => {
                    HitRecord { triangle: 0, ..HitRecord::MISS }
                }
                Query::Any => HitRecord { triangle: NO_HIT, ..HitRecord::MISS },
            })
        };
        rays.par_iter().map(one).collect()
    }
}
