//! `SIDE`: which parts a baked transform mirrors.

use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::layout::{GeomRecord, NO_NODE, SectionKind, side_flags};

/// One word for each part, known bits alone, some of them set, and none on a part that nothing was baked into.
pub fn check(geoms: &[GeomRecord], sides: &[u32], out: &mut Report) {
    let at = Place::section(SectionKind::SIDE);
    if sides.len() != geoms.len() {
        let (expected, actual) = (format!("{} records, one for each part", geoms.len()), sides.len().to_string());
        return out.add(&rules::E0324, at, || (expected, actual));
    }
    if sides.iter().all(|side| *side == 0) {
        return out.add(&rules::E0324, at, || ("a part that is mirrored".into(), "none".into()));
    }
    for (i, (side, geom)) in sides.iter().zip(geoms).enumerate() {
        let place = Place::record(SectionKind::SIDE, i as u64);
        if side & !side_flags::MIRRORED != 0 {
            out.add(&rules::E0324, place, || ("only bit 0".into(), format!("{side:#x}")));
        } else if *side != 0 && geom.baked_node == NO_NODE {
            out.add(&rules::E0325, place, || ("a node in baked_node".into(), "none".into()));
        }
    }
}
