use super::device::{Device, DeviceError, Query};
use super::record::HitRecord;
use crate::cache::{CompactNode, View};
use crate::exec::Executor;
use crate::geom::Ray;
use crate::trace::wide::WideView;
use crate::trace::{Malformed, NoObserver, TurnedView, try_any_hit, try_closest_hit};

/// The library's own traversal of binary trees, on the threads of an executor.
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
        answers(self.exec, rays, "the CPU", |ray| match query {
            Query::Closest => Ok(try_closest_hit(&self.view, ray, &mut NoObserver)?.into()),
            Query::Any => Ok(HitRecord::any(try_any_hit(&self.view, ray, &mut NoObserver)?)),
        })
    }
}

/// Its traversal of the compact trees of a file: what a program that opens the file gets.
pub struct Compact<'a> {
    trees: WideView<'a, 8, CompactNode>,
    exec: &'a Executor,
}

impl<'a> Compact<'a> {
    /// Traces through `trees` on the threads of `exec`.
    pub fn new(trees: WideView<'a, 8, CompactNode>, exec: &'a Executor) -> Compact<'a> {
        Compact { trees, exec }
    }
}

impl Device for Compact<'_> {
    fn name(&self) -> &str {
        "compact8"
    }

    fn description(&self) -> String {
        format!("bvhc's own traversal of the compact trees, {} threads", self.exec.threads())
    }

    fn deviation(&self) -> Option<String> {
        None
    }

    fn names_any_copy(&self) -> bool {
        true
    }

    fn trace(&mut self, rays: &[Ray], query: Query) -> Result<Vec<HitRecord>, DeviceError> {
        answers(self.exec, rays, "compact8", |ray| match query {
            Query::Closest => Ok(self.trees.closest_hit(ray)?.into()),
            Query::Any => Ok(HitRecord::any(self.trees.any_hit(ray)?)),
        })
    }
}

/// Its traversal of a file's tree with turned subtrees: what a program that opens the file gets.
pub struct Turned<'a> {
    view: TurnedView<'a>,
    exec: &'a Executor,
}

impl<'a> Turned<'a> {
    /// Traces through `view` on the threads of `exec`.
    pub fn new(view: TurnedView<'a>, exec: &'a Executor) -> Turned<'a> {
        Turned { view, exec }
    }
}

impl Device for Turned<'_> {
    fn name(&self) -> &str {
        "turned"
    }

    fn description(&self) -> String {
        format!("bvhc's own traversal of turned subtrees, {} threads", self.exec.threads())
    }

    fn deviation(&self) -> Option<String> {
        None
    }

    fn names_any_copy(&self) -> bool {
        true
    }

    fn trace(&mut self, rays: &[Ray], query: Query) -> Result<Vec<HitRecord>, DeviceError> {
        answers(self.exec, rays, "turned", |ray| match query {
            Query::Closest => Ok(self.view.closest_hit(ray)?.into()),
            Query::Any => Ok(HitRecord::any(self.view.any_hit(ray)?)),
        })
    }
}

/// The answer to each ray. Collected first, so that of several errors the first ray's is told whatever thread met one first.
fn answers(
    exec: &Executor,
    rays: &[Ray],
    device: &str,
    one: impl Fn(&Ray) -> Result<HitRecord, Malformed> + Sync,
) -> Result<Vec<HitRecord>, DeviceError> {
    let records: Vec<Result<HitRecord, Malformed>> = exec.map_range(rays.len(), |i| one(&rays[i]));
    let failed = |malformed| DeviceError::Malformed { device: device.into(), malformed };
    records.into_iter().collect::<Result<_, _>>().map_err(failed)
}
