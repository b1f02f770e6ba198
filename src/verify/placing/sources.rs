//! Which of the scene's instances a row of `GEOM` comes from.

use super::judge::{Judged, judge};
use crate::cache::{GeomRecord, InstanceRecord, NO_NODE, TriangleRecord, View};
use crate::geom::Affine;
use crate::scene::Scene;
use std::collections::BTreeMap;
use std::ops::Range;

/// A tree where it stands.
#[derive(Clone, Copy)]
pub struct Place<'a> {
    /// `None` for the one tree of a file of one level.
    instance: Option<&'a InstanceRecord>,
    to_tree: Affine,
}

impl<'a> Place<'a> {
    pub fn new(instance: Option<&'a InstanceRecord>) -> Place<'a> {
        let to_tree = instance.map_or(Affine::IDENTITY, |p| Affine::from_f32(&p.world_to_object));
        Place { instance, to_tree }
    }

    /// The node whose instances a row may come from; `None` where any may be.
    fn node(&self, row: &GeomRecord) -> Option<u32> {
        Some(row.baked_node).filter(|node| *node != NO_NODE).or(self.instance.map(|p| p.node))
    }
}

/// The scene's instances by what rows of `GEOM` and records of `INST` say: mesh, part and node. A few words for each instance and part of the
/// scene and for each row of the file.
pub struct Sources<'a> {
    scene: &'a Scene,
    geoms: &'a [GeomRecord],
    /// For each source mesh and part the meshes that have it, ascending, with the part's number in them.
    holders: Vec<Vec<(u32, u32)>>,
    /// For each row which of the holders it means.
    holders_of: Vec<u32>,
    /// Numbers of instances, by their nodes.
    by_node: Vec<u32>,
    /// For each row whose transform was baked the instance that it comes from.
    chosen: Vec<u32>,
}

/// For what the scene does not have.
const NOBODY: u32 = u32::MAX;

