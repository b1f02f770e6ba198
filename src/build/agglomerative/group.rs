//! A group of clusters, merged in rounds until few are left.

use super::forest::{Cluster, Merge, Rules, Weight};
use super::pairs::{FEWEST, pair_the_rest};
use super::window::{SIZE, Window, keep};
use crate::build::prim_ref::PrimRef;
use std::ops::Range;

/// Clusters in a group at most. All that is known of them stays in the second-level cache.
pub(super) const GROUP: usize = SIZE;
/// What groups are made of, in order.
#[derive(Clone, Copy)]
pub(super) enum Inputs<'a> {
    /// Each a cluster of one; with the number of the first.
    References(&'a [PrimRef], u32),
    Clusters(&'a [Cluster]),
}

impl<'a> Inputs<'a> {
    pub fn len(&self) -> usize {
        match self {
            Inputs::References(refs, _) => refs.len(),
            Inputs::Clusters(clusters) => clusters.len(),
        }
    }

    pub fn slice(self, range: Range<usize>) -> Inputs<'a> {
        match self {
            Inputs::References(refs, first) => Inputs::References(&refs[range.clone()], first + range.start as u32),
            Inputs::Clusters(clusters) => Inputs::Clusters(&clusters[range]),
        }
    }
}

/// Clusters in columns. Those of the start and those that come of them are numbered in one row, the group's own.
pub(super) struct Group {
    window: Window,
    /// How many clusters there are.
    left: usize,
    /// The own number of each.
    own: [u32; GROUP],
    /// How many own numbers are in use.
    numbered: usize,
    /// By own number: the number in the forest.
    names: [u32; 2 * GROUP],
    weights: [Weight; 2 * GROUP],
    partners: [u32; GROUP],
    /// Scratch: clusters that are the first of a pair, and clusters that keep a place.
    firsts: [u32; GROUP],
    kept: [u32; GROUP],
}

impl Group {
    pub fn boxed() -> Box<Group> {
        Box::new(Group {
            window: Window::default(),
            left: 0,
            own: [0; GROUP],
            numbered: 0,
            names: [0; 2 * GROUP],
            weights: [Weight::default(); 2 * GROUP],
            partners: [0; GROUP],
            firsts: [0; GROUP],
            kept: [0; GROUP],
        })
    }

    #[inline(always)]
    pub fn load(&mut self, inputs: Inputs, rules: &Rules) {
        (self.left, self.numbered) = (inputs.len(), inputs.len());
        match inputs {
            Inputs::References(refs, first) => {
                for (i, r) in refs.iter().enumerate() {
                    let weight = Weight::of_one(rules.area(&r.bounds()), rules.sah);
                    self.put(i, Cluster { weight, bounds: r.bounds(), number: first + i as u32 });
                }
            }
            Inputs::Clusters(clusters) => clusters.iter().enumerate().for_each(|(i, c)| self.put(i, *c)),
        }
    }

    #[inline(always)]
    fn put(&mut self, i: usize, cluster: Cluster) {
        let i = i % GROUP;
        self.window.put(i, &cluster.bounds);
        (self.own[i], self.names[i], self.weights[i]) = (i as u32, cluster.number, cluster.weight);
    }

    /// Merge until at most `goal` clusters are left. What becomes one goes to `merges` in order, and `number` is that of the first.
    #[inline(always)]
    pub fn merge(&mut self, goal: usize, rules: &Rules, merges: &mut [Merge], number: u32) {
        let mut made = 0;
        while self.left > goal {
            self.window.best_matches(self.left, rules, &mut self.partners);
            let mut pairs = self.list_pairs();
            if pairs * FEWEST < self.left {
                pair_the_rest(&mut self.partners[..self.left], &mut [false; GROUP][..self.left]);
                pairs = self.list_pairs();
            }
            for at in 0..pairs {
                let i = self.firsts[at] as usize;
                merges[made] = self.join(i, self.partners[i] as usize, rules, number + made as u32);
                made += 1;
            }
            self.left -= pairs;
            let kept = &self.kept[..self.left];
            self.window.keep(kept);
            keep(&mut self.own, kept);
        }
    }

    /// Write what is left, in order; returns how many clusters.
    #[inline(always)]
    pub fn clusters(&self, to: &mut [Cluster]) -> usize {
        for (i, place) in to.iter_mut().enumerate().take(self.left) {
            let own = self.own[i] as usize;
            *place = Cluster { weight: self.weights[own], bounds: self.window.bounds(i), number: self.names[own] };
        }
        self.left
    }

    /// List the first clusters of pairs, and all but the second ones; returns how many pairs there are.
    #[inline(always)]
    fn list_pairs(&mut self) -> usize {
        let (mut pairs, mut kept) = (0, 0);
        for i in 0..self.left {
            let partner = self.partners[i] as usize;
            let mutual = self.partners[partner % GROUP] as usize == i;
            // Without a branch: which way it went nobody could foresee.
            self.firsts[pairs % GROUP] = i as u32;
            pairs += usize::from(mutual & (partner > i));
            self.kept[kept % GROUP] = i as u32;
            kept += usize::from(!(mutual & (partner < i)));
        }
        pairs
    }

    /// Put both at the place of the first. The first child is the one of larger area: rays that look for any hit find one sooner there.
    #[inline(always)]
    fn join(&mut self, first: usize, second: usize, rules: &Rules, number: u32) -> Merge {
        let [a, b] = [self.window.bounds(first), self.window.bounds(second)];
        let bounds = a.union(b);
        self.window.put(first, &bounds);
        let [i, j] = [first, second].map(|at| self.own[at % GROUP] as usize % (2 * GROUP));
        let weight = Weight::joined(self.weights[i], self.weights[j], rules.area(&bounds), rules);
        let swap = rules.area(&b) > rules.area(&a);
        let children = if swap { [self.names[j], self.names[i]] } else { [self.names[i], self.names[j]] };

        let own = self.numbered % (2 * GROUP);
        self.numbered += 1;
        (self.own[first % GROUP], self.names[own], self.weights[own]) = (own as u32, number, weight);
        Merge { children, count: weight.count, inner: weight.inner }
    }
}
