//! What `bvhc view` says about its pictures, as text and as JSON.

use crate::cli::failure::Entry;
use crate::cli::figures;
use crate::report::outline::OutlineNode;
use crate::report::picture::{DifferenceFigures, Figures, Scale, Spread};
use crate::trace::probe::Camera;
use serde::Serialize;

/// The one document of a run.
#[derive(Serialize)]
pub struct Document<'a> {
    pub schema: &'static str,
    pub exit_code: u8,
    /// One a file; one of two files that are compared.
    pub views: &'a [Entry<ViewReport>],
}

/// A picture, a page or an outline.
#[derive(Debug, Serialize)]
pub struct ViewReport {
    /// The picture or page that was written.
    pub output: Option<String>,
    pub picture: Option<PictureReport>,
    pub tree: Option<TreeReport>,
}

#[derive(Debug, Serialize)]
pub struct TreeReport {
    pub path: String,
    pub frame: Option<i32>,
    /// What the nodes hold: triangles below a `tree`, instances below a `top`.
    pub of: &'static str,
    pub nodes: Vec<OutlineNode>,
}

#[derive(Debug, Serialize)]
pub struct PictureReport {
    pub shade: &'static str,
    /// Pixels of one picture.
    pub width: usize,
    pub height: usize,
    /// Rays for each pixel, across and down.
    pub samples: u8,
    pub camera: CameraReport,
    /// What the brightest colour stands for; nothing where colours stand for no numbers.
    pub scale: Option<f64>,
    pub root: Option<u64>,
    pub boxes: Option<BoxesReport>,
    /// One, or two that are compared.
    pub files: Vec<PicturedFile>,
    pub difference: Option<DifferenceFigures>,
}

#[derive(Debug, Serialize)]
pub struct CameraReport {
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    /// Degrees across the longer side.
    angle: f64,
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct BoxesReport {
    pub level: u32,
    /// How many were drawn, of the first file.
    pub count: u64,
}

#[derive(Debug, Serialize)]
pub struct PicturedFile {
    pub path: String,
    pub frame: Option<i32>,
    #[serde(flatten)]
    pub figures: Figures,
}

impl From<&Camera> for CameraReport {
    fn from(camera: &Camera) -> CameraReport {
        let angle = 2.0 * camera.tan_half.atan().to_degrees();
        CameraReport { eye: camera.eye, target: camera.look_at, up: camera.up, angle }
    }
}

impl PictureReport {
    /// What was pictured, a line a file, and the difference.
    pub fn text(&self, names: &[String]) -> String {
        let mut text = String::new();
        for (file, name) in self.files.iter().zip(names) {
            let f = &file.figures;
            let hits = 100.0 * f.hits as f64 / f.rays.max(1) as f64;
            text.push_str(&format!("{name}: {}, {hits:.1} % hit\n", figures::counted(f.rays, "ray", "rays")));
            for (what, spread) in [("inner nodes visited", f.visits), ("triangles tested", f.tests)] {
                text.push_str(&format!("  {what}: {}\n", told(&spread)));
            }
        }
        if let Some(d) = &self.difference {
            let ratio = d.ratio.map_or_else(String::new, |r| format!("{:+.1} %; ", 100.0 * (r - 1.0)));
            let [fewer, equal, more] = [d.fewer, d.equal, d.more].map(figures::count);
            text.push_str(&format!(
                "difference: {ratio}less in {fewer} pixels, the same in {equal}, more in {more}; {:+.1} to {:+.1}\n",
                d.least, d.most
            ));
            if d.other_hits > 0 {
                let pixels = figures::counted(d.other_hits, "pixel shows", "pixels show");
                text.push_str(&format!("  {pixels} another surface: the files are not of one model\n"));
            }
        }
        text
    }
}

fn told(spread: &Spread) -> String {
    format!("{:.2} a ray, {:.0} in 99 of 100, {:.0} at most", spread.mean, spread.p99, spread.most)
}

/// What the letters or colours of a terminal mean.
pub fn legend(scale: &Scale) -> String {
    let start = if scale.signed { -scale.most } else { 0.0 };
    format!("dark {start} to bright {} and more: {}\n", scale.most, scale.title)
}
