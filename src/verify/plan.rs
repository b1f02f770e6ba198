use crate::cache::View;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::random::Random;
use crate::trace::brute::{Oracle, Source};
use crate::trace::rays::{RaySet, Sampler};
use crate::trace::{Counters, try_closest_hit};

/// What to trace, and how much of it the oracle judges. Equal plans trace equal rays on any machine with any number of threads.
#[derive(Clone, Debug)]
pub struct Plan {
    /// In total; [`Plan::rays_of`] says how they are shared.
    pub rays: u64,
    /// Equal seeds give equal rays on every machine.
    pub seed: u64,
    /// What the rays are after; see [`RaySet`].
    pub sets: Vec<RaySet>,
    /// Which questions go to the devices.
    pub asked: Asked,
    /// Who says what is right.
    pub reference: Reference,
    /// What the oracle may spend on its sample: boxes and triangles looked at, which take some tens of nanoseconds each, and exact decisions, each of
    /// which counts for many.
    pub oracle_work: u64,
    /// How many rays the oracle judges in its sample, whatever that takes; `None`: as many as [`Plan::oracle_work`] allows. Differences between devices are judged
    /// beside them.
    pub judged: Option<u64>,
}

/// Which questions go to the devices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Asked {
    /// The closest hit, and whether there is any.
    Both,
    /// Only whether there is any. The CPU's closest hits are what the answers are compared with.
    AnyHit,
}

/// Who says what is right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reference {
    /// Brute force for a sample, the CPU's traversal of the file for all other rays.
    Bvh,
    /// Brute force for every ray.
    Brute,
}

impl Default for Plan {
    fn default() -> Plan {
        Plan {
            rays: 1_000_000,
            seed: 1,
            sets: RaySet::ALL.to_vec(),
            asked: Asked::Both,
            reference: Reference::Bvh,
            oracle_work: Plan::ORACLE_WORK,
            judged: None,
        }
    }
}

/// Rays that are in memory at once; 64 bytes each, and 32 more a device.
const BATCH: u64 = 1 << 18;

/// Rays that share a seed, the unit in which threads make them.
const UNIT: u64 = 1 << 12;

impl Plan {
    /// A few seconds on one core.
    pub const ORACLE_WORK: u64 = 100_000_000;

    /// Nodes entered and triangles tested by all rays together, where a plan may choose how many there are: some tens of seconds on one core.
    pub const TRACE_WORK: u64 = 1_000_000_000;

    /// Fewest rays that the oracle judges of each set, unless that takes more than [`Plan::AT_MOST`] times its work.
    const LEAST: u64 = 16;

    /// Fewest rays of a set that are traced, however long each is.
    const FEWEST: u64 = 2;

    /// How many times [`Plan::oracle_work`] the fewest rays may take: where every ray meets thousands of triangles in one place, each is judged for seconds.
    const AT_MOST: u64 = 4;

    /// How many of a set's rays go to the oracle where one takes `cost` of [`Plan::oracle_work`].
    pub fn sampled(&self, set: usize, cost: u64) -> u64 {
        let rays = self.rays_of(set);
        match self.reference {
            Reference::Brute => rays,
            Reference::Bvh if self.judged.is_some() => {
                self.judged.map_or(0, |judged| RaySet::shares(&self.sets, judged)[set]).min(rays)
            }
            Reference::Bvh => {
                let within = |times: u64| times.saturating_mul(self.oracle_work) / cost.max(1) / self.sets.len() as u64;
                within(1).max(Self::LEAST.min(within(Self::AT_MOST))).max(1).min(rays)
            }
        }
    }

    /// What one ray costs the oracle, as the first few of every set tell: fewer where these alone would take a good part of its work.
    pub fn cost(&self, oracle: &Oracle<'_>, sampler: &Sampler<'_>, exec: &Executor) -> u64 {
        let few: Vec<Vec<Ray>> = (0..self.sets.len()).map(|set| self.few_of(set, sampler, exec)).collect();
        let (mut work, mut count) = (0, 0);
        for turn in 0..Self::LEAST as usize {
            let rays: Vec<&Ray> = few.iter().filter_map(|rays| rays.get(turn)).collect();
            let tests = exec.map_range(rays.len(), |i| oracle.trace_counted(rays[i]).1);
            work += tests.into_iter().sum::<u64>();
            count += rays.len() as u64;
            if work > self.oracle_work / 4 {
                break;
            }
        }
        work / count.max(1)
    }

