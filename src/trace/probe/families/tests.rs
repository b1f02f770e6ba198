use super::*;
use crate::build::{BuildOptions, Method, NoProgress, Preset, initial_tree};
use crate::cache::Image;
use crate::scene::{Mesh, Part};
use crate::trace::probe::tests::cube;

/// A cube with another one within it, a tenth as large.
fn nested(options: &BuildOptions) -> Image {
    let quads: [[u32; 4]; 6] = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let mut mesh =
        Mesh { parts: vec![Part { triangle_count: 24, prim_count: 24, ..Part::default() }], ..Mesh::default() };
    for (cube, size) in [1.0f32, 0.1].into_iter().enumerate() {
        let base = 8 * cube as u32;
        mesh.positions.extend((0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { -size } else { size })));
        mesh.triangles
            .extend(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]].map(|t| t.map(|i| i + base))));
    }
    let tree = initial_tree(&mesh, options, &Executor::sequential(), &NoProgress).unwrap();
    Image::of_tree(&mesh, &tree, &Executor::sequential()).unwrap()
}

#[test]
fn rays_depend_on_no_thread_and_no_tree_and_two_seeds_share_none() {
    let other = BuildOptions { method: Method::Agglomerative, max_leaf: 1, ..BuildOptions::preset(Preset::Draft) };
    let images = [&BuildOptions::preset(Preset::Draft), &other].map(nested);
    let one = FamilyRays::new(&images[0].view(), 300, 1, &Executor::sequential());
    let two = FamilyRays::new(&images[1].view(), 300, 1, &Executor::new(3).unwrap());
    assert_eq!(one.sets, two.sets);
    let seeded = FamilyRays::new(&images[0].view(), 300, 2, &Executor::sequential());
    for family in Family::ALL {
        assert_eq!(one.len(family), 300, "{}", family.name());
        let mine = &one.sets[family as usize];
        assert!(seeded.sets[family as usize].iter().all(|ray| !mine.contains(ray)), "{}", family.name());
    }
}

#[test]
fn eyes_stand_where_their_family_says() {
    let image = nested(&BuildOptions::preset(Preset::Draft));
    let rays = FamilyRays::new(&image.view(), 400, 1, &Executor::sequential());
    let is_within = |ray: &&Ray| ray.origin.iter().all(|c| c.abs() <= 1.0);
    assert_eq!(rays.sets[Family::Outside as usize].iter().filter(is_within).count(), 0);
    let distinct = |family: Family| {
        let mut eyes: Vec<[u32; 3]> = rays.sets[family as usize].iter().map(|r| r.origin.map(f32::to_bits)).collect();
        eyes.sort_unstable();
        eyes.dedup();
        eyes.len()
    };
    assert_eq!([Family::Outside, Family::Inside].map(distinct), [400, 400]);
    // Half of the area's rays start on the wrong side of the outer walls, but for a hundredth that belongs to the small cube.
    let escape = rays.sets[Family::Area as usize].iter().filter(|ray| closest_hit(&image.view(), ray) == Ok(None));
    assert!((150..250).contains(&escape.count()));
    let small = |family: Family| {
        let near = |ray: &&Ray| ray.origin.iter().all(|c| c.abs() < 0.2);
        rays.sets[family as usize].iter().filter(near).count()
    };
    assert!(small(Family::Area) < 20 && (150..250).contains(&small(Family::Triangles)));
    assert!(rays.sets[Family::Chords as usize].iter().all(|ray| ray.origin.iter().any(|c| c.abs() > 0.9)));
}

#[test]
fn rays_are_cut_off_at_what_they_hit() {
    let image = cube(&BuildOptions::preset(Preset::Draft));
    let rays = FamilyRays::new(&image.view(), 200, 5, &Executor::sequential());
    for (cut, ray) in rays.cut_off(&image.view(), &Executor::new(2).unwrap()).iter().zip(rays.sets.concat()) {
        let hit = closest_hit(&image.view(), &ray).unwrap().map(|hit| hit.t);
        assert_eq!((cut.origin, cut.t_max), (ray.origin, hit.unwrap_or(ray.t_max)));
    }
}

#[test]
fn costs_are_compared_ray_by_ray() {
    let of = |rays: &[f32]| {
        let mut cost = FamilyCost { rays: [const { Vec::new() }; FAMILIES] };
        cost.rays[Family::Area as usize] = rays.to_vec();
        cost
    };
    let base = of(&[1.0, 2.0, 3.0, 10.0]);
    let (over, error) = of(&[2.0, 4.0, 6.0, 20.0]).beyond(&base, Family::Area).unwrap();
    assert_eq!((over, error), (1.0, 0.0), "twice as dear for each of them leaves nothing to chance");
    let (over, error) = of(&[1.0, 2.0, 3.0, 14.0]).beyond(&base, Family::Area).unwrap();
    assert!((over - 0.25).abs() < 1e-12 && (0.05..0.3).contains(&error), "{error}");
    assert_eq!((base.mean(Family::Area), base.mean(Family::Chords)), (Some(4.0), None));
    assert_eq!(base.beyond(&base, Family::Chords), None);
}

#[test]
fn nothing_to_see() {
    let image = Image::default();
    let rays = FamilyRays::new(&image.view(), 100, 1, &Executor::sequential());
    assert!(
        rays.is_empty()
            && Family::ALL.iter().all(|family| rays
                .cost(&image.view(), &Executor::sequential())
                .mean(*family)
                .unwrap_or(0.0)
                == 0.0)
    );
}
