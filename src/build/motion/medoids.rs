//! Which of many candidates, each of which serves each frame at some cost, to keep when only a few may be kept.
//!
//! It is the k-medians problem: greedy choice, then swaps while they help (Kaufman and Rousseeuw, "Clustering by means of Medoids", 1987; with
//! the second nearest kept as in Schubert and Rousseeuw, "Faster k-Medoids Clustering", 2019).

/// Rounds of swaps. Few are ever made; the bound keeps a bad case finite.
const MOST_SWAPS: usize = 64;

/// Candidates that are kept, and which of them serves each frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choice {
    /// The candidates, ascending.
    pub kept: Vec<usize>,
    /// For each frame the one that is cheapest there, as an index into `kept`; the first of equal ones.
    pub serves: Vec<usize>,
    /// The mean cost over the frames.
    pub mean: f64,
}

impl Choice {
    /// Given candidates, each frame served by the cheapest.
    pub fn of(costs: &[Vec<f64>], kept: Vec<usize>) -> Choice {
        let nearest = |row: &Vec<f64>| {
            (0..kept.len()).fold(None, |best: Option<(usize, f64)>, i| match best {
                Some((_, least)) if !(row[kept[i]] < least) => best,
                _ => Some((i, row[kept[i]])),
            })
        };
        let each: Vec<(usize, f64)> = costs.iter().filter_map(nearest).collect();
        let sum: f64 = each.iter().map(|(_, cost)| cost).sum();
        let mean = if each.is_empty() { 0.0 } else { sum / each.len() as f64 };
        Choice { serves: each.iter().map(|(i, _)| *i).collect(), kept, mean }
    }
}

/// At most `most` candidates such that the mean over the frames of the cheapest is low. `costs` has a row a frame and a column a candidate. A
/// candidate is added only if it lowers the mean.
pub fn choose(costs: &[Vec<f64>], most: usize) -> Choice {
    let candidates = costs.first().map_or(0, Vec::len);
    let mut kept: Vec<usize> = Vec::new();
    let mut near = vec![f64::INFINITY; costs.len()];
    while kept.len() < most {
        let sum_with = |c: usize| costs.iter().zip(&near).map(|(row, near)| lesser(row[c], *near)).sum::<f64>();
        let others = (0..candidates).filter(|c| !kept.contains(c)).map(|c| (c, sum_with(c)));
        let Some((best, sum)) = others.reduce(|a, b| if b.1 < a.1 { b } else { a }) else { break };
        if !(sum < near.iter().sum()) {
            break;
        }
        kept.push(best);
        costs.iter().zip(&mut near).for_each(|(row, near)| *near = lesser(row[best], *near));
    }
    for _ in 0..MOST_SWAPS {
        match best_swap(costs, &kept, candidates) {
            Some((out, new)) => kept[out] = new,
            None => break,
        }
    }
    kept.sort_unstable();
    Choice::of(costs, kept)
}

/// The swap of a kept candidate, by its place, for another one that lowers the sum most.
fn best_swap(costs: &[Vec<f64>], kept: &[usize], candidates: usize) -> Option<(usize, usize)> {
    // Of each frame who serves it, at what cost, and what the next best would cost.
    let two_nearest = |row: &Vec<f64>| {
        let start = (usize::MAX, f64::INFINITY, f64::INFINITY);
        kept.iter().enumerate().fold(start, |(who, near, second), (i, &c)| match row[c] {
            cost if cost < near => (i, cost, near),
            cost => (who, near, lesser(cost, second)),
        })
    };
    let served: Vec<(usize, f64, f64)> = costs.iter().map(two_nearest).collect();
    let now: f64 = served.iter().map(|(_, near, _)| near).sum();
    let (mut best, mut least) = (None, now * (1.0 - 1e-12));
    for new in (0..candidates).filter(|c| !kept.contains(c)) {
        // What the sum becomes when the new one comes, and what going of each kept one adds to that.
        let mut with = 0.0;
        let mut without = vec![0.0; kept.len()];
        for (row, &(who, near, second)) in costs.iter().zip(&served) {
            let cost = lesser(row[new], near);
            with += cost;
            if let Some(added) = without.get_mut(who) {
                *added += lesser(row[new], second) - cost;
            }
        }
        for (out, added) in without.into_iter().enumerate() {
            if with + added < least {
                (best, least) = (Some((out, new)), with + added);
            }
        }
    }
    best
}

fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The best of all sets, by trying them.
    fn least_mean(costs: &[Vec<f64>], count: usize) -> f64 {
        let sets = (0..1usize << costs[0].len()).filter(|set| set.count_ones() as usize == count);
        let mean = |set: usize| Choice::of(costs, (0..costs[0].len()).filter(|c| set >> c & 1 == 1).collect()).mean;
        sets.map(mean).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn few_candidates_are_chosen_as_well_as_by_trying_all_sets() {
        let mut random = crate::random::Random::new(5);
        let mut equal = 0;
        for _ in 0..40 {
            let costs: Vec<Vec<f64>> = (0..12).map(|_| (0..8).map(|_| 1.0 + random.unit()).collect()).collect();
            for most in 1..=4 {
                let choice = choose(&costs, most);
                let least = least_mean(&costs, most);
                assert!(choice.kept.len() == most && choice.mean <= least * 1.05, "{choice:?}, {least} is possible");
                equal += usize::from(choice.mean <= least * (1.0 + 1e-12));
            }
        }
        assert!(equal >= 140, "{equal} of 160 are as good as can be");
    }

    #[test]
    fn groups_of_frames_get_a_candidate_each_and_no_candidate_is_kept_for_nothing() {
        // Candidate c is good in the frames of group c, and 3 is like 0.
        let group = |frame: usize| frame / 4;
        let cost = |f: usize, c: usize| if group(f) == c % 3 { 1.0 } else { 2.0 };
        let costs: Vec<Vec<f64>> = (0..12).map(|f| (0..4).map(|c| cost(f, c)).collect()).collect();
        for most in [3, 4, 100] {
            let choice = choose(&costs, most);
            assert_eq!((choice.kept.len(), choice.mean), (3, 1.0));
            assert!((0..12).all(|f| choice.kept[choice.serves[f]] % 3 == group(f)), "{choice:?}");
        }
        assert_eq!(choose(&costs, 0).kept, [0usize; 0]);
        assert_eq!(choose(&[], 3), Choice::default());
    }
}