    /// The same plan with fewer rays where the file's trees make each ray long, so that a run which is left to choose ends: at most
    /// [`Plan::TRACE_WORK`] by what the first few rays of every set take. Counted, not timed: the same on every machine.
    #[must_use]
    pub fn affordable(&self, view: &View<'_>, sampler: &Sampler<'_>, exec: &Executor) -> Plan {
        let steps = |ray: &Ray| {
            let mut counters = Counters::default();
            // What cannot be walked is found and told by the run itself.
            let _ = try_closest_hit(view, ray, &mut counters);
            u128::from(counters.inner_nodes + counters.triangles)
        };
        // By the share of each set: rays from far away take a hundred times as long, and there are a hundredth as many.
        let sets = self.sets.len() as u64;
        let enough = u128::from(Self::TRACE_WORK / 16 / sets.max(1));
        let of_set = |set: usize| {
            let (mut work, mut count) = (0, 0);
            for ray in &self.few_of(set, sampler, exec) {
                (work, count) = (work + steps(ray), count + 1);
                if work > enough {
                    break; // a few rays take long enough to tell
                }
            }
            work * u128::from(self.rays_of(set)) / u128::max(count, 1)
        };
        let work = exec.map_range(self.sets.len(), of_set).into_iter().sum::<u128>().max(1);
        let least = Self::FEWEST * sets;
        let affordable = u128::from(self.rays) * u128::from(Self::TRACE_WORK) / work;
        Plan { rays: self.rays.min(u64::try_from(affordable).unwrap_or(u64::MAX).max(least)), ..self.clone() }
    }

    /// Some rays of a set.
    fn few_of(&self, set: usize, sampler: &Sampler<'_>, exec: &Executor) -> Vec<Ray> {
        self.rays_in(&Batch { set, first: 0, count: self.rays_of(set).min(Self::LEAST) }, sampler, exec)
    }

    /// The share of `sets[set]`.
    pub fn rays_of(&self, set: usize) -> u64 {
        RaySet::shares(&self.sets, self.rays)[set]
    }

    /// All rays in pieces that fit in memory, set after set.
    pub(crate) fn batches(&self) -> impl Iterator<Item = Batch> {
        let shares = RaySet::shares(&self.sets, self.rays);
        shares.into_iter().enumerate().flat_map(|(set, share)| {
            let starts = (0..share).step_by(BATCH as usize);
            starts.map(move |first| Batch { set, first, count: BATCH.min(share - first) })
        })
    }

    /// The rays of a batch.
    pub(crate) fn rays_in(&self, batch: &Batch, sampler: &Sampler<'_>, exec: &Executor) -> Vec<Ray> {
        self.units_of(batch, exec, |count, seed| sampler.rays(self.sets[batch.set], count, seed))
    }

    /// The triangles that the rays of a batch are aimed at, where its set does so.
    pub(crate) fn targets_in(&self, batch: &Batch, sampler: &Sampler<'_>, exec: &Executor) -> Vec<Source> {
        self.units_of(batch, exec, |count, seed| sampler.targets(self.sets[batch.set], count, seed))
    }

    fn units_of<T: Copy + Send>(
        &self,
        batch: &Batch,
        exec: &Executor,
        of: impl Fn(usize, u64) -> Vec<T> + Sync,
    ) -> Vec<T> {
        let units: Vec<u64> = (batch.first / UNIT..(batch.first + batch.count).div_ceil(UNIT)).collect();
        let some = exec.map(units, |_, unit| {
            let count = UNIT.min(batch.first + batch.count - unit * UNIT);
            of(count as usize, seed_of(self.seed, unit))
        });
        some.concat()
    }
}

