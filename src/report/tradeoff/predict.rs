//! How well figures of a tree predict the time that rays take in it: rank correlation over all trees that were measured.

use super::{Row, TradeOff};
use serde::Serialize;

/// A figure by which trees are ranked, lower being better.
pub struct Predictor {
    /// For people.
    pub name: &'static str,
    of: fn(&Row) -> f64,
}

/// The weight of the EPO in the mix with the SAH, as fitted over several scenes by T. Aila, T. Karras and S. Laine, "On Quality Metrics of Bounding Volume
/// Hierarchies", 2013.
pub const EPO_WEIGHT: f64 = 0.71;

/// All of them, in the order of tables.
pub const PREDICTORS: [Predictor; 5] = [
    Predictor { name: "SAH", of: |row| row.sah },
    Predictor { name: "EPO", of: |row| row.epo },
    Predictor { name: "SAH + EPO", of: |row| (1.0 - EPO_WEIGHT) * row.sah + EPO_WEIGHT * row.epo },
    Predictor { name: "leaf variability", of: |row| row.rays.mean(|set| set.leaf_variability) },
    Predictor { name: "ray cost", of: |row| row.rays.cost },
];

impl Predictor {
    /// What it says of a tree.
    pub fn of(&self, row: &Row) -> f64 {
        (self.of)(row)
    }
}

/// How well one of them predicts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Its name.
    pub predictor: &'static str,
    /// Spearman's rank correlation with the time that rays take, ranks counted within each model: 1 where the order is the same, 0 where one says nothing of
    /// the other.
    pub correlation: f64,
    /// Trees of all models.
    pub trees: u64,
}

/// All predictors over the trees of all models; none of them where no model has two trees.
pub fn predictions(models: &[&TradeOff]) -> Vec<Prediction> {
    let trees: u64 = models.iter().map(|model| model.recipes.len() as u64).filter(|trees| *trees > 1).sum();
    if trees == 0 {
        return Vec::new();
    }
    let of = |predictor: &Predictor| {
        let (mut told, mut measured) = (Vec::new(), Vec::new());
        for model in models.iter().filter(|model| model.recipes.len() > 1) {
            let ranked = |value: &dyn Fn(&Row) -> f64| {
                let values: Vec<f64> = model.recipes.iter().map(value).collect();
                // From 0 to 1, so that models of many trees weigh no more for each.
                let most = (values.len() - 1) as f64;
                ranks(&values).into_iter().map(move |rank| rank / most).collect::<Vec<f64>>()
            };
            told.extend(ranked(&|row| predictor.of(row)));
            measured.extend(ranked(&|row| row.trace_seconds));
        }
        Prediction { predictor: predictor.name, correlation: correlation(&told, &measured), trees }
    };
    PREDICTORS.iter().map(of).collect()
}

/// From 0 in ascending order; equal values share the mean of their ranks.
fn ranks(values: &[f64]) -> Vec<f64> {
    let below = |value: f64| values.iter().filter(|other| other.total_cmp(&value).is_lt()).count();
    let equal = |value: f64| values.iter().filter(|other| other.total_cmp(&value).is_eq()).count();
    values.iter().map(|value| below(*value) as f64 + (equal(*value) - 1) as f64 / 2.0).collect()
}

/// Of two lists of one length (Pearson); 0 where one of them does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |of: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| of(x - ma, y - mb)).sum::<f64>();
    let scale = (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt();
    if scale > 0.0 { sum(&|x, y| x * y) / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_of_equal_values_are_shared() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0]), [2.5, 0.0, 2.5, 1.0]);
        assert!(ranks(&[]).is_empty());
    }

    #[test]
    fn correlation_has_its_closed_forms() {
        let up = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(correlation(&up, &up), 1.0);
        assert_eq!(correlation(&up, &[3.0, 2.0, 1.0, 0.0]), -1.0);
        assert_eq!(correlation(&up, &[1.0; 4]), 0.0);
        // Spearman's formula, 1 - 6 Σ d² / (n (n² - 1)), for one exchange of neighbours.
        assert!((correlation(&up, &[1.0, 0.0, 2.0, 3.0]) - (1.0 - 6.0 * 2.0 / 60.0)).abs() < 1e-12);
    }
}
