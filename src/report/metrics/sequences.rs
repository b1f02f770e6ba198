//! The figures of a sequence by name, so that two can be compared.

use super::{Measured, Metric};
use crate::report::frames::{FrameReport, SequenceReport};

impl Measured for SequenceReport {
    fn metrics() -> &'static [Metric<SequenceReport>] {
        &METRICS
    }
}

static METRICS: [Metric<SequenceReport>; 12] = [
    Metric { name: "frames", about: "frames", value: |r| Some(r.frames.len() as f64) },
    Metric {
        name: "instanced-triangles",
        about: "triangles of the frame that has the most, those of every instance counted",
        value: |r| Some(r.triangles() as f64),
    },
    Metric { name: "topologies", about: "trees with different topologies", value: |r| Some(r.topologies as f64) },
    Metric { name: "poses", about: "different poses of them", value: |r| Some(r.poses as f64) },
    Metric {
        name: "segments",
        about: "runs of frames that show the same topologies",
        value: |r| Some(r.frames.last().map_or(0.0, |frame| frame.segment as f64 + 1.0)),
    },
    Metric {
        name: "sah",
        about: "surface area heuristic, the mean over the frames",
        value: |r| mean(r, |f| Some(f.sah)),
    },
    Metric { name: "sah-worst", about: "that of the frame where it is highest", value: |r| worst(r, |f| Some(f.sah)) },
    Metric {
        name: "ratio",
        about: "SAH / that of the frame where the same trees cost least, the mean over the frames",
        value: |r| mean(r, |f| Some(f.ratio)),
    },
    Metric {
        name: "ratio-worst",
        about: "that of the frame where it is highest",
        value: |r| worst(r, |f| Some(f.ratio)),
    },
    Metric { name: "file-bytes", about: "bytes of the file", value: |r| Some(r.file_len as f64) },
    Metric {
        name: "ray-cost",
        about: "1.2 x visits + tests, the mean over the frames",
        value: |r| mean(r, |f| f.ray_cost),
    },
    Metric {
        name: "ray-cost-worst",
        about: "that of the frame where it is highest",
        value: |r| worst(r, |f| f.ray_cost),
    },
];

impl SequenceReport {
    /// Triangles of the frame that has the most.
    pub fn triangles(&self) -> u64 {
        self.frames.iter().map(|frame| frame.instanced_triangles).max().unwrap_or(0)
    }
}

/// Nothing where it was not measured.
fn mean(report: &SequenceReport, value: impl Fn(&FrameReport) -> Option<f64>) -> Option<f64> {
    let all: Option<Vec<f64>> = report.frames.iter().map(value).collect();
    all.filter(|all| !all.is_empty()).map(|all| all.iter().sum::<f64>() / all.len() as f64)
}

fn worst(report: &SequenceReport, value: impl Fn(&FrameReport) -> Option<f64>) -> Option<f64> {
    let all: Option<Vec<f64>> = report.frames.iter().map(value).collect();
    all?.into_iter().reduce(f64::max)
}
