use crate::cache::{NO_NODE, View};
use crate::exec::Executor;
use crate::scene::Scene;
use crate::trace::Hit;
use crate::trace::brute::Source;
use std::collections::BTreeMap;

/// For each record of `TRIS` the triangle of the scene whose numbers it bears.
pub(super) struct Origins {
    /// In a two-level file an instance of the tree stands for all of them, since a hit says which it is in.
    slots: Vec<Origin>,
}

/// What the scene says of a triangle's numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Origin {
    Known(Source),
    /// No triangle has them.
    Nothing,
    /// Several have: copies of one mesh that one node placed in one tree.
    Several,
}

impl Origins {
    pub fn new(view: &View<'_>, scene: &Scene, exec: &Executor) -> Origins {
        let rows = if view.tlas_nodes.is_empty() { rows_of_one_level(view, scene) } else { rows_of_two(view, scene) };
        let origin = |row: Option<&Row>, prim: u32| match row {
            Some(Row::Place { instance, part }) => {
                let mesh = &scene.meshes[scene.instances[*instance as usize].mesh as usize];
                let source = |triangle: usize| Source { instance: *instance, triangle: triangle as u32 };
                mesh.triangle_of(*part, prim).map_or(Origin::Nothing, |triangle| Origin::Known(source(triangle)))
            }
            Some(Row::Several) => Origin::Several,
            Some(Row::Nothing) | None => Origin::Nothing,
        };
        let of_slot = |slot: usize| {
            let triangle = &view.triangles[slot];
            origin(rows.get(triangle.geom as usize), triangle.prim)
        };
        Origins { slots: exec.generate(view.triangles.len(), of_slot) }
    }

    /// The triangle of the scene that a hit names.
    pub fn of(&self, hit: &Hit) -> Origin {
        match self.slots.get(hit.triangle) {
            Some(Origin::Known(s)) => Origin::Known(Source { instance: hit.instance.unwrap_or(s.instance), ..*s }),
            Some(other) => *other,
            None => Origin::Nothing,
        }
    }
}

/// Where a row of `GEOM` comes from.
#[derive(Clone, Copy)]
enum Row {
    Nothing,
    /// A part of an instance's mesh.
    Place {
        instance: u32,
        part: usize,
    },
    Several,
}

fn rows_of_two(view: &View<'_>, scene: &Scene) -> Vec<Row> {
    let mut rows = vec![Row::Nothing; view.geoms.len()];
    let mut seen = vec![false; view.blases.len()];
    for record in view.instances {
        let Some(seen) = seen.get_mut(record.blas as usize).filter(|seen| !**seen) else { continue };
        let Some(place) = scene.instances.get(record.id as usize) else { continue };
        *seen = true;
        let low = view.geoms.partition_point(|g| g.blas < record.blas);
        let high = view.geoms.partition_point(|g| g.blas <= record.blas).max(low);
        let parts = scene.meshes[place.mesh as usize].parts.iter().enumerate();
        let known: BTreeMap<(u32, u32), usize> = parts.map(|(i, part)| (origin_of(part), i)).collect();
        for (row, geom) in rows[low..high].iter_mut().zip(&view.geoms[low..high]) {
            if let Some(part) = known.get(&(geom.source_mesh, geom.source_part)) {
                *row = Row::Place { instance: record.id, part: *part };
            }
        }
    }
    rows
}

/// By what a part is known by in a one-level file.
fn rows_of_one_level(view: &View<'_>, scene: &Scene) -> Vec<Row> {
    let mut known = BTreeMap::<(u32, u32, u32), Row>::new();
    for (instance, place) in scene.instances.iter().enumerate() {
        for (part, p) in scene.meshes[place.mesh as usize].parts.iter().enumerate() {
            let here = Row::Place { instance: instance as u32, part };
            let (mesh_number, part_number) = origin_of(p);
            for node in [p.baked_node.unwrap_or(place.node), NO_NODE] {
                known.entry((mesh_number, part_number, node)).and_modify(|row| *row = Row::Several).or_insert(here);
            }
        }
    }
    let row = |g: &crate::cache::GeomRecord| known.get(&(g.source_mesh, g.source_part, g.baked_node)).copied();
    view.geoms.iter().map(|g| row(g).unwrap_or(Row::Nothing)).collect()
}

fn origin_of(part: &crate::scene::Part) -> (u32, u32) {
    (part.source_mesh, part.source_part)
}
