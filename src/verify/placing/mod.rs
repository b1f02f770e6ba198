//! Does a file hold the model's triangles where the model has them? Told without rays, from every corner: the model's position is moved by
//! its node's transform in `f64`, brought into the tree's coordinates by the matrix that rays come by, and held against what stands there.
//!
//! This shares nothing with the builder but the model as read. What it finds is of two kinds: rounding to 32 bits, which is told by its size
//! and is too much where a mesh loses its shape ([`Loss`]), and what no rounding explains.

mod judge;
mod sources;

use crate::cache::View;
use crate::exec::Executor;
use crate::scene::{Loss, Scene};
use judge::Judged;
use serde::Serialize;
use sources::{Place, Sources};
use std::collections::BTreeMap;

/// How a file's triangles stand to the model's.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Placed {
    /// Triangles looked at, once for each instance: all of them up to 2²⁴, else as many of each instance as come to that together, and one at least.
    pub instanced_triangles: u64,
    /// Rounding, of the instance that it costs most; in the unit of its tree.
    pub loss: Loss,
    /// That instance, in the model's order.
    pub instance: Option<u32>,
    /// What was lost before, from the numbers in the model's file to its positions as read.
    pub read: Loss,
    /// Triangles with a corner farther away than rounding explains, or of which the model knows nothing.
    pub astray: u64,
}

impl Placed {
    /// Everything is where it belongs and keeps its shape.
    pub fn is_right(&self) -> bool {
        self.astray == 0 && self.loss.is_tolerable() && self.read.is_tolerable()
    }
}

/// Triangles looked at in all, but for one of each instance, of which a file has no more than this. For each eight bytes are held.
const WORK: usize = 1 << 24;
/// Triangles of one task, and instances of one. Constants, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 14;
const PLACES: usize = 1 << 8;

/// Compare a file with the model that it was built from.
pub fn placed(view: &View<'_>, scene: &Scene, exec: &Executor) -> Placed {
    let sources = Sources::new(view, scene, WORK);
    let share = WORK / view.instances.len().max(1);
    let parts = if view.tlas_nodes.is_empty() {
        vec![of_place(view, 0, &Place::new(None), &sources, share, exec)]
    } else {
        exec.map_chunks(view.instances, PLACES, |_, some| {
            let mut all = Tallies::new();
            for record in some {
                let of_one = of_place(view, record.blas as usize, &Place::new(Some(record)), &sources, share, exec);
                of_one.into_iter().for_each(|(number, tally)| all.entry(number).or_default().append(tally));
            }
            all
        })
    };
    let mut tallies = Tallies::new();
    for (instance, tally) in parts.into_iter().flatten() {
        tallies.entry(instance).or_default().append(tally);
    }

    let mut all = Placed { read: scene.rounding.loss, ..Placed::default() };
    for (instance, tally) in tallies {
        all.instanced_triangles += tally.edges.len() as u64 + tally.astray;
        all.astray += tally.astray;
        let loss = tally.loss();
        if instance != UNKNOWN && (all.instance.is_none() || loss.is_more_than(&all.loss)) {
            (all.loss, all.instance) = (loss, Some(instance));
        }
    }
    all
}

/// Stands for the instance of triangles that the model does not have.
const UNKNOWN: u32 = u32::MAX;

/// By the numbers of instances.
type Tallies = BTreeMap<u32, Tally>;

/// What is known of an instance so far.
#[derive(Default)]
struct Tally {
    edges: Vec<f64>,
    sum: f64,
    farthest: f64,
    /// Triangles that came to nothing.
    gone: u64,
    astray: u64,
}

impl Tally {
    fn append(&mut self, mut other: Tally) {
        self.edges.append(&mut other.edges);
        self.sum += other.sum;
        self.farthest = self.farthest.max(other.farthest);
        self.gone += other.gone;
        self.astray += other.astray;
    }

    fn loss(mut self) -> Loss {
        if self.edges.is_empty() {
            return Loss::default();
        }
        let (share, middle) = (self.sum / self.edges.len() as f64, self.edges.len() / 2);
        let (_, edge, _) = self.edges.select_nth_unstable_by(middle, f64::total_cmp);
        Loss { farthest: self.farthest, edge: *edge, share, gone: self.gone as f64 / self.edges.len() as f64 }
    }

    fn add(&mut self, judged: &Judged) {
        if judged.astray {
            self.astray += 1;
        } else {
            let share = if judged.edge > 0.0 { (judged.moved / judged.edge).min(1.0) } else { 0.0 };
            self.edges.push(judged.edge);
            self.sum += share;
            self.gone += u64::from(judged.gone);
            self.farthest = self.farthest.max(judged.moved);
        }
    }
}

/// Look at some triangles of a tree where it stands, spread evenly: about `share` of them, and as many further looks where a triangle is not
/// where it was expected.
fn of_place(
    view: &View<'_>,
    tree: usize,
    place: &Place<'_>,
    sources: &Sources<'_>,
    share: usize,
    exec: &Executor,
) -> Tallies {
    let Some(blas) = view.blas(tree) else { return Tallies::new() };
    let step = blas.triangles.len().div_ceil(share.max(1)).max(1);
    let count = blas.triangles.len().div_ceil(step);
    let chunks = exec.map_range(count.div_ceil(CHUNK), |c| {
        let mut tallies = Tallies::new();
        let mut left = share / count.div_ceil(CHUNK);
        for record in blas.triangles.iter().step_by(step).skip(c * CHUNK).take(CHUNK) {
            match sources.nearest(record, place, &mut left) {
                Some((number, judged)) => tallies.entry(number).or_default().add(&judged),
                None => tallies.entry(UNKNOWN).or_default().astray += 1,
            }
        }
        tallies
    });
    let mut tallies = Tallies::new();
    for (number, tally) in chunks.into_iter().flatten() {
        tallies.entry(number).or_default().append(tally);
    }
    tallies
}

#[cfg(test)]
mod tests;
