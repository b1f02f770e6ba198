//! From a hit in a frame back to the model. A frame numbers its trees, parts and triangles anew, so the sequence has to be asked.

use super::Hit;
use crate::cache::{Frame, Frames};

impl Frames<'_> {
    /// The name of the part that was hit in one of this file's frames; empty where it has none, or the hit is none of that frame.
    pub fn name_of(&self, frame: &Frame<'_>, hit: &Hit) -> &str {
        frame.part(hit.geom).and_then(|part| self.names().get(part as usize)).unwrap_or_default()
    }

    /// The name of the part's material; empty where it has none, or the hit is none of that frame.
    pub fn material_of(&self, frame: &Frame<'_>, hit: &Hit) -> &str {
        frame.part(hit.geom).and_then(|part| self.materials().get(part as usize)).unwrap_or_default()
    }

    /// The normal of the triangle that was hit, as [`Opened::normal`](crate::cache::Opened::normal) has it.
    pub fn normal_of(&self, frame: &Frame<'_>, hit: &Hit) -> Option<[f64; 3]> {
        frame.normal(hit, self.is_mirrored(frame.part(hit.geom)?))
    }

    /// Which vertices of the source the triangle has that was hit, as [`Opened::vertices`](crate::cache::Opened::vertices) numbers them. `None` where the
    /// file has no such numbers, or the hit is none of that frame.
    pub fn vertices_of(&self, frame: &Frame<'_>, hit: &Hit) -> Option<[u32; 3]> {
        let view = frame.view();
        let blas = view.instances.get(frame.instance_record(hit.instance?)?)?.blas as usize;
        // The frame has the references of the pose's topology, in its order and from another place on.
        let within = (hit.triangle as u64).checked_sub(view.blases.get(blas)?.ref_offset)?;
        let topology =
            self.topologies().get(self.poses().get(*frame.poses().get(blas)? as usize)?.topology as usize)?;
        let slot = usize::try_from(topology.ref_offset.checked_add(within)?).ok()?;
        let is_it = self.indexed_triangles().get(slot)?.prim == hit.prim;
        self.vertices().get(slot).filter(|_| is_it).copied()
    }
}
