//! Several files as one.

use super::{Errors, Report, Row};

impl Report {
    /// Errors add up, speeds and visits are geometric means over the files. `None` without files.
    pub fn of_all(reports: &[Report]) -> Option<Report> {
        let (first, rest) = reports.split_first()?;
        let mut all = first.clone();
        for report in rest {
            all.instanced_triangles += report.instanced_triangles;
            all.fair_rays += report.fair_rays;
            all.hard_rays += report.hard_rays;
            all.timed_rays += report.timed_rays;
            for (row, other) in all.rows.iter_mut().zip(&report.rows) {
                row.fair = row.fair.and(&other.fair);
                row.hard = row.hard.and(&other.hard);
                row.distance = std::mem::take(&mut row.distance).and(&other.distance);
                row.hard_distance = std::mem::take(&mut row.hard_distance).and(&other.hard_distance);
            }
        }
        for (i, row) in all.rows.iter_mut().enumerate() {
            let mean = |value: &dyn Fn(&Row) -> f64| {
                let logarithms = reports.iter().map(|r| value(&r.rows[i]).ln()).sum::<f64>();
                (logarithms / reports.len() as f64).exp()
            };
            row.mrays_per_second = mean(&|r| r.mrays_per_second);
            row.inner_nodes_per_ray = mean(&|r| r.inner_nodes_per_ray);
            row.triangles_per_ray = mean(&|r| r.triangles_per_ray);
        }
        Some(all)
    }
}

impl Errors {
    fn and(self, other: &Errors) -> Errors {
        Errors {
            rays: self.rays + other.rays,
            missed: self.missed + other.missed,
            farther: self.farther + other.farther,
            false_hits: self.false_hits + other.false_hits,
        }
    }
}
