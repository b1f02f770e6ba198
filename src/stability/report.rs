//! Every recipe on a scene, in two sizes, and what that comes to.

use super::effort::Effort;
use super::gates::{AUTO_MARGIN, GROWTH, Kept, POOR, asks_rays, gates, ratio, reason, time_growth};
use super::judge::{Judge, JudgeError, Row};
use super::recipes::{AUTO, recipes};
use super::scenes::Failure;
use crate::exec::Executor;
use crate::search::LEAST_TRIANGLES;
use serde::Serialize;

/// So many times the triangles in the larger size tell how time and memory grow.
const LEAST_GROWN: f64 = 2.0;

/// A recipe in both sizes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Grown {
    /// In the smaller size.
    pub small: Row,
    /// In the larger size.
    pub large: Row,
    /// What a ray costs in the larger size over what it costs by the cheapest recipe.
    pub over: f64,
    /// Build time in the larger size over that in the smaller one; 0 where no clock was asked.
    pub time_growth: f64,
    /// Bytes that the build held, likewise; 0 where nobody counted.
    pub memory_growth: f64,
    /// Why it does badly, where it costs more than one and a half times the cheapest.
    pub poor: Option<&'static str>,
}

/// A scene by every recipe.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneReport {
    /// As [`Failure::id`].
    pub id: &'static str,
    /// As [`Failure::name`].
    pub name: &'static str,
    /// As [`Failure::breaks`].
    pub breaks: &'static str,
    /// A row a recipe, in the order of [`recipes`].
    pub recipes: Vec<Grown>,
    /// What the scene is held to beside the rest, and what came of it.
    pub promises: Vec<Kept>,
}

impl SceneReport {
    /// By every recipe, or as many as there is time for: `goes_on` is asked before each. `None` where not all were.
    ///
    /// # Errors
    /// Where a recipe cannot build the scene.
    pub fn of(
        failure: &Failure,
        effort: &Effort,
        exec: &Executor,
        mut goes_on: impl FnMut(&str) -> bool,
    ) -> Result<Option<SceneReport>, JudgeError> {
        let scenes = effort.sizes.map(|size| failure.scene(size));
        let [mut small, mut large] = [0, 1].map(|i| Judge::new(&scenes[i], effort, exec));
        let mut rows = Vec::new();
        for recipe in recipes() {
            if !goes_on(recipe.name) {
                return Ok(None);
            }
            rows.push((small.row(&recipe)?, large.row(&recipe)?));
        }
        let least = rows.iter().map(|(_, large)| large.cost).fold(f64::INFINITY, f64::min);
        let last: Vec<Row> = rows.iter().map(|(_, large)| large.clone()).collect();
        let promises = gates(failure.id).filter_map(|gate| gate.asked(&last)).collect();
        let grown = |(small, large): (Row, Row)| {
            let over = ratio(large.cost, least);
            let growth = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
            Grown {
                over,
                time_growth: growth(large.seconds, small.seconds),
                memory_growth: growth(large.peak_bytes as f64, small.peak_bytes as f64),
                poor: (over > POOR).then(|| reason(large.recipe, failure.breaks)),
                small,
                large,
            }
        };
        let Failure { id, name, breaks, .. } = *failure;
        Ok(Some(SceneReport { id, name, breaks, recipes: rows.into_iter().map(grown).collect(), promises }))
    }

    /// Triangles in both sizes.
    pub fn triangles(&self) -> [u64; 2] {
        self.recipes.first().map_or([0; 2], |row| [row.small.triangles, row.large.triangles])
    }

    /// The recipe whose rays cost least in the larger size.
    pub fn cheapest(&self) -> Option<&Grown> {
        self.recipes.iter().min_by(|a, b| a.large.cost.total_cmp(&b.large.cost))
    }

    /// What the default search came to.
    pub fn auto(&self) -> Option<&Grown> {
        self.recipes.iter().find(|row| row.large.recipe == AUTO)
    }

    /// The most of a figure over the recipes.
    pub fn most(&self, of: impl Fn(&Grown) -> f64) -> f64 {
        self.recipes.iter().map(of).fold(0.0, f64::max)
    }

    /// What is broken, a sentence each.
    pub fn broken(&self) -> Vec<String> {
        let mut broken = Vec::new();
        let [small, large] = self.triangles();
        let grown = ratio(large as f64, small as f64);
        for row in &self.recipes {
            let name = row.large.recipe;
            // In fewer triangles nothing is searched: there the two sizes are two methods.
            let is_one_method = !asks_rays(name) || row.small.triangles >= LEAST_TRIANGLES as u64;
            let both =
                [&row.small, &row.large].into_iter().filter_map(|row| Some(format!("{name}: {}", row.broken()?)));
            broken.extend(both);
            for (what, growth, most) in
                [("time", row.time_growth, time_growth(name, grown)), ("memory", row.memory_growth, GROWTH[1])]
            {
                // A scene of few triangles in any size has nothing to grow by.
                if grown >= LEAST_GROWN && is_one_method && growth > most * grown {
                    broken.push(format!("{name}: {growth:.1} times the {what} for {grown:.1} times the triangles"));
                }
            }
        }
        broken.extend(
            self.promises.iter().filter(|kept| !kept.holds).map(|kept| format!("{}: {:.2}", kept.promise, kept.value)),
        );
        if let Some(auto) = self.auto().filter(|auto| auto.over > AUTO_MARGIN) {
            broken.push(format!("auto costs {:.2} times the cheapest, above {AUTO_MARGIN}", auto.over));
        }
        broken
    }
}
