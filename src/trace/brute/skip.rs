//! Boxes that let brute force skip triangles: of runs of source triangles, of runs of such runs, and so on.
//!
//! This is no tree that anything was decided for: run `i` of a level covers the triangles from `i · length` on, whatever they are.

use super::probe::Probe;
use crate::scene::Mesh;

/// Triangles in a run of the lowest level.
const RUN: usize = 16;
/// Runs that make one of the next level.
const FAN: usize = 8;

type Bounds = [[f64; 3]; 2];

/// The levels of a mesh, lowest first; the last has one box.
pub(super) struct Runs {
    levels: Vec<Vec<Bounds>>,
    triangles: usize,
}

impl Runs {
    pub fn new(mesh: &Mesh) -> Runs {
        let corners = |run: &[[u32; 3]]| join(run.iter().flatten().map(|&v| mesh.positions[v as usize].map(f64::from)));
        let mut levels: Vec<Vec<Bounds>> = vec![mesh.triangles.chunks(RUN).map(corners).collect()];
        while let Some(level) = levels.last().filter(|level| level.len() > 1) {
            let next = level.chunks(FAN).map(|run| join(run.iter().flatten().copied())).collect();
            levels.push(next);
        }
        Runs { levels, triangles: mesh.triangles.len() }
    }

    /// Min and max of all triangles; min above max for none.
    pub fn bounds(&self) -> Bounds {
        self.levels.last().and_then(|top| top.first()).copied().unwrap_or(join(std::iter::empty()))
    }

    /// Call `test` for every triangle that is not in a run that the ray surely misses before `limit`, which `test` may lower. Returned is how
    /// many boxes and triangles were looked at.
    pub fn visit(&self, probe: &Probe, limit: &mut f64, mut test: impl FnMut(usize, &mut f64)) -> u64 {
        self.visit_run(probe, limit, self.levels.len() - 1, 0, &mut test)
    }

    /// As deep as there are levels: one for each factor 8 of the number of triangles.
    fn visit_run(
        &self,
        probe: &Probe,
        limit: &mut f64,
        level: usize,
        run: usize,
        test: &mut impl FnMut(usize, &mut f64),
    ) -> u64 {
        if !self.levels[level].get(run).is_some_and(|bounds| probe.meets(bounds, *limit)) {
            return 1;
        }
        if level == 0 {
            let triangles = run * RUN..((run + 1) * RUN).min(self.triangles);
            let count = triangles.len() as u64;
            triangles.for_each(|triangle| test(triangle, limit));
            return 1 + count;
        }
        let below = run * FAN..(run + 1) * FAN;
        1 + below.map(|below| self.visit_run(probe, limit, level - 1, below, test)).sum::<u64>()
    }
}

fn join(points: impl Iterator<Item = [f64; 3]>) -> Bounds {
    points.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[lo, hi], p| {
        [[0, 1, 2].map(|a| lo[a].min(p[a])), [0, 1, 2].map(|a| hi[a].max(p[a]))]
    })
}
