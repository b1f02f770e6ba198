//! What the user is told of a model that does not arrive whole.

use crate::build::Levels;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::names;
use crate::compile::Placing;
use crate::scene::{Degenerate, Loss, ReadOptions, ReadReport, Rounding};
use serde::Serialize;
use std::path::Path;

/// A warning: what it is about, and a sentence without the model's name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Remark {
    pub kind: Kind,
    pub text: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Triangles without area, left out or kept: what `--degenerate` decides.
    WithoutArea,
    /// All else that reading left out.
    LeftOut,
    /// Clips of a model that stands at rest.
    AtRest,
    /// What reading had to decide where the model does not say or may not be followed.
    Decided,
    /// Rounding that takes a model's shape, or took it before.
    Rounding,
    /// Models or frames without triangles.
    Empty,
    /// Frames that a pattern does not take.
    Frames,
}

impl Kind {
    pub fn remark(self, text: impl Into<String>) -> Remark {
        Remark { kind: self, text: text.into() }
    }
}

/// Of a still file.
pub fn nothing_in_it() -> Remark {
    Kind::Empty.remark("there is no triangle in it")
}

/// What became of a model between its file and its trees.
pub struct Remarks<'a> {
    /// With the triangles that lost their area only where they were put.
    pub report: &'a ReadReport,
    pub read: &'a ReadOptions,
    pub rounding: &'a Rounding,
    pub placing: &'a Placing,
    /// Whether the clips of a model were left out on purpose.
    pub at_rest: bool,
}

impl Remarks<'_> {
    /// In the order in which they are told.
    pub fn warnings(&self, levels: Levels) -> Vec<Remark> {
        let left_out = self.others_left_out().map(|what| Kind::LeftOut.remark(format!("left out {what}")));
        let clips = self.report.unplayed_animations;
        let clips = (clips > 0 && !self.at_rest).then(|| {
            let text = counted(clips, "animation", " (everything stands at rest)");
            Kind::AtRest.remark(format!("left out {text}"))
        });
        let decided = self.decided().into_iter().map(|text| Kind::Decided.remark(text));
        let rounding = self.rounded(levels).into_iter().map(|text| Kind::Rounding.remark(text));
        let without_area = self.without_area().map(|what| {
            let done = if self.read.degenerate == Degenerate::Keep { "kept" } else { "left out" };
            Kind::WithoutArea.remark(format!("{done} {what}"))
        });
        without_area.into_iter().chain(left_out).chain(clips).chain(decided).chain(rounding).collect()
    }

    /// What rounding took of the model's shape.
    fn rounded(&self, levels: Levels) -> Vec<String> {
        let mut lines = Vec::new();
        let Rounding { loss, rounded_before, grid, .. } = self.rounding;
        if let Some(apart) = rounded_before {
            lines.push(format!(
                "it was rounded before it was written: its positions lie at least {} apart where it is, as 32-bit floats or decimals of few digits do, \
                 and the edges of its triangles are {} long; export it closer to the origin, or with more digits",
                figure(*apart),
                figure(loss.edge)
            ));
        }
        if !loss.is_tolerable() {
            lines.push(format!(
                "{}; export it closer to the origin, or split it into files of parts that lie near each other",
                lost("32-bit positions", "move", loss)
            ));
        }
        if let Some(loss) = grid.filter(|loss| !loss.is_tolerable()) {
            lines.push(format!("{}; choose more --vertex-bits", lost("positions on a grid", "move", &loss)));
        }
        let placed = &self.placing.loss;
        match levels {
            _ if placed.is_tolerable() => {}
            Levels::One => {
                lines.push(format!("{}; --levels auto keeps the shape", lost("one tree in the world", "moves", placed)))
            }
            _ => lines.push(format!("{}; export it closer to the origin", lost("32-bit matrices", "move", placed))),
        }
        lines
    }

    /// What reading had to decide where the model does not say or may not be followed, each as a sentence.
    fn decided(&self) -> Vec<String> {
        let report = self.report;
        let counted_ones = [
            (report.unposed_skins, "node", " with a skin but without joints or weights: placed without the skin"),
            (report.unknown_channels, "channel", " of the animation with an unknown path: not followed"),
            (report.uninstanced_skins, "skinned node", " with instances: placed once, by the joints"),
            (
                report.mirrored_skins,
                "skinned node",
                " mirrored by all joints: its triangles show their backs, as their corners are",
            ),
            (report.unweighted_vertices, "vertex without joint weights", ": placed by the first joint"),
            (report.absent_materials, "primitive", " with a material that is not there: left without one"),
            (
                report.twice_placed_nodes,
                "node",
                " with a matrix and with translation, rotation or scale: placed by the matrix",
            ),
            (
                report.ignored_weights,
                "vertex",
                " with a weight other than 1: placed without it, as weights are for curves",
            ),
        ];
        let found = counted_ones.iter().filter(|c| c.0 > 0).map(|(n, what, which)| counted(*n, what, which));
        let ignored = report.ignored_extensions.iter().map(|name| {
            let name = names::escape(name);
            format!("the glTF extension {name}, which may move or change triangles, is ignored")
        });
        found.chain(ignored).collect()
    }

    /// A model of which nothing is left.
    pub fn nothing(&self, model: &str) -> Failure {
        let mut failure = Failure::new(Exit::Model, format!("there is no triangle in {model}"));
        let without_area = self.without_area().filter(|_| self.read.degenerate != Degenerate::Keep);
        let left_out: Vec<String> = without_area.into_iter().chain(self.others_left_out()).collect();
        if !left_out.is_empty() {
            failure = failure.fact(format!("reading left out {}", left_out.join(", ")));
        }
        failure.help("a cache of nothing is written with --empty keep")
    }

    /// Triangles without area as a phrase, if there are any.
    fn without_area(&self) -> Option<String> {
        let count = self.report.degenerate_triangles;
        (count > 0).then(|| counted(count, "triangle", " without area"))
    }

    /// What else reading dropped, as a phrase, or `None` for a clean model.
    fn others_left_out(&self) -> Option<String> {
        let report = self.report;
        let largest = match report.largest_magnitude {
            infinite if infinite == f64::INFINITY => format!("more than {:.1e}", f64::MAX),
            largest => format!("{largest:.1e}"),
        };
        let beyond = format!(" beyond the range of f32 ({largest}; the limit is {:.1e})", f32::MAX);
        let reaching = format!(" with positions{beyond}");
        let first = report.first_unknown_statement.as_ref();
        let first = first.map(|s| format!(" (the first is '{}' in line {})", names::escape(&s.word), s.line));
        let first = first.unwrap_or_default();
        let found: Vec<String> = [
            (report.non_finite_triangles, "triangle", " with NaN or infinite positions"),
            (report.out_of_range_triangles, "triangle", &reaching),
            (report.unknown_statements, "unknown statement", &first),
            (report.skipped_primitives - report.short_faces, "line and point primitive", ""),
            (report.short_faces, "face", " of fewer than three corners"),
            (report.singular_instances, "instance", " scaled to nothing"),
            (report.out_of_range_instances, "instance", &beyond),
            (report.hidden_nodes, "hidden node", ""),
            (report.unapplied_morph_weights, "morph weight", " without a target"),
        ]
        .into_iter()
        .filter(|(n, ..)| *n > 0)
        .map(|(n, what, which)| counted(n, what, which))
        .collect();
        (!found.is_empty()).then(|| found.join(", "))
    }
}

