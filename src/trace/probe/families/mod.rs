//! Families of rays: a tree that suits one purpose may be dear for another, so each is judged apart.
//!
//! Adapting a tree to what some rays meet buys their steps with those of others, if these are not asked. So there is a family
//! for each thing that trees are used for, and many places to start from in each. Every ray of `Outside` and `Inside` has an eye of its
//! own: the leaf that a tree happens to have at one eye decides nothing.
//!
//! Families that are made from different seeds have no ray in common. Those that *form* a tree must not be those that *judge* it.

mod rays;

use self::rays::Maker;
use super::CHUNK;
use crate::cache::View;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::trace::{Counters, closest_hit, try_any_hit, try_closest_hit};
use crate::tree::quality::{REPORT_INTERSECTION_COST, REPORT_TRAVERSAL_COST};

/// What rays are for, and where they start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Family {
    /// Cameras around the scene, which look at some place in it.
    Outside,
    /// Cameras between the surfaces, where light that entered comes along, which look anywhere.
    Inside,
    /// One cosine-weighted bounce off what the cameras see.
    Bounce,
    /// Ambient occlusion there: any hit, up to a tenth of the diagonal.
    Occlusion,
    /// Shadow rays from there to lights far away: any hit.
    Light,
    /// Cosine-weighted rays from either side of the surface, each part of it as often: light maps.
    Area,
    /// The same, each triangle as often: light at vertices, and whatever else is stored by triangle.
    Triangles,
    /// Lines that come from everywhere and cross the scene: queries of physics, and what the SAH assumes.
    Chords,
}

use Family as F;

/// How many families there are.
pub const FAMILIES: usize = 8;

impl Family {
    /// All of them, in the order of their sets.
    pub const ALL: [Family; FAMILIES] =
        [F::Outside, F::Inside, F::Bounce, F::Occlusion, F::Light, F::Area, F::Triangles, F::Chords];

    /// The name in notes and tables.
    pub fn name(self) -> &'static str {
        match self {
            F::Outside => "outside",
            F::Inside => "inside",
            F::Bounce => "bounce",
            F::Occlusion => "occlusion",
            F::Light => "light",
            F::Area => "area",
            F::Triangles => "triangles",
            F::Chords => "chords",
        }
    }

    /// Whether any hit ends its rays.
    fn is_any_hit(self) -> bool {
        matches!(self, F::Occlusion | F::Light)
    }
}

/// Rays of every family for one scene.
#[derive(Clone, Debug)]
pub struct FamilyRays {
    sets: [Vec<Ray>; FAMILIES],
}

/// What each ray of each family costs in some tree.
#[derive(Clone, Debug, PartialEq)]
pub struct FamilyCost {
    /// C_T · nodes + C_I · triangles, with the report's costs, by family and ray.
    rays: [Vec<f32>; FAMILIES],
}

impl FamilyRays {
    /// About `count` rays of each family. The tree of `view` decides nothing.
    ///
    /// A family is empty where it means nothing: `Outside` where next to nothing is seen from there, as of a closed room, and all that start from
    /// surfaces where there is none.
    pub fn new(view: &View<'_>, count: usize, seed: u64, exec: &Executor) -> FamilyRays {
        FamilyRays { sets: Maker::new(view, count, seed, exec).families() }
    }

    /// Rays of a family.
    pub fn len(&self, family: Family) -> usize {
        self.sets[family as usize].len()
    }

    /// Whether no family has a ray that starts from a surface: then there is nothing to judge by.
    pub fn is_empty(&self) -> bool {
        [F::Bounce, F::Area, F::Triangles].into_iter().all(|family| self.len(family) == 0)
    }

    /// Leave out families. What remains judges or forms trees alone.
    pub fn retain(&mut self, keep: impl Fn(Family) -> bool) {
        for family in Family::ALL {
            if !keep(family) {
                self.sets[family as usize].clear();
            }
        }
    }

