//! Which tree is taken, of several that were asked the same.
//!
//! A *regret* is by how much of its cost a family of rays pays more than in the best tree for it that was tried. The tree with the least worst
//! regret is taken, and of those that are alike in it, the one with the least mean: so no family pays for what others gain.

use super::gauge::Measure;
use crate::trace::probe::{FAMILIES, Family};

/// What a family may pay more after adaptation than before, its standard error included.
const HARM: f64 = 0.01;
/// By how much the SAH may rise if rays gain less than that on average.
const SAH_RISE: f64 = 0.03;

/// What a tree's rays pay beyond the best tree for each family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Regret {
    /// The largest of all families.
    pub worst: f64,
    /// Whose it is; none where there are no rays and the SAH decides.
    pub family: Option<Family>,
    /// The mean over the families.
    pub mean: f64,
}

/// What each tree costs by family, NaN where there are no rays, and as a mean or by its SAH.
pub type Costs = ([f64; FAMILIES], f64);

/// By tree.
pub fn regrets(trees: &[Costs]) -> Vec<Regret> {
    let least = |of: &dyn Fn(&Costs) -> f64| trees.iter().map(of).fold(f64::INFINITY, f64::min);
    let over = |cost: f64, least: f64| if least > 0.0 { cost / least - 1.0 } else { 0.0 };
    let best = Family::ALL.map(|family| least(&|tree| tree.0[family as usize]));
    let alone = least(&|tree| tree.1);
    let of = |(families, mean): &Costs| {
        let regrets = Family::ALL.into_iter().filter(|family| families[*family as usize].is_finite());
        let regrets: Vec<(f64, Family)> =
            regrets.map(|family| (over(families[family as usize], best[family as usize]), family)).collect();
        let Some(&(worst, family)) = regrets.iter().max_by(|a, b| a.0.total_cmp(&b.0)) else {
            let regret = over(*mean, alone);
            return Regret { worst: regret, family: None, mean: regret };
        };
        let sum: f64 = regrets.iter().map(|(regret, _)| regret).sum();
        Regret { worst, family: Some(family), mean: sum / regrets.len() as f64 }
    };
    trees.iter().map(of).collect()
}

/// Regrets that differ by no more are alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alike {
    pub worst: f64,
    pub mean: f64,
}

/// The tree to take: of those whose worst regret is the least or like it, the first whose mean is the least of theirs or like that.
pub fn preferred(regrets: &[Regret], alike: Alike) -> usize {
    let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
    let worst = least(&mut regrets.iter().map(|r| r.worst)) + alike.worst;
    let mean = least(&mut regrets.iter().filter(|r| r.worst <= worst).map(|r| r.mean)) + alike.mean;
    regrets.iter().position(|r| r.worst <= worst && r.mean <= mean).unwrap_or(0)
}

/// How sure it is that one tree is cheaper than another: the mean over the families of what it costs beyond it, and the standard error of that.
pub fn difference(tree: &Measure, other: &Measure) -> Option<(f64, f64)> {
    let (tree, other) = (tree.cost.as_ref()?, other.cost.as_ref()?);
    let families: Vec<(f64, f64)> = Family::ALL.into_iter().filter_map(|family| tree.beyond(other, family)).collect();
    let count = families.len() as f64;
    let squares: f64 = families.iter().map(|(_, error)| error * error).sum();
    (count > 0.0).then(|| (families.iter().map(|(over, _)| over).sum::<f64>() / count, squares.sqrt() / count))
}

/// Why adaptation is not taken, if it is not: what a family would pay, or the SAH.
pub fn harm(before: &Measure, after: &Measure) -> Option<String> {
    if let (Some(was), Some(is)) = (&before.cost, &after.cost) {
        for family in Family::ALL {
            if let Some((over, error)) = is.beyond(was, family)
                && over + error > HARM
            {
                let [over, error] = [over, error].map(|share| share * 100.0);
                return Some(format!("{} rays would pay {over:+.1} ± {error:.1} %", family.name()));
            }
        }
    }
    let gain = difference(after, before).map_or(0.0, |(over, _)| -over);
    let rise = if before.sah > 0.0 { after.sah / before.sah - 1.0 } else { 0.0 };
    if gain <= 0.0 {
        return Some("rays would gain nothing".to_string());
    }
    (rise > SAH_RISE.max(gain))
        .then(|| format!("the SAH would rise by {:.1} %, and rays gain {:.1} %", rise * 100.0, gain * 100.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(costs: &[f64]) -> Costs {
        let mut families = [f64::NAN; FAMILIES];
        families[..costs.len()].copy_from_slice(costs);
        (families, costs.iter().sum::<f64>() / costs.len() as f64)
    }

    fn alike(by: f64) -> Alike {
        Alike { worst: by, mean: by }
    }

    #[test]
    fn no_family_pays_for_what_others_gain() {
        // The second is cheapest on average, and the first costs nobody much.
        let trees = [of(&[10.0, 10.0, 10.0]), of(&[8.9, 8.9, 11.6]), of(&[20.0, 20.0, 9.9])];
        let all = regrets(&trees);
        assert_eq!(preferred(&all, alike(0.01)), 0, "{all:?}");
        assert_eq!(all[1].family, Some(Family::ALL[2]));
        assert!((all[0].worst - (10.0 / 8.9 - 1.0)).abs() < 1e-12 && all[0].mean < all[0].worst);
    }

    #[test]
    fn trees_that_are_alike_in_the_worst_are_told_apart_by_the_mean_and_the_first_of_equals_is_taken() {
        let trees = [of(&[10.2, 10.5]), of(&[10.2, 10.0]), of(&[10.0, 10.2]), of(&[10.0, 10.21])];
        assert_eq!(preferred(&regrets(&trees), alike(0.0)), 1);
        assert_eq!(preferred(&regrets(&trees), alike(0.01)), 1);
        assert_eq!(preferred(&regrets(&trees), alike(0.05)), 0);
    }

    #[test]
    fn where_every_tree_has_some_regret_the_mean_decides_between_those_that_are_nearly_alike() {
        // The third is best for one family, and dear for the others.
        let trees = [of(&[10.0, 10.4, 10.9]), of(&[10.5, 10.5, 10.8]), of(&[12.0, 12.0, 10.0])];
        let all = regrets(&trees);
        assert_eq!((preferred(&all, alike(0.0)), preferred(&all, Alike { worst: 0.02, mean: 0.0 })), (1, 0), "{all:?}");
    }

    #[test]
    fn without_rays_the_sah_decides() {
        let trees = [([f64::NAN; FAMILIES], 4.0), ([f64::NAN; FAMILIES], 3.0)];
        let all = regrets(&trees);
        assert_eq!((preferred(&all, alike(0.01)), all[1].family), (1, None));
        let nothing = regrets(&[([f64::NAN; FAMILIES], 0.0)]);
        assert_eq!((preferred(&nothing, alike(0.0)), nothing[0].worst), (0, 0.0));
    }
}
