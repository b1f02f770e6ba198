use crate::trace::Malformed;
use crate::verify::HitRecord;

/// What made a kernel give up on a ray, as `kernels/triangle.cl` numbers it; `None` for a walk that came to its end.
pub(super) fn malformed(record: &HitRecord) -> Option<Malformed> {
    let (a, b, c) = (record.t, record.u, record.v);
    Some(match record.status {
        0 => return None,
        1 => Malformed::ChildOutOfRange { first: a, nodes: b as usize },
        2 => Malformed::LeafOutOfRange { first: a, count: b, refs: c as usize },
        3 => Malformed::BlasOutOfRange { instance: a as usize, blas: b },
        4 => Malformed::TooDeep,
        // 5, the last that there is.
        _ => Malformed::NotATree { nodes: a as usize },
    })
}