/// How many frames of a file have no triangle, if any, as the build told it.
pub fn empty_frames(path: &Path, context: &Context) -> Result<Option<Remark>, Failure> {
    let sequence = caches::open_sequence(path, context)?;
    let mut empty = 0;
    for index in 0..sequence.frame_count() {
        let frame = sequence.frame_on(index, &context.exec).map_err(|e| caches::failure(&e))?;
        empty += u64::from(frame.view().instances.is_empty());
    }
    Ok(nothing_in(empty))
}

/// What a build tells of so many frames without triangles.
pub fn nothing_in(frames: u64) -> Option<Remark> {
    let text = || format!("there is no triangle in {}", figures::counted(frames, "frame", "frames"));
    (frames > 0).then(|| Kind::Empty.remark(text()))
}

/// The failure where warnings are errors.
pub fn with_warnings(model: &str, told: &[Remark]) -> Failure {
    let failure = Failure::new(Exit::Model, format!("cannot take {model} without warnings"));
    let failure = told.iter().fold(failure, |failure, remark| failure.fact(remark.text.clone()));
    let is_about = |kind| told.iter().any(|remark| remark.kind == kind);
    failure.help(if is_about(Kind::WithoutArea) {
        "mend the model, or say that triangles without area are left out: --degenerate drop"
    } else if is_about(Kind::AtRest) {
        "choose a clip with --clip, or say that the model is meant at rest: --at-rest"
    } else {
        "mend what is told, or leave out --warnings-as-errors"
    })
}

