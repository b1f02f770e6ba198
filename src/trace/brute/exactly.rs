//! The second step: a ray and a triangle that are both known without rounding.

use super::probe::{Map, Probe, Span};
use super::{Place, Standing};
use crate::geom::{Affine, Point, Ray};
use crate::scene::Mesh;
use crate::trace::exact::Line;
use std::cmp::Ordering;

/// What is known without rounding of a ray and the triangles of an instance.
pub(super) enum Exactly {
    Nothing,
    /// Both are the same as in the world.
    Identity,
    /// The file's matrix maps the ray.
    Stored {
        map: Map,
        matrix: [f32; 12],
    },
    /// The file holds the triangles in the world, their vertices moved and rounded once.
    Baked {
        map: Map,
        to_world: Affine,
        bounds: [[f64; 3]; 2],
    },
}

impl Exactly {
    pub fn line(&self, ray: &Ray) -> Option<Line> {
        match self {
            Exactly::Nothing => None,
            Exactly::Identity | Exactly::Baked { .. } => Some(Line::new(ray.origin, ray.direction)),
            Exactly::Stored { matrix, .. } => Some(Line::mapped(ray, matrix)),
        }
    }

    /// A triangle's corners in the space of [`Exactly::line`].
    pub fn corners(&self, mesh: &Mesh, triangle: usize) -> [Point; 3] {
        match self {
            Exactly::Baked { to_world, .. } => mesh.baked_corners(triangle, to_world),
            _ => mesh.corners(triangle),
        }
    }
}

/// A ray in an instance's space for the second step.
pub(super) struct ExactRay {
    line: Option<Line>,
    /// The ray where the file has the triangles, with a slack for arithmetic alone.
    stored: Option<Probe>,
}

impl ExactRay {
    pub fn new(ray: &Ray, place: &Place, bounds: &[[f64; 3]; 2]) -> ExactRay {
        let stored = match &place.exactly {
            Exactly::Stored { map, .. } => Some(Probe::new(ray, map, bounds)),
            Exactly::Baked { map, bounds, .. } => Some(Probe::new(ray, map, bounds)),
            _ => None,
        };
        ExactRay { line: place.exactly.line(ray), stored }
    }

    /// How the ray stands to a triangle for which the first step gave `span`; `None` for a miss that `f64` cannot take for a hit.
    pub fn decide(&self, ray: &Ray, span: Span, corners: [Point; 3]) -> Option<(Span, Standing)> {
        let mut near = span;
        if let Some(stored) = &self.stored {
            let inner = stored.test(corners);
            match inner {
                // The scene says hit: where the file's numbers say something else, they are wrong.
                Some(inner) if span.certain && inner.certain && inner.overlaps(&span) => {
                    return Some((inner, Standing::Hit));
                }
                _ if span.certain => return Some((span, Standing::Hit)),
                Some(inner) if inner.certain => return Some((inner, Standing::Hit)),
                Some(inner) => near = inner,
                None => return None,
            }
        }
        let Some(line) = &self.line else { return Some((span, Standing::Unsure)) };
        let Some(meeting) = line.meet(corners) else { return Some((near, Standing::BareMiss)) };
        let in_range = meeting.t.compare(ray.t_min).is_some_and(Ordering::is_ge)
            && meeting.t.compare(ray.t_max).is_some_and(Ordering::is_le);
        if !in_range {
            return Some((near, Standing::BareMiss));
        }
        Some((Span { t: meeting.t.to_f64(), ..near }, Standing::BareHit))
    }
}