    /// As many rays of each family as make what all of them together pay, in a tree of this cost, the same for each: then a tenth of what one
    /// pays weighs as much as a tenth of what another does.
    pub fn balanced(&self, cost: &FamilyCost) -> FamilyRays {
        let means = Family::ALL.map(|family| cost.mean(family).filter(|mean| *mean > 0.0));
        let least = means.iter().flatten().fold(f64::INFINITY, |least, mean| least.min(*mean));
        let thinned = |family: Family| {
            let rays = &self.sets[family as usize];
            let share = means[family as usize].map_or(1.0, |mean| least / mean);
            let count = (rays.len() as f64 * share).ceil() as usize;
            (0..count).map(|i| rays[i * rays.len() / count]).collect()
        };
        FamilyRays { sets: Family::ALL.map(thinned) }
    }

    /// Count what all rays do in a tree. A ray whose walk finds the tree malformed counts as far as it came.
    pub fn cost(&self, view: &View<'_>, exec: &Executor) -> FamilyCost {
        let one = |family: Family, ray: &Ray| {
            let mut counters = Counters::default();
            match family.is_any_hit() {
                true => drop(try_any_hit(view, ray, &mut counters)),
                false => drop(try_closest_hit(view, ray, &mut counters)),
            }
            let Counters { inner_nodes, triangles, .. } = counters;
            (REPORT_TRAVERSAL_COST * inner_nodes as f64 + REPORT_INTERSECTION_COST * triangles as f64) as f32
        };
        let of = |family: Family| {
            let chunks = exec.map_chunks(&self.sets[family as usize], CHUNK, |_, chunk| {
                chunk.iter().map(|ray| one(family, ray)).collect::<Vec<f32>>()
            });
            chunks.concat()
        };
        FamilyCost { rays: Family::ALL.map(of) }
    }

    /// All rays, each cut off at its closest hit, also where any would do: the boxes that a ray meets up to there are those that a traversal
    /// which went straight to its hit would look into.
    pub fn cut_off(&self, view: &View<'_>, exec: &Executor) -> Vec<Ray> {
        let mut rays = self.sets.concat();
        exec.map_chunks_mut(&mut rays, CHUNK, |_, chunk| {
            for ray in chunk {
                if let Ok(Some(hit)) = closest_hit(view, ray) {
                    ray.t_max = hit.t;
                }
            }
        });
        rays
    }
}

impl FamilyCost {
    /// What a ray of the family costs on average; `None` where the family is empty.
    pub fn mean(&self, family: Family) -> Option<f64> {
        let rays = &self.rays[family as usize];
        let sum: f64 = rays.iter().map(|cost| f64::from(*cost)).sum();
        (!rays.is_empty()).then(|| sum / rays.len() as f64)
    }

    /// The mean of what a ray of the family costs, and the standard deviation over its rays; `None` where the family is empty.
    pub fn spread(&self, family: Family) -> Option<(f64, f64)> {
        let (rays, mean) = (&self.rays[family as usize], self.mean(family)?);
        // About the mean, not as the difference of two large numbers.
        let squares: f64 = rays.iter().map(|cost| (f64::from(*cost) - mean).powi(2)).sum();
        Some((mean, (squares / rays.len() as f64).sqrt()))
    }

    /// By how much of its own cost a ray of the family costs more than in another tree, −0.1 for a tenth less, and the standard error of
    /// that. Both were asked the same rays, so that most of what chance does to one it does to the other. `None` where the family is empty.
    pub fn beyond(&self, other: &FamilyCost, family: Family) -> Option<(f64, f64)> {
        let (mine, theirs) = (self.mean(family)?, other.mean(family)?);
        if theirs == 0.0 {
            return Some((0.0, 0.0));
        }
        let ratio = mine / theirs;
        let pairs = self.rays[family as usize].iter().zip(&other.rays[family as usize]);
        let off = |(a, b): (&f32, &f32)| f64::from(*a) - ratio * f64::from(*b);
        let squares: f64 = pairs.map(off).map(|d| d * d).sum();
        let count = self.rays[family as usize].len() as f64;
        Some((ratio - 1.0, squares.sqrt() / (count * theirs)))
    }
}

#[cfg(test)]
mod tests;
