//! How the boxes of a bottom-up build grow from level to level, beside the least that hold the same triangles.

use bvhc::build::oabb::{Clusters, cluster};
use bvhc::build::{BuildOptions, Executor, HullBasis, Method, NoProgress, Preset};
use bvhc::oriented::{Extremes, Moments, OrientedBox, fit, hull_facets, least};
use bvhc::scene::Mesh;

/// Most triangles of the clusters in each column; the last column is the cluster of all.
pub const COLUMNS: [usize; 4] = [8, 64, 512, usize::MAX];

/// What a build found.
pub struct Growth {
    /// Area of the cluster's box over that of the box fitted around its triangles, the mean over the clusters of up to so many triangles;
    /// nothing where there are none.
    pub means: [Option<f64>; 4],
    /// The same of the cluster of all.
    pub root: f64,
    /// Common boxes that were measured, for each triangle.
    pub measured: f64,
}

/// Build by the method `oabb`, and look at every cluster.
pub fn growth(mesh: &Mesh, basis: HullBasis, exec: &Executor) -> Growth {
    let options = BuildOptions { method: Method::Oabb, basis, ..BuildOptions::preset(Preset::Draft) };
    let clusters = cluster(mesh, &options, exec, &NoProgress).expect("nothing cancels, and there are few triangles");
    let (mut sums, mut counts) = ([0.0; 4], [0u32; 4]);
    let mut root = 1.0;
    for number in mesh.triangles.len()..clusters.count() {
        let (triangles, ratio) = over(mesh, &clusters, number);
        let column = COLUMNS.iter().position(|most| triangles <= *most).unwrap_or(COLUMNS.len() - 1);
        (sums[column], counts[column]) = (sums[column] + ratio, counts[column] + 1);
        root = ratio;
    }
    Growth {
        means: std::array::from_fn(|k| (counts[k] > 0).then(|| sums[k] / f64::from(counts[k]))),
        root,
        measured: clusters.measured as f64 / mesh.triangles.len() as f64,
    }
}

/// The triangles of a cluster, and its box over the one fitted around them.
fn over(mesh: &Mesh, clusters: &Clusters, number: usize) -> (usize, f64) {
    let triangles = clusters.triangles(number);
    let corners: Vec<[[f64; 3]; 3]> = (triangles.iter())
        .map(|t| mesh.triangles[*t as usize].map(|v| mesh.positions[v as usize].map(f64::from)))
        .collect();
    (triangles.len(), clusters.hull(number).half_area() / fitted(&corners).half_area())
}

/// The least box that is known: of the scene's axes, DiTO-14, the spread of the surface, and the hull's facets.
pub fn fitted(corners: &[[[f64; 3]; 3]]) -> OrientedBox {
    let points = corners.as_flattened();
    let surface = corners.iter().fold(Moments::default(), |sum, c| sum.plus(&Moments::of_triangle(c)));
    let plain = fit(points, Some(&surface)).expect("a triangle at least");
    let extremes = Extremes::of_points(points).expect("a triangle at least").points();
    let facets = least(hull_facets(&extremes), |basis| OrientedBox::in_basis(basis, &extremes));
    let facets = facets.and_then(|facets| OrientedBox::in_basis(facets.basis, points));
    facets.filter(|facets| facets.half_area() < plain.half_area()).unwrap_or(plain)
}