/// `3 triangles without area`, `1 vertex without weights`.
fn counted(n: u64, what: &str, which: &str) -> String {
    let many = what.strip_prefix("vertex").map_or(format!("{what}s"), |rest| format!("vertices{rest}"));
    format!("{}{which}", figures::counted(n, what, &many))
}

fn lost(by: &str, moves: &str, loss: &Loss) -> String {
    let Loss { farthest, edge, share, gone } = *loss;
    if share <= Loss::MOST {
        return format!(
            "small parts of it lose their shape: {by} {moves} corners by up to {}, which leaves nothing of {} of its triangles",
            figure(farthest),
            percent(gone)
        );
    }
    format!(
        "it loses its shape: {by} {moves} its corners by up to {}, and the edges of its triangles are {} long ({:.0}% of one on average)",
        figure(farthest),
        figure(edge),
        100.0 * share
    )
}

/// A share that is not zero.
fn percent(share: f64) -> String {
    if share < 0.001 { "less than 0.1%".into() } else { format!("{:.1}%", 100.0 * share) }
}

/// Three digits.
fn figure(v: f64) -> String {
    let digits = if v > 0.0 { (2 - v.log10().floor() as i32).clamp(0, 12) as usize } else { 0 };
    if (1e-9..1e9).contains(&v) { format!("{v:.digits$}") } else { format!("{v:.2e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_three_digits() {
        for (v, text) in [
            (0.5, "0.500"),
            (0.0069, "0.00690"),
            (12.345, "12.3"),
            (48_000.0, "48000"),
            (1e-20, "1.00e-20"),
            (0.0, "0.00e0"),
        ] {
            assert_eq!(figure(v), text);
        }
    }

    #[test]
    fn what_is_lost_is_told_with_its_size_and_a_way_out() {
        let (report, read, rounding) = (ReadReport::default(), ReadOptions::default(), Rounding::default());
        let loss = Loss { farthest: 0.2, edge: 0.1, share: 0.9, gone: 0.0 };
        let placing = Placing { loss, ..Placing::default() };
        let remarks = Remarks { report: &report, read: &read, rounding: &rounding, placing: &placing, at_rest: false };
        let said = remarks.warnings(Levels::One);
        assert!(
            matches!(&said[..], [Remark { kind: Kind::Rounding, text }] if text.contains("0.200") && text.contains("0.100 long (90%") && text.contains("--levels auto")),
            "{said:?}"
        );
        assert!(remarks.warnings(Levels::Two)[0].text.contains("closer to the origin"));
        let rounding = Rounding { loss, rounded_before: Some(0.5), grid: Some(loss), ..Rounding::default() };
        let remarks = Remarks { rounding: &rounding, placing: &Placing::default(), ..remarks };
        let said: Vec<String> = remarks.warnings(Levels::Auto).into_iter().map(|remark| remark.text).collect();
        assert!(
            matches!(&said[..], [before, now, grid] if before.contains("0.500 apart") && now.contains("split it") && grid.contains("more --vertex-bits")),
            "{said:?}"
        );
    }

    #[test]
    fn what_the_policy_keeps_is_not_left_out() {
        let report = ReadReport { degenerate_triangles: 2, non_finite_triangles: 1, ..ReadReport::default() };
        let (rounding, placing) = (Rounding::default(), Placing::default());
        let said = |degenerate| {
            let read = ReadOptions { degenerate, ..ReadOptions::default() };
            Remarks { report: &report, read: &read, rounding: &rounding, placing: &placing, at_rest: false }
                .warnings(Levels::Auto)
        };
        assert_eq!(
            said(Degenerate::Drop),
            [
                Kind::WithoutArea.remark("left out 2 triangles without area"),
                Kind::LeftOut.remark("left out 1 triangle with NaN or infinite positions")
            ]
        );
        assert_eq!(
            said(Degenerate::Keep),
            [
                Kind::WithoutArea.remark("kept 2 triangles without area"),
                Kind::LeftOut.remark("left out 1 triangle with NaN or infinite positions")
            ]
        );
    }

    #[test]
    fn the_policy_is_named_for_triangles_without_area_and_for_no_words_about_them() {
        let help = |remark: Remark| with_warnings("a.obj", &[remark]).help.unwrap();
        assert!(help(Kind::WithoutArea.remark("2 of them")).contains("--degenerate drop"));
        let named = Kind::LeftOut.remark("left out 1 unknown statement (the first is 'without area' in line 1)");
        assert!(!help(named).contains("--degenerate"));
    }
}
