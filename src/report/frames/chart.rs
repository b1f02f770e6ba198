//! What rays cost from frame to frame, and what each frame adds to the file.

use super::{FrameReport, SequenceReport};
use crate::report::chart::{Axis, Chart, Marker, Panel, Point, Series};

/// Most frames that have a marker each; of more only those that begin something have one.
const MARKED: usize = 48;

/// Two panels a file: ray cost, or SAH where no rays were traced, and bytes. Frames that show other trees than the one before are marked, and those for which
/// a tree was built.
pub fn chart(reports: &[SequenceReport]) -> Chart {
    let mut chart = Chart {
        columns: 2,
        markers: vec![
            (Marker::Square, "a tree was built for the frame".into()),
            (Marker::Triangle, "other trees than in the frame before".into()),
        ],
        ..Chart::default()
    };
    for report in reports {
        let frame = || Axis::linear("frame");
        let has_rays = report.frames.iter().any(|f| f.ray_cost.is_some());
        let name = if has_rays { "ray cost" } else { "SAH" };
        let cost = |f: &FrameReport| if has_rays { f.ray_cost } else { Some(f.sah) };
        let mut costs = Panel::new(report.path.clone(), frame(), Axis::linear(name).lower_is_better());
        costs = costs.with(series(report, "as stored", 0, cost));
        if report.frames.iter().any(|f| f.fresh_ray_cost.is_some()) {
            costs = costs.with(series(report, "built for the frame", 1, |f| f.fresh_ray_cost));
        }
        let kilobytes = |f: &FrameReport| Some(f.bytes as f64 / 1024.0);
        let bytes = Panel::new("", frame(), Axis::linear("KiB added to the file").lower_is_better());
        chart.panels.extend([costs, bytes.with(series(report, "bytes", 4, kilobytes))]);
    }
    chart
}

fn series(report: &SequenceReport, name: &str, colour: usize, value: impl Fn(&FrameReport) -> Option<f64>) -> Series {
    let plain = if report.frames.len() > MARKED { Marker::None } else { Marker::Disc };
    let mut segment = report.frames.first().map_or(0, |frame| frame.segment);
    let point = |(number, frame): (usize, &FrameReport)| {
        let begins = std::mem::replace(&mut segment, frame.segment) != frame.segment;
        let marker = match (frame.built > 0, begins) {
            (true, _) => Marker::Square,
            (false, true) => Marker::Triangle,
            (false, false) => plain,
        };
        Some(Point::new(frame.number.into(), value(frame)?).marked(marker).of_row(number))
    };
    Series::new(name, colour, report.frames.iter().enumerate().filter_map(point).collect()).connected()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: i32, built: u64, segment: u64) -> FrameReport {
        FrameReport {
            number,
            time: None,
            held: false,
            instances: 1,
            instanced_triangles: 9,
            trees: 1,
            built,
            segment,
            sah: 5.0,
            ratio: 1.0,
            ray_cost: Some(7.5),
            fresh_ray_cost: None,
            ray_ratio: None,
            bytes: 2048,
        }
    }

    #[test]
    fn what_begins_is_marked_however_many_frames_there_are() {
        for count in [10, 1000] {
            let frames = (0..count).map(|i| frame(i, u64::from(i == 0), u64::from(i >= 5))).collect();
            let report = SequenceReport { path: "a".into(), file_len: 1, topologies: 2, poses: 9, frames };
            let chart = chart(&[report]);
            let markers: Vec<Marker> = chart.panels[0].series[0].points.iter().map(|p| p.marker).collect();
            assert_eq!((markers[0], markers[5]), (Marker::Square, Marker::Triangle));
            let plain = if count == 10 { Marker::Disc } else { Marker::None };
            assert!(markers.iter().enumerate().all(|(i, m)| [0, 5].contains(&i) || *m == plain), "{markers:?}");
            assert_eq!(chart.panels[1].series[0].points[3].y, 2.0);
            assert!(chart.svg().unwrap().contains("ray cost"));
        }
    }
}
