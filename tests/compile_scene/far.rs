//! Meshes far from the origin keep their shape.

use super::*;

/// A wavy sheet of n × n cells of 0.1.
fn sheet(n: u32) -> Mesh {
    let point = |k: u32| [0.1 * (k / (n + 1)) as f32, 0.01 * (k % 7) as f32, 0.1 * (k % (n + 1)) as f32];
    let cell = |c: u32| {
        let a = c / n * (n + 1) + c % n;
        [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]]
    };
    let triangles: Vec<[u32; 3]> = (0..n * n).flat_map(cell).collect();
    let count = triangles.len() as u32;
    Mesh {
        name: "sheet".into(),
        positions: (0..(n + 1) * (n + 1)).map(point).collect(),
        triangles,
        source_prims: Vec::new(),
        parts: vec![Part { triangle_count: count, prim_count: count, ..Part::default() }],
        ..Mesh::default()
    }
}

const FAR: [f64; 3] = [500_123.26, 102.5, -4_649_776.77];

fn turned(degrees: f64, [x, y, z]: [f64; 3]) -> Affine {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Affine { rows: [[cos, 0.0, sin, x], [0.0, 1.0, 0.0, y], [-sin, 0.0, cos, z]] }
}

/// Where a file's records put every corner, by node and source number, and the farthest that one is from where the source puts it.
fn farthest(source: &Scene, accel: &Accel) -> f64 {
    let image = bvhc::cache::Image::new(accel, &Executor::sequential()).unwrap();
    let view = image.view();
    let mut seen = 0;
    let mut worst = 0.0f64;
    for (tree, blas) in view.blases.iter().enumerate() {
        let records = view.blas(tree).unwrap().triangles;
        let places: Vec<_> = view.instances.iter().filter(|i| i.blas as usize == tree).collect();
        for record in records.iter() {
            let row = view.geoms[record.geom as usize];
            for place in if places.is_empty() { vec![None] } else { places.iter().map(Some).collect() } {
                let node = if row.baked_node == u32::MAX { place.unwrap().node } else { row.baked_node };
                let instance = source.instances.iter().find(|i| i.node == node).unwrap();
                let corners = source.meshes[instance.mesh as usize].corners(record.prim as usize);
                for (stored, corner) in record.corners().iter().zip(corners) {
                    let want = instance.transform.transform_point(corner.map(f64::from));
                    let at = stored.map(f64::from);
                    // A ray comes to the triangle by the way back: that is what must be right.
                    let (moved, stored) = match place {
                        Some(p) => (Affine::from_f32(&p.world_to_object).transform_point(want), at),
                        None => (want, at),
                    };
                    worst = (0..3).map(|a| (moved[a] - stored[a]).abs()).fold(worst, f64::max);
                }
                seen += 1;
            }
        }
        assert!(blas.prim_count > 0);
    }
    assert_eq!(seen, source.instances.iter().map(|i| source.meshes[i.mesh as usize].triangles.len()).sum::<usize>());
    worst
}

#[test]
fn a_mesh_far_away_is_built_about_an_origin_of_its_own() {
    for transform in [Affine::translation(FAR), turned(33.0, FAR)] {
        let source = scene(vec![sheet(20)], vec![place(0, 7, transform)]);
        for levels in [Levels::Auto, Levels::Two] {
            let accel = run(source.clone(), levels).unwrap();
            assert_eq!((accel.blases.len(), accel.instances.len(), accel.instances[0].node), (1, 1, 7));
            assert!(farthest(&source, &accel) < 1e-6, "{levels:?}");
            assert!(accel.notes[0].contains("origins of their own"), "{:?}", accel.notes);
            let matrix = accel.instances[0].transform.to_f32();
            assert_eq!(Affine::from_f32(&matrix), accel.instances[0].transform, "whole floats");
        }
        let flat = run(source.clone(), Levels::One).unwrap();
        assert!(flat.tlas.is_none() && flat.notes.is_empty());
    }
}

#[test]
fn small_parts_of_a_coarse_mesh_keep_their_shape_far_away() {
    // A plain of 20,000 triangles, and a row of 50 that are a thousandth as large: in the mean over all nothing is lost.
    let corner = |i: u32, k: u32| {
        let (size, x) = if i < 50 { (0.0625, 0.0625 * i as f32) } else { (64.0, 64.0 * (i - 50) as f32) };
        [x + if k == 1 { size } else { 0.0 }, if k == 2 { size } else { 0.0 }, 0.0]
    };
    let positions = (0..20_050).flat_map(|i| (0..3).map(move |k| corner(i, k))).collect();
    let mesh =
        Mesh::new(String::from("plain"), positions, (0..20_050).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect())
            .unwrap();
    let source = scene(vec![mesh], vec![place(0, 1, Affine::translation(FAR))]);
    let laid = |levels| lay_out(source.clone(), &options(levels), &Executor::sequential()).unwrap();
    let kept = laid(Levels::Auto);
    assert_eq!((kept.meshes[0].triangles.len(), kept.placing.collapsed), (20_050, 0));
    assert!(kept.placing.loss.is_tolerable());
    let flat = laid(Levels::One).placing;
    assert!(flat.loss.share < Loss::MOST && !flat.loss.is_tolerable(), "{:?}", flat.loss);
}