/// Some of a set's rays: those from number `first` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Batch {
    /// Index in [`Plan::sets`].
    pub set: usize,
    /// Number of its first ray in the set.
    pub first: u64,
    /// How many rays it has.
    pub count: u64,
}

impl Batch {
    /// Which of the batch's rays are among `sampled` rays spread evenly over a set of `rays`.
    pub fn sample(&self, sampled: u64, rays: u64) -> Vec<usize> {
        let (sampled, rays) = (u128::from(sampled), u128::from(rays.max(1)));
        let at = |k: u128| (k * rays / sampled) as u64;
        let (mut low, mut high) = (0u128, sampled);
        while low < high {
            let middle = (low + high) / 2;
            if at(middle) < self.first { low = middle + 1 } else { high = middle }
        }
        (low..sampled).map(at).take_while(|i| *i < self.first + self.count).map(|i| (i - self.first) as usize).collect()
    }
}

/// Seeds that differ in any bit give streams that have nothing in common.
fn seed_of(seed: u64, unit: u64) -> u64 {
    let stream = Random::new(seed).bits();
    Random::new(stream ^ unit).bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    fn plan(rays: u64, sets: usize) -> Plan {
        Plan { rays, sets: RaySet::ALL[..sets].to_vec(), ..Plan::default() }
    }

    #[test]
    fn batches_cover_every_ray_of_every_set_once() {
        for (rays, sets) in [(0, 1), (1, 3), (7, 3), (1_000_000, 2), (3 * BATCH, 1)] {
            let plan = plan(rays, sets);
            let mut next = vec![0; sets];
            for batch in plan.batches() {
                assert_eq!(batch.first, next[batch.set]);
                assert!(batch.count > 0 && batch.count <= BATCH);
                next[batch.set] += batch.count;
            }
            assert_eq!(next.iter().sum::<u64>(), rays);
            assert!(next.iter().max().unwrap() - next.iter().min().unwrap() <= 1);
        }
    }

    #[test]
    fn rays_depend_on_the_seed_and_on_their_number_alone() {
        let scene = Scene::default();
        let sampler = Sampler::new(&scene);
        let plan = plan(3 * UNIT, 1);
        let all = plan.rays_in(&Batch { set: 0, first: 0, count: 3 * UNIT }, &sampler, &Executor::sequential());
        let tail = plan.rays_in(&Batch { set: 0, first: UNIT, count: UNIT + 5 }, &sampler, &Executor::sequential());
        assert_eq!(all[UNIT as usize..][..UNIT as usize + 5], tail);
        assert!(all.windows(2).all(|w| w[0] != w[1]));
        let other =
            Plan { seed: 2, ..plan }.rays_in(&Batch { set: 0, first: 0, count: 8 }, &sampler, &Executor::sequential());
        assert_ne!(all[..8], other[..]);
    }

    #[test]
    fn the_sample_is_spread_over_all_batches_and_keeps_to_the_work_allowed() {
        let plan = Plan { oracle_work: 1_000_000, ..plan(1_000_000, 2) };
        assert_eq!(plan.sampled(0, 10), 50_000);
        assert_eq!(plan.sampled(0, 100_000), Plan::LEAST);
        assert_eq!([plan.sampled(0, 400_000), plan.sampled(0, 1_000_000_000)], [5, 1], "few rays take long enough");
        assert_eq!(plan.sampled(0, 0), 500_000);
        assert_eq!(Plan { reference: Reference::Brute, ..plan.clone() }.sampled(1, 1_000_000_000), 500_000);
        let few = Plan { judged: Some(100), ..plan.clone() };
        assert_eq!((0..2).map(|set| few.sampled(set, 1)).sum::<u64>(), 100, "{:?}", few.sets);
        let picked: usize = plan.batches().filter(|b| b.set == 0).map(|b| b.sample(1000, plan.rays_of(0)).len()).sum();
        assert_eq!(picked, 1000);
        let batch = Batch { set: 0, first: 10, count: 5 };
        assert_eq!(batch.sample(20, 20), [0, 1, 2, 3, 4]);
        assert_eq!(batch.sample(0, 20), [0; 0]);
    }
}
