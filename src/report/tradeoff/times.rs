//! Rounds on a clock, summed up; and what they cannot tell apart.

use serde::Serialize;

/// How long one build takes, by several rounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Times {
    /// How often it was built.
    pub rounds: u32,
    /// The middle one of the rounds; of two middle ones their mean.
    pub median_seconds: f64,
    /// A quarter of the rounds took no longer.
    pub lower_seconds: f64,
    /// A quarter of the rounds took no less.
    pub upper_seconds: f64,
    /// The shortest.
    pub least_seconds: f64,
    /// The longest.
    pub most_seconds: f64,
}

/// Fewest rounds with a spread that says something.
const LEAST_ROUNDS: u32 = 3;

impl Times {
    /// Of the rounds in any order, in seconds.
    pub fn of(rounds: &[f64]) -> Times {
        let mut sorted = rounds.to_vec();
        sorted.sort_by(f64::total_cmp);
        // Between two rounds by their distance (R. J. Hyndman and Y. Fan, "Sample Quantiles in Statistical Packages", 1996, definition 7).
        let quantile = |share: f64| {
            let place = share * sorted.len().saturating_sub(1) as f64;
            let below = sorted.get(place as usize).copied().unwrap_or_default();
            let above = sorted.get(place.ceil() as usize).copied().unwrap_or_default();
            below + (above - below) * place.fract()
        };
        Times {
            rounds: sorted.len() as u32,
            median_seconds: quantile(0.5),
            lower_seconds: quantile(0.25),
            upper_seconds: quantile(0.75),
            least_seconds: quantile(0.0),
            most_seconds: quantile(1.0),
        }
    }

    /// Whether there are rounds enough to tell it from others.
    pub fn has_spread(&self) -> bool {
        self.rounds >= LEAST_ROUNDS
    }
}

/// Groups, as large as can be, of which every two have middle halves of their rounds that overlap: the clock does not tell which is quicker. Times of
/// too few rounds are in no group. Ascending by their first members.
pub fn indistinct(times: &[Times]) -> Vec<Vec<usize>> {
    let holds = |t: &Times, at: f64| t.has_spread() && t.lower_seconds <= at && at <= t.upper_seconds;
    // Intervals that all overlap each other have a point in common: the largest of their lower ends.
    let all = times.iter().filter(|t| t.has_spread()).map(|t| t.lower_seconds);
    let mut groups: Vec<Vec<usize>> =
        all.map(|at| (0..times.len()).filter(|i| holds(&times[*i], at)).collect()).collect();
    groups.sort();
    groups.dedup();
    let within = |small: &Vec<usize>, large: &Vec<usize>| small.iter().all(|i| large.contains(i));
    let is_largest = |group: &Vec<usize>| !groups.iter().any(|other| other != group && within(group, other));
    groups.iter().filter(|group| group.len() > 1 && is_largest(group)).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_lie_between_rounds() {
        let times = Times::of(&[4.0, 1.0, 3.0, 2.0, 10.0]);
        assert_eq!((times.rounds, times.least_seconds, times.most_seconds), (5, 1.0, 10.0));
        assert_eq!((times.lower_seconds, times.median_seconds, times.upper_seconds), (2.0, 3.0, 4.0));
        let even = Times::of(&[1.0, 2.0, 3.0, 4.0]);
        assert_eq!((even.lower_seconds, even.median_seconds, even.upper_seconds), (1.75, 2.5, 3.25));
        assert_eq!(Times::of(&[]), Times::default());
        assert_eq!(Times::of(&[7.0]).upper_seconds, 7.0);
    }

    #[test]
    fn groups_are_as_large_as_can_be() {
        let of = |ends: &[[f64; 2]]| {
            let time = |[lower, upper]: &[f64; 2]| Times {
                rounds: 3,
                lower_seconds: *lower,
                upper_seconds: *upper,
                ..Times::default()
            };
            indistinct(&ends.iter().map(time).collect::<Vec<_>>())
        };
        assert_eq!(of(&[[1.0, 2.0], [3.0, 4.0]]), Vec::<Vec<usize>>::new());
        // The middle one reaches into both others, which are apart.
        assert_eq!(of(&[[1.0, 2.0], [1.5, 3.5], [3.0, 4.0]]), [vec![0, 1], vec![1, 2]]);
        assert_eq!(of(&[[1.0, 9.0], [2.0, 3.0], [2.5, 4.0], [7.0, 8.0]]), [vec![0, 1, 2], vec![0, 3]]);
        // Two rounds have no spread.
        let few = Times { rounds: 2, upper_seconds: 9.0, ..Times::default() };
        assert!(indistinct(&[few, few]).is_empty());
    }
}
