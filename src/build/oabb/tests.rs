use super::*;
use crate::build::recipe::options::{HullBasis, Method, Preset};
use crate::build::{Executor, NoProgress};
use crate::oriented::{BoundingVolume, OrientedBox};
use crate::random::Random;

fn options(basis: HullBasis) -> BuildOptions {
    BuildOptions { method: Method::Oabb, basis, ..BuildOptions::preset(Preset::Draft) }
}

fn mesh_of(triangles: &[[[f64; 3]; 3]]) -> Mesh {
    Mesh {
        positions: triangles.iter().flatten().map(|p| p.map(|c| c as f32)).collect(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..Mesh::default()
    }
}

/// Small triangles in a cube, in all directions.
fn soup(count: usize) -> Mesh {
    let mut random = Random::new(17);
    let triangles: Vec<_> = (0..count)
        .map(|_| {
            let at = [0; 3].map(|_| random.unit());
            [0; 3].map(|_| at.map(|c| c + 0.02 * random.unit()))
        })
        .collect();
    mesh_of(&triangles)
}

/// Two long strips, each flat and in many triangles, that lie aslant and side by side.
fn slats(count: usize) -> Mesh {
    let mut triangles = Vec::new();
    for i in 0..count / 4 {
        let at = |step: usize, z: f64, wide: f64| {
            let x = (i + step) as f64;
            [x, x + wide, z + x]
        };
        for z in [0.0, 3.0] {
            triangles.push([at(0, z, 0.0), at(1, z, 0.0), at(0, z, 0.5)]);
            triangles.push([at(1, z, 0.0), at(1, z, 0.5), at(0, z, 0.5)]);
        }
    }
    mesh_of(&triangles)
}

fn found(mesh: &Mesh, options: &BuildOptions) -> Clusters {
    cluster(mesh, options, &Executor::sequential(), &NoProgress).unwrap()
}

fn corners(mesh: &Mesh, triangles: &[u32]) -> Vec<[f64; 3]> {
    let points = triangles.iter().flat_map(|t| mesh.triangles[*t as usize]);
    points.map(|v| mesh.positions[v as usize].map(f64::from)).collect()
}

#[test]
fn every_hull_holds_its_triangles_and_its_children_hold_them_all() {
    for (mesh, basis) in [(soup(500), HullBasis::Leaf), (soup(500), HullBasis::Fit), (slats(300), HullBasis::Fit)] {
        let clusters = found(&mesh, &options(basis));
        let count = mesh.triangles.len();
        assert_eq!(clusters.count(), 2 * count - 1);
        let mut parents = vec![0; clusters.count()];
        for number in 0..clusters.count() {
            let triangles = clusters.triangles(number);
            // The hull is as wide or wider in each of its directions.
            let (hull, points) = (clusters.hull(number), corners(&mesh, &triangles));
            let own = OrientedBox::in_basis(hull.basis, &points).unwrap();
            assert!((0..3).all(|k| hull.low[k] <= own.low[k] + 1e-12 && hull.high[k] >= own.high[k] - 1e-12));
            if let Some(children) = clusters.children(number) {
                assert!(children.iter().all(|child| *child < number));
                children.iter().for_each(|child| parents[*child] += 1);
                assert_eq!(
                    children.map(|child| clusters.triangles(child).len()).iter().sum::<usize>(),
                    triangles.len()
                );
            } else {
                assert_eq!(triangles.len(), 1);
            }
        }
        assert!(parents[..clusters.count() - 1].iter().all(|parents| *parents == 1));
        assert_eq!(clusters.triangles(clusters.count() - 1).len(), count);
    }
}

#[test]
fn a_fitted_hull_is_no_larger_than_the_one_along_a_partner() {
    let mesh = soup(700);
    let clusters = found(&mesh, &options(HullBasis::Fit));
    let mut smaller = 0;
    for number in 0..clusters.count() {
        let Some([a, b]) = clusters.children(number) else { continue };
        let plain = clusters.hull(a).merged(clusters.hull(b));
        assert!(clusters.hull(number).half_area() <= plain.half_area());
        smaller += usize::from(clusters.hull(number).half_area() < 0.999 * plain.half_area());
    }
    assert!(smaller > 300, "{smaller} of 699 were fitted");
}

#[test]
fn along_leaves_every_basis_is_that_of_a_triangle_below() {
    let mesh = soup(200);
    let clusters = found(&mesh, &options(HullBasis::Leaf));
    for number in 0..clusters.count() {
        let of_triangle = |t: &u32| OrientedBox::of_triangle(&corners(&mesh, &[*t]).try_into().unwrap()).basis;
        let own = clusters.hull(number).basis;
        assert!(clusters.triangles(number).iter().any(|t| of_triangle(t) == own), "cluster {number}");
    }
}

#[test]
fn work_grows_as_triangles_do() {
    // Pairs measured, a triangle and a neighbour: counts, so the same on every machine.
    let each = |count: usize, basis| {
        let options = options(basis);
        found(&soup(count), &options).measured as f64 / (count as f64 * f64::from(options.radius))
    };
    for basis in [HullBasis::Leaf, HullBasis::Fit] {
        let [small, middle, large] = [80, 4000, 64_000].map(|count| each(count, basis));
        println!("{basis}: {small:.2}, {middle:.2}, {large:.2}");
        assert!(small < 8.0 && middle < 8.0 && large < 8.0, "{small} {middle} {large}");
        assert!(large < 1.15 * middle, "{middle} {large}");
    }
}

#[test]
fn ties_merge_by_halves_and_rows_that_grow_end() {
    let one = [[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 4.0, 5.0]];
    let growing = |i: i32| {
        let r = 1.01f64.powi(i);
        [[r, 0.0, 0.0], [r, r, 0.1 * r], [2.0 * r, 0.0, r]]
    };
    for (triangles, most) in [(vec![one; 4096], 2.1), ((0..4096).map(growing).collect(), 12.0)] {
        let options = options(HullBasis::Leaf);
        let each = found(&mesh_of(&triangles), &options).measured as f64 / (4096.0 * f64::from(options.radius));
        assert!(each < most, "{each}");
    }
}

#[test]
fn a_cancelled_build_ends_wherever_it_is() {
    struct After(std::sync::atomic::AtomicU32);
    impl Progress for After {
        fn is_cancelled(&self) -> bool {
            self.0.fetch_sub(1, std::sync::atomic::Ordering::Relaxed) == 0
        }
    }
    for asked in [0, 1, 5, 9] {
        let after = After(asked.into());
        let found = cluster(&soup(3000), &options(HullBasis::Fit), &Executor::sequential(), &after);
        assert!(matches!(found, Err(BuildError::Cancelled)), "after {asked}");
    }
}
