//! A model that is another one: rules `E06xx`.

use super::*;

/// The model of the source rules: eight triangles, of which the last was dropped.
pub(super) fn seven() -> Mesh {
    let mut mesh = sheet(2, 0.0);
    mesh.triangles.truncate(7);
    mesh.source_prims = (0..7).collect();
    mesh.parts[0].triangle_count = 7;
    mesh
}

pub(super) fn source() -> Vec<Invalid> {
    let against = |rule, bytes, mesh| Invalid {
        source: Some(Model { meshes: vec![mesh], instances: None }),
        ..broken(rule, bytes)
    };
    let made_from = |mesh: Mesh| {
        let tree = tree(&mesh, 1);
        file(&one_level(mesh, tree))
    };
    let mut six = seven();
    six.triangles.truncate(6);
    six.source_prims.truncate(6);
    six.parts[0].triangle_count = 6;
    let mut moved = seven();
    moved.positions[4][2] += 0.5;
    let mut other_part = seven();
    other_part.parts[0].source_part = 3;
    let accel: Accel = scenes::two_level_accel();
    let mut other_node = accel.clone();
    other_node.instances[3].node = 77;
    let mut meta = scenes::meta();
    meta.dependencies[0].len += 1;
    let tree_of_seven = tree(&seven(), 1);
    let other_input =
        to_bytes(&one_level(seven(), tree_of_seven), &meta, &WriteOptions::default(), &Executor::current()).unwrap();
    let mut numbered = seven();
    numbered.vertices.clone_from(&numbered.triangles);
    let mut misnumbered = numbered.clone();
    misnumbered.vertices[2] = [90, 91, 92];
    vec![
        against(&rules::E0607, made_from(misnumbered), numbered),
        against(&rules::E0601, made_from(six), seven()),
        against(&rules::E0602, made_from(sheet(2, 0.0)), seven()),
        against(&rules::E0603, made_from(moved), seven()),
        against(&rules::E0604, made_from(other_part), seven()),
        Invalid {
            source: Some(Model { meshes: accel.meshes, instances: Some(accel.instances) }),
            ..broken(&rules::E0605, file(&Image::new(&other_node, &Executor::current()).unwrap()))
        },
        against(&rules::E0606, other_input, seven()),
    ]
}

/// A file of a model whose part is another one in what no row of GEOM says.
pub(super) fn other_origin(edit: fn(&mut bvhc::scene::Part)) -> Invalid {
    let mut mesh = seven();
    mesh.parts[0].baked_node = Some(2);
    let tree = tree(&mesh, 1);
    let file = file(&one_level(mesh.clone(), tree));
    edit(&mut mesh.parts[0]);
    Invalid { source: Some(Model { meshes: vec![mesh], instances: None }), ..broken(&rules::E0604, file) }
}