impl<'a> Sources<'a> {
    /// `most`: how often triangles may be looked at to find out which rows are whose.
    pub fn new(view: &View<'a>, scene: &'a Scene, most: usize) -> Sources<'a> {
        let (mut holders, mut numbers) = (Vec::<Vec<(u32, u32)>>::new(), BTreeMap::new());
        for (mesh, parts) in scene.meshes.iter().map(|m| &m.parts).enumerate() {
            for (part, p) in parts.iter().enumerate() {
                let number = *numbers.entry((p.source_mesh, p.source_part)).or_insert(holders.len());
                if number == holders.len() {
                    holders.push(Vec::new());
                }
                holders[number].push((mesh as u32, part as u32));
            }
        }
        let number = |row: &GeomRecord| numbers.get(&(row.source_mesh, row.source_part)).map_or(NOBODY, |n| *n as u32);
        let mut by_node: Vec<u32> = (0..scene.instances.len() as u32).collect();
        by_node.sort_by_key(|i| scene.instances[*i as usize].node);
        let sources = Sources {
            scene,
            geoms: view.geoms,
            holders_of: view.geoms.iter().map(number).collect(),
            holders,
            by_node,
            chosen: Vec::new(),
        };
        Sources { chosen: sources.choose(view, most), ..sources }
    }

    /// The instances that a row may come from: more than one where one node puts a mesh in several places.
    fn candidates(&self, node: Option<u32>) -> &[u32] {
        let Some(node) = node else { return &self.by_node };
        let of = |i: &u32| self.scene.instances[*i as usize].node;
        let low = self.by_node.partition_point(|i| of(i) < node);
        let high = self.by_node.partition_point(|i| of(i) <= node);
        &self.by_node[low..high]
    }

    /// The part of a mesh that a row means.
    fn part(&self, geom: usize, mesh: u32) -> Option<usize> {
        let holders = self.holders.get(*self.holders_of.get(geom)? as usize)?;
        let at = holders.binary_search_by_key(&mesh, |(mesh, _)| *mesh).ok()?;
        Some(holders[at].1 as usize)
    }

    /// How a record of row `geom` stands to the triangle of an instance whose numbers it bears, if there is one.
    fn judge(&self, record: &TriangleRecord, geom: usize, number: u32, place: &Place<'_>) -> Option<Judged> {
        let instance = self.scene.instances.get(number as usize)?;
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let triangle = mesh.triangle_of(self.part(geom, instance.mesh)?, record.prim)?;
        let by_matrix = self.geoms[geom].baked_node == NO_NODE && place.instance.is_some();
        Some(judge(record, mesh.corners(triangle), instance, &place.to_tree, by_matrix))
    }

    /// The instance that a record comes from, and how the record stands to it; `None` where the scene has no such triangle.
    ///
    /// Where the instance that was expected does not explain it, all of the node are tried, as long as `left` such looks are left.
    pub fn nearest(&self, record: &TriangleRecord, place: &Place<'_>, left: &mut usize) -> Option<(u32, Judged)> {
        let geom = record.geom as usize;
        let row = self.geoms.get(geom)?;
        let own = self.own(geom, place);
        let expected = Some(self.chosen[geom]).filter(|number| *number != NOBODY).or(own);
        let first = expected.and_then(|number| Some((number, self.judge(record, geom, number, place)?)));
        // A matrix moves the one instance that its record names.
        let is_alone = row.baked_node == NO_NODE && own.is_some();
        if is_alone || first.is_some_and(|(_, judged)| !judged.astray) {
            return first;
        }
        let candidates = self.candidates(place.node(row));
        if candidates.len() > *left {
            return first;
        }
        *left -= candidates.len();
        let judged = candidates.iter().filter_map(|number| Some((*number, self.judge(record, geom, *number, place)?)));
        judged.min_by(|a, b| a.1.moved.total_cmp(&b.1.moved))
    }

    /// The instance that the record of `INST` names, if it is of the row's node and has its part.
    fn own(&self, geom: usize, place: &Place<'_>) -> Option<u32> {
        let id = place.instance?.id;
        let instance = self.scene.instances.get(id as usize)?;
        let is_of_node = Some(instance.node) == place.node(self.geoms.get(geom)?);
        (is_of_node && self.part(geom, instance.mesh).is_some()).then_some(id)
    }

    /// Find for each row whose transform was baked the instance that it comes from, by the row's first triangle.
    ///
    /// Instances stand in the file in the scene's order, so the search goes on behind the last one that was found: about as many looks as
    /// there are rows in a file that is right, and `most` beyond that in any other.
    fn choose(&self, view: &View<'_>, most: usize) -> Vec<u32> {
        let mut chosen = vec![NOBODY; view.geoms.len()];
        let is_one_level = view.tlas_nodes.is_empty();
        let mut place_of = vec![None; view.blases.len()];
        for instance in view.instances.iter().rev() {
            if let Some(place) = place_of.get_mut(instance.blas as usize) {
                *place = Some(instance);
            }
        }
        let (mut left, mut behind) = (most, BTreeMap::<(u32, Option<u32>), usize>::new());
        for (tree, instance) in place_of.into_iter().enumerate().filter(|(_, i)| i.is_some() || is_one_level) {
            let is_baked = |geom: &usize| is_one_level || view.geoms[*geom].baked_node != NO_NODE;
            let rows = rows_of(view, tree);
            let Some(blas) = view.blas(tree).filter(|_| rows.clone().any(|geom| is_baked(&geom))) else { continue };
            let place = Place::new(instance);
            let firsts = first_of_each(blas.triangles, rows.clone());
            for (geom, record) in rows.zip(firsts).filter(|(geom, _)| is_baked(geom)) {
                let Some(record) = record else { continue };
                let is_it = |number: u32| self.judge(record, geom, number, &place).is_some_and(|j| !j.astray);
                if let Some(own) = self.own(geom, &place).filter(|own| is_it(*own)) {
                    chosen[geom] = own;
                    continue;
                }
                let node = place.node(&view.geoms[geom]);
                let candidates = self.candidates(node);
                let start = behind.entry((self.holders_of[geom], node)).or_default();
                let looks = candidates.len().min(left + 1);
                let at = |k: usize| (*start + k) % candidates.len();
                let found = (0..looks).find(|k| is_it(candidates[at(*k)]));
                left -= found.unwrap_or(looks).min(left);
                if let Some(at) = found.map(at) {
                    chosen[geom] = candidates[at];
                    *start = at + 1;
                }
            }
        }
        chosen
    }
}

/// The rows of a tree, which stand beside each other.
fn rows_of(view: &View<'_>, tree: usize) -> Range<usize> {
    let low = view.geoms.partition_point(|g| (g.blas as usize) < tree);
    let high = view.geoms.partition_point(|g| (g.blas as usize) <= tree);
    low..high.max(low)
}

/// For each of the rows its first triangle.
fn first_of_each(triangles: &[TriangleRecord], rows: Range<usize>) -> Vec<Option<&TriangleRecord>> {
    let mut found = vec![None; rows.len()];
    let mut missing = found.len();
    for record in triangles {
        if missing == 0 {
            break;
        }
        let row = (record.geom as usize).checked_sub(rows.start).and_then(|row| found.get_mut(row));
        if let Some(row @ None) = row {
            *row = Some(record);
            missing -= 1;
        }
    }
    found
}
