//! Time and work: each arithmetic over the same rays, turn by turn, on one thread.

use super::AccuracyError;
use crate::build::Progress;
use crate::cache::View;
use crate::geom::Ray;
use crate::trace::Counters;
use crate::trace::arithmetic::{Arithmetic, closest_hit_by, visits_by};
use std::time::Instant;

#[derive(Clone, Copy, Debug)]
pub struct Pace {
    pub mrays_per_second: f64,
    pub inner_nodes_per_ray: f64,
    pub triangles_per_ray: f64,
}

/// In the order of [`Arithmetic::all`].
///
/// All take turns in every round, each round beginning with another one, so that what else the machine does hits all alike.
pub fn paces(view: &View<'_>, rays: &[Ray], rounds: u32, progress: &dyn Progress) -> Result<Vec<Pace>, AccuracyError> {
    let all: Vec<Arithmetic> = Arithmetic::all().collect();
    let mut seconds = vec![Vec::new(); all.len()];
    for round in 0..rounds as usize {
        for turn in 0..all.len() {
            if progress.is_cancelled() {
                return Err(AccuracyError::Cancelled);
            }
            let which = (round + turn) % all.len();
            let start = Instant::now();
            for ray in rays {
                std::hint::black_box(closest_hit_by(all[which], view, ray)?);
            }
            seconds[which].push(start.elapsed().as_secs_f64());
            progress.advance(1);
        }
    }

    // Count apart from timing, since counting takes time.
    let mut paces = Vec::new();
    for (arithmetic, seconds) in all.into_iter().zip(&mut seconds) {
        let mut counters = Counters::default();
        for ray in rays {
            counters = counters + visits_by(arithmetic, view, ray)?;
        }
        let each = 1.0 / rays.len().max(1) as f64;
        seconds.sort_by(f64::total_cmp);
        let median = seconds.get(seconds.len() / 2).copied().unwrap_or(0.0);
        paces.push(Pace {
            mrays_per_second: if median > 0.0 { rays.len() as f64 / median / 1e6 } else { 0.0 },
            inner_nodes_per_ray: counters.inner_nodes as f64 * each,
            triangles_per_ray: counters.triangles as f64 * each,
        });
    }
    Ok(paces)
}
