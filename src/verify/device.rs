use super::record::HitRecord;
use crate::geom::Ray;

/// What is asked about each ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Query {
    /// The nearest hit.
    Closest,
    /// Whether there is any.
    Any,
}

/// Something that traces rays through one view, which it was made for.
pub trait Device {
    /// As `--device` names it: `cpu`, `opencl:0`.
    fn name(&self) -> &str;
    /// What it is, for people: the processor's own name and driver.
    fn description(&self) -> String;
    /// Why its answers may differ from the CPU's in their last bits; `None` where they must be equal bit for bit.
    fn deviation(&self) -> Option<String>;
    /// One record per ray, in order.
    fn trace(&mut self, rays: &[Ray], query: Query) -> Result<Vec<HitRecord>, DeviceError>;
}

/// Why a device gave no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    #[error("Cannot trace on the CPU.\n{0}")]
    Malformed(#[from] crate::trace::Malformed),
}
