//! [`Depths`]: how deep the leaf of each slot lies.

use crate::cache::View;
use crate::trace::{Hit, Malformed, SceneVisit, Step};

/// The depth of the leaf in which each slot of `TRIS` and each instance stands.
pub(super) struct Depths {
    /// By the number of the slot.
    slots: Vec<u8>,
    /// By the number of the instance in the scene's order; one more than the depth of its leaf, since its tree's root comes next.
    instances: Vec<u32>,
}

impl Depths {
    pub fn of(view: &View<'_>) -> Result<Depths, Malformed> {
        let mut depths = Depths { slots: vec![0; view.triangles.len()], instances: vec![0; view.instances.len()] };
        for (number, record) in view.blases.iter().enumerate() {
            let Some(tree) = view.blas(number) else { continue };
            let first = record.ref_offset as usize;
            tree.visit(|at| {
                if at.node.is_leaf() {
                    let start = first + at.node.first as usize;
                    // No leaf lies deeper than 64.
                    depths.slots[start..start + at.triangles.len()].fill(at.depth as u8);
                }
                Step::Descend
            })?;
        }
        view.visit(|place| {
            // The trees were walked above, each once.
            let SceneVisit::Top { instances, depth, .. } = place else { return Step::Skip };
            for instance in instances {
                if let Some(place) = depths.instances.get_mut(instance.id as usize) {
                    *place = depth + 1;
                }
            }
            Step::Descend
        })?;
        Ok(depths)
    }

    pub fn of_hit(&self, hit: &Hit) -> u32 {
        let above = hit.instance.and_then(|id| self.instances.get(id as usize)).copied().unwrap_or(0);
        above + self.slots.get(hit.triangle).copied().map_or(0, u32::from)
    }
}
