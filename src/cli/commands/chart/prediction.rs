//! The picture of what predicts the time that rays take.

use super::document::predictions_of;
use super::measure::Charted;
use super::sections::table_of;
use super::{ChartArgs, commands};
use crate::cli::names;
use crate::report::chart::page::{Cell, Section};
use crate::report::chart::{Axis, Chart, Panel, Point, Series};
use crate::report::tradeoff::{PREDICTORS, Prediction, TradeOff};

/// What `auto` and `best` decide by, among the predictors.
const RULE: &str = "ray cost";
/// What stands in pictures; the table has the others too.
const SHOWN: [&str; 3] = ["SAH", "SAH + EPO", RULE];

/// A panel a predictor, with a point for each tree of each model; nothing where no model has two.
pub fn section(charted: &[Charted], args: &ChartArgs) -> Option<Section> {
    let predictions = predictions_of(charted);
    let rule = predictions.iter().find(|prediction| prediction.predictor == RULE)?;
    let best = predictions.iter().max_by(|a, b| a.correlation.total_cmp(&b.correlation))?;
    let models: Vec<(String, &TradeOff)> = charted.iter().filter_map(model).collect();
    let panels = SHOWN.iter().map(|shown| panel(shown, &models)).collect();
    let columns =
        [("figure of the tree", Cell::Name), ("rank correlation with time", Cell::Number), ("trees", Cell::Number)];
    let cells = |p: &Prediction| vec![p.predictor.to_string(), format!("{:+.3}", p.correlation), p.trees.to_string()];
    let table = table_of(&columns, predictions.iter().map(cells).collect());
    let mut notes = vec![
        "Spearman's rank correlation over all trees, ranks counted within each model: 1 where the figure puts trees in the order of the time that rays take, measured on one thread.".to_string(),
    ];
    notes.push(if best.predictor == RULE {
        format!(
            "auto and best decide by counted rays, {:+.3} here: no other figure predicts time better.",
            rule.correlation
        )
    } else {
        format!(
            "auto and best decide by counted rays, {:+.3} here; by these trees {} predicts time better, {:+.3}.",
            rule.correlation, best.predictor, best.correlation
        )
    });
    let chart = Chart { panels, columns: 2, ..Chart::default() };
    let title = "What predicts the time of a ray".to_string();
    Some(Section { title, chart, table, notes, command: commands(args), ..Section::default() })
}

fn model(charted: &Charted) -> Option<(String, &TradeOff)> {
    match charted {
        Charted::Model(model) if model.recipes.recipes.len() > 1 => Some((names::file(&model.path), &model.recipes)),
        _ => None,
    }
}

/// Both quantities over the least of the model.
fn panel(shown: &str, models: &[(String, &TradeOff)]) -> Panel {
    let across = Axis::close(format!("{shown} over the least")).lower_is_better();
    let mut panel = Panel::new(shown, across, Axis::close("time of rays over the least").lower_is_better());
    let Some(predictor) = PREDICTORS.iter().find(|predictor| predictor.name == shown) else { return panel };
    for (colour, (name, model)) in models.iter().enumerate() {
        let both: Vec<[f64; 2]> = model.recipes.iter().map(|row| [predictor.of(row), row.trace_seconds]).collect();
        let least = [0, 1].map(|i| both.iter().map(|pair| pair[i]).fold(f64::INFINITY, f64::min));
        let points = both.iter().map(|[x, y]| Point::new(x / least[0], y / least[1])).collect();
        panel = panel.with(Series::new(name.clone(), colour, points));
    }
    panel
}