#[test]
fn what_lies_together_far_away_is_one_tree() {
    let count = 30;
    let meshes = (0..count).map(|_| sheet(4)).collect();
    let spread = |i: u32| [FAR[0] + f64::from(i % 6), FAR[1], FAR[2] + f64::from(i / 6)];
    let source = scene(meshes, (0..count).map(|i| place(i, i, turned(f64::from(i * 7), spread(i)))).collect());
    let accel = run(source.clone(), Levels::Auto).unwrap();
    assert_eq!((accel.blases.len(), accel.instances.len(), accel.instances[0].node), (1, 1, u32::MAX));
    assert_eq!(accel.meshes[0].parts[3].baked_node, Some(3));
    assert!(farthest(&source, &accel) < 1e-6);
}

#[test]
fn only_what_loses_its_shape_gets_a_tree_of_its_own() {
    // Thirty sheets at the origin, two places far from it and from each other, and one mesh of coarse triangles over there.
    let mut meshes: Vec<Mesh> = (0..33).map(|_| sheet(4)).collect();
    meshes.push(strip("coarse", 20));
    let far = |k: f64| [FAR[0] * k, 0.0, FAR[2]];
    let at = |i: u32| match i {
        30 | 31 => Affine::translation(far(1.0 + 1e-6 * f64::from(i))),
        32 => Affine::translation(far(-2.0)),
        33 => Affine { rows: [[900.0, 0.0, 0.0, 4e5], [0.0, 900.0, 0.0, 0.0], [0.0, 0.0, 900.0, 0.0]] },
        _ => shift(f64::from(i)),
    };
    let source = scene(meshes, (0..34).map(|i| place(i, i, at(i))).collect());
    let accel = run(source.clone(), Levels::Auto).unwrap();
    let nodes: Vec<Vec<u32>> =
        accel.meshes.iter().map(|m| m.parts.iter().map(|p| p.baked_node.unwrap()).collect()).collect();
    let (near, both): (Vec<u32>, Vec<u32>) = ((0..30).chain([33]).collect(), vec![30, 31]);
    assert_eq!(nodes, [near, both, vec![32]]);
    assert_eq!(accel.instances[0].transform, Affine::IDENTITY);
    assert!(farthest(&source, &accel) < 0.02 * 900.0 / 64.0);
}

#[test]
fn a_shared_mesh_far_away_is_moved_to_where_its_matrices_are_floats() {
    let at = |x: f64| Affine::translation([FAR[0] + x, FAR[1], FAR[2]]);
    let source = scene(vec![sheet(20)], vec![place(0, 1, at(0.0)), place(0, 2, at(7.0))]);
    for levels in [Levels::Auto, Levels::Two] {
        let accel = run(source.clone(), levels).unwrap();
        assert_eq!((accel.blases.len(), accel.instances.len()), (1, 2));
        assert!(farthest(&source, &accel) < 1e-6);
    }
    // The same beside the origin stays as it is read.
    let near = scene(vec![sheet(20)], vec![place(0, 1, shift(0.1)), place(0, 2, shift(7.3))]);
    let accel = run(near.clone(), Levels::Auto).unwrap();
    assert_eq!(accel.meshes[0].positions, near.meshes[0].positions);
    assert_eq!(accel.instances[1].transform, near.instances[1].transform);
}

#[test]
fn the_policy_holds_where_triangles_are_put() {
    let mut flat = sheet(20);
    flat.positions.iter_mut().for_each(|p| p[1] = 0.0);
    let place = place(0, 1, Affine::translation(FAR));
    let source = |degenerate| Scene { degenerate, ..scene(vec![flat.clone()], vec![place.clone()]) };
    let laid = |degenerate| lay_out(source(degenerate), &options(Levels::One), &Executor::sequential());
    let dropped = laid(Degenerate::Drop).unwrap();
    let lost = dropped.placing.collapsed;
    assert!(lost > 0 && !dropped.placing.loss.is_tolerable(), "{:?}", dropped.placing);
    let mesh = &dropped.meshes[0];
    assert_eq!((mesh.triangles.len() as u64, mesh.source_prims.len() as u64), (800 - lost, 800 - lost));
    assert_eq!((u64::from(mesh.parts[0].triangle_count), mesh.parts[0].prim_count), (800 - lost, 800));
    assert!(mesh.source_prims.is_sorted());

    let kept = laid(Degenerate::Keep).unwrap();
    assert_eq!((kept.meshes[0].triangles.len(), kept.placing.collapsed), (800, lost));
    assert!(matches!(laid(Degenerate::Error), Err(BuildError::Collapsed { node: 1, .. })));
    for degenerate in [Degenerate::Drop, Degenerate::Keep, Degenerate::Error] {
        let beside = lay_out(source(degenerate), &options(Levels::Auto), &Executor::sequential()).unwrap();
        assert_eq!((beside.placing.collapsed, beside.meshes[0].triangles.len()), (0, 800));
    }
}
