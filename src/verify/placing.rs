//! Does a file hold the model's triangles where the model has them? Told without rays, from every corner: the model's position is moved by
//! its node's transform in `f64`, brought into the tree's coordinates by the matrix that rays come by, and held against what stands there.
//!
//! This shares nothing with the builder but the model as read. What it finds is of two kinds: rounding to 32 bits, which is told by its size
//! and is too much where a mesh loses its shape ([`Loss`]), and what no rounding explains.

use crate::cache::{GeomRecord, InstanceRecord, NO_NODE, TriangleRecord, View};
use crate::exec::Executor;
use crate::geom::{Affine, Point};
use crate::scene::{Instance, Loss, Mesh, Scene};
use serde::Serialize;
use std::collections::BTreeMap;

/// How a file's triangles stand to the model's.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Placed {
    /// Triangles looked at, once for each instance: all of them up to some millions, else some of each instance.
    pub triangles: u64,
    /// Rounding, of the instance that it costs most; in the unit of its tree.
    pub loss: Loss,
    /// That instance, in the model's order.
    pub instance: Option<u32>,
    /// What was lost before, from the numbers in the model's file to its positions as read.
    pub read: Loss,
    /// Triangles with a corner farther away than rounding explains, or of which the model knows nothing.
    pub astray: u64,
}

impl Placed {
    /// Everything is where it belongs and keeps its shape.
    pub fn is_right(&self) -> bool {
        self.astray == 0 && self.loss.is_tolerable() && self.read.is_tolerable()
    }
}

/// Triangles looked at in all, and fewest of each instance.
const WORK: usize = 1 << 24;
const LEAST: usize = 64;
/// Triangles that a task looks at. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 14;

/// Compare a file with the model that it was built from.
pub fn placed(view: &View<'_>, scene: &Scene, exec: &Executor) -> Placed {
    let sources = Sources::new(scene);
    let world = [None];
    let places: Vec<Option<&InstanceRecord>> =
        if view.tlas_nodes.is_empty() { world.to_vec() } else { view.instances.iter().map(Some).collect() };
    let most = (WORK / places.len().max(1)).max(LEAST);
    let of_places = exec.map(places, |_, place| of_place(view, place, &sources, most, exec));
    let mut tallies = BTreeMap::<u32, Tally>::new();
    for (instance, tally) in of_places.into_iter().flatten() {
        tallies.entry(instance).or_default().append(tally);
    }

    let mut all = Placed { read: scene.rounding.loss, ..Placed::default() };
    for (instance, tally) in tallies {
        all.triangles += tally.edges.len() as u64 + tally.astray;
        all.astray += tally.astray;
        let loss = tally.loss();
        if instance != UNKNOWN && (all.instance.is_none() || loss.share > all.loss.share) {
            (all.loss, all.instance) = (loss, Some(instance));
        }
    }
    all
}

/// Stands for the instance of triangles that the model does not have.
const UNKNOWN: u32 = u32::MAX;

/// What is known of an instance so far.
#[derive(Default)]
struct Tally {
    edges: Vec<f64>,
    sum: f64,
    farthest: f64,
    astray: u64,
}

impl Tally {
    fn append(&mut self, mut other: Tally) {
        self.edges.append(&mut other.edges);
        self.sum += other.sum;
        self.farthest = self.farthest.max(other.farthest);
        self.astray += other.astray;
    }

    fn loss(mut self) -> Loss {
        if self.edges.is_empty() {
            return Loss::default();
        }
        let (share, middle) = (self.sum / self.edges.len() as f64, self.edges.len() / 2);
        let (_, edge, _) = self.edges.select_nth_unstable_by(middle, f64::total_cmp);
        Loss { farthest: self.farthest, edge: *edge, share }
    }
}

/// The scene's instances by what a row of `GEOM` says: mesh, part and node.
struct Sources<'a> {
    scene: &'a Scene,
    by_node: BTreeMap<(u32, u32, u32), Vec<(u32, usize)>>,
}

impl<'a> Sources<'a> {
    fn new(scene: &'a Scene) -> Sources<'a> {
        let mut by_node = BTreeMap::<_, Vec<_>>::new();
        for (number, instance) in scene.instances.iter().enumerate() {
            for (part, p) in scene.meshes[instance.mesh as usize].parts.iter().enumerate() {
                by_node.entry((p.source_mesh, p.source_part, instance.node)).or_default().push((number as u32, part));
            }
        }
        Sources { scene, by_node }
    }

    /// The instances and their parts that a row may come from. More than one only where one node puts a mesh in several places and all of
    /// them are in one tree.
    fn of(&self, row: &GeomRecord, place: Option<&InstanceRecord>) -> Vec<(u32, usize)> {
        let key = |node: u32| (row.source_mesh, row.source_part, node);
        let at = |node: u32| self.by_node.get(&key(node)).cloned().unwrap_or_default();
        match place {
            _ if row.baked_node != NO_NODE => at(row.baked_node),
            Some(place) => {
                let all = at(place.node);
                let own: Vec<_> = all.iter().copied().filter(|(number, _)| *number == place.id).collect();
                if own.is_empty() { all } else { own }
            }
            None => self.by_node.range(key(0)..=key(u32::MAX)).flat_map(|(_, some)| some.iter().copied()).collect(),
        }
    }
}

fn of_place(
    view: &View<'_>,
    place: Option<&InstanceRecord>,
    sources: &Sources<'_>,
    most: usize,
    exec: &Executor,
) -> BTreeMap<u32, Tally> {
    let tree = place.map_or(0, |p| p.blas as usize);
    let Some(blas) = view.blas(tree) else { return BTreeMap::new() };
    let to_tree = place.map_or(Affine::IDENTITY, |p| Affine::from_f32(&p.world_to_object));
    let low = view.geoms.partition_point(|g| (g.blas as usize) < tree);
    let high = view.geoms.partition_point(|g| (g.blas as usize) <= tree).max(low);
    let rows: Vec<(bool, Vec<(u32, usize)>)> =
        view.geoms[low..high].iter().map(|row| (row.baked_node == NO_NODE, sources.of(row, place))).collect();

    let all = blas.triangles.len();
    let step = all.div_ceil(most).max(1);
    let chunks = exec.map_chunks(blas.triangles, CHUNK, |_, chunk| {
        let mut tallies = BTreeMap::<u32, Tally>::new();
        for record in chunk.iter().step_by(step) {
            let row = (record.geom as usize).checked_sub(low).and_then(|row| rows.get(row));
            let (by_matrix, from) = row.map_or((false, &[][..]), |(by_matrix, from)| (*by_matrix, &from[..]));
            let judged = from.iter().filter_map(|(number, part)| {
                let instance = &sources.scene.instances[*number as usize];
                let mesh = &sources.scene.meshes[instance.mesh as usize];
                let corners = mesh.corners(find(mesh, *part, record.prim)?);
                Some((*number, judge(record, corners, instance, &to_tree, by_matrix && place.is_some())))
            });
            match judged.min_by(|a, b| a.1.moved.total_cmp(&b.1.moved)) {
                Some((number, judged)) => tallies.entry(number).or_default().add(&judged),
                None => tallies.entry(UNKNOWN).or_default().astray += 1,
            }
        }
        tallies
    });
    let mut tallies = BTreeMap::<u32, Tally>::new();
    for (number, tally) in chunks.into_iter().flatten() {
        tallies.entry(number).or_default().append(tally);
    }
    tallies
}

/// A triangle of the file against one of the model.
struct Judged {
    moved: f64,
    edge: f64,
    astray: bool,
}

impl Tally {
    fn add(&mut self, judged: &Judged) {
        if judged.astray {
            self.astray += 1;
        } else {
            let share = if judged.edge > 0.0 { (judged.moved / judged.edge).min(1.0) } else { 0.0 };
            self.edges.push(judged.edge);
            self.sum += share;
            self.farthest = self.farthest.max(judged.moved);
        }
    }
}

/// Where a model's corner belongs in a tree, and how far off rounding may put it on each axis: half the distance between floats where it was
/// moved and stored, and what 32-bit matrices add where it is the matrix that moves it.
fn judge(
    record: &TriangleRecord,
    corners: [Point; 3],
    instance: &Instance,
    to_tree: &Affine,
    by_matrix: bool,
) -> Judged {
    let magnitudes =
        |m: &Affine, p: [f64; 3]| m.rows.map(|r| (0..3).map(|c| (r[c] * p[c]).abs()).sum::<f64>() + r[3].abs());
    let mut exact = [[0.0; 3]; 3];
    let (mut moved, mut astray) = (0.0f64, false);
    for (k, stored) in record.corners().iter().enumerate() {
        let p = corners[k].map(f64::from);
        exact[k] = to_tree.transform_point(instance.transform.transform_point(p));
        let reach = magnitudes(to_tree, magnitudes(&instance.transform, p));
        let off = [0, 1, 2].map(|a| f64::from(stored[a]) - exact[k][a]);
        moved = moved.max((off[0] * off[0] + off[1] * off[1] + off[2] * off[2]).sqrt());
        astray |= (0..3).any(|a| {
            let stored = f64::from(stored[a]).abs() * 2f64.powi(-24) + f64::from(f32::from_bits(1));
            let of_matrix = if by_matrix { reach[a] * 2f64.powi(-21) } else { 0.0 };
            !(off[a].abs() <= 1.01 * stored + reach[a] * 2f64.powi(-48) + of_matrix)
        });
    }
    let length = |a: usize, b: usize| (0..3).map(|k| (exact[a][k] - exact[b][k]).powi(2)).sum::<f64>().sqrt();
    Judged { moved, edge: length(0, 1).min(length(1, 2)).min(length(2, 0)), astray }
}

/// The triangle with source number `prim` in a part. Within a part source numbers ascend.
fn find(mesh: &Mesh, part: usize, prim: u32) -> Option<usize> {
    let part = mesh.parts.get(part)?;
    let (first, end) = (part.first_triangle as usize, (part.first_triangle + part.triangle_count) as usize);
    if mesh.source_prims.is_empty() {
        return (first..end).contains(&(prim as usize)).then_some(prim as usize);
    }
    mesh.source_prims.get(first..end)?.binary_search(&prim).ok().map(|i| first + i)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Levels, NoProgress, Preset};
    use crate::cache::Image;
    use crate::compile::compile;
    use crate::trace::rays::grid::GridScene;

    fn build(scene: &Scene, levels: Levels) -> Image {
        let options = BuildOptions { levels, ..BuildOptions::preset(Preset::Draft) };
        let exec = Executor::sequential();
        let accel = compile(scene.clone(), &options, &exec, &NoProgress).expect("a tree");
        Image::new(&accel, &exec).expect("an image")
    }

    fn moved(scene: &Scene, by: [f64; 3]) -> Scene {
        let mut scene = scene.clone();
        scene.instances.iter_mut().for_each(|i| i.transform = Affine::translation(by).then_inner(&i.transform));
        scene
    }

    #[test]
    fn a_file_of_its_own_model_is_right_however_it_is_laid_out() {
        for seed in 0..8 {
            let scene = GridScene::new(seed, 0).scene;
            for levels in [Levels::One, Levels::Two, Levels::Auto] {
                let placed = placed(&build(&scene, levels).view(), &scene, &Executor::sequential());
                assert!(placed.is_right() && placed.triangles > 0, "seed {seed}: {placed:?}");
            }
        }
    }

    #[test]
    fn a_corner_that_no_rounding_moved_is_astray() {
        let scene = GridScene::new(3, 0).scene;
        for levels in [Levels::One, Levels::Two] {
            let mut image = build(&scene, levels);
            let corner = &mut image.triangles[5].v1[2];
            *corner += 1.0 + corner.abs() * 1e-3;
            let spoilt = placed(&image.view(), &scene, &Executor::sequential());
            assert!(!spoilt.is_right() && spoilt.astray > 0, "{spoilt:?}");
            let mut image = build(&scene, levels);
            image.triangles[5].prim = 999_999;
            assert!(placed(&image.view(), &scene, &Executor::sequential()).astray > 0);
        }
        let mut image = build(&scene, Levels::Two);
        image.instances[0].world_to_object[3] += 1.0;
        assert!(placed(&image.view(), &scene, &Executor::sequential()).astray > 0);
    }

    #[test]
    fn rounding_that_takes_the_shape_is_told() {
        let point = |k: u32| [0.1 * (k % 11) as f32, 0.03 * (k % 4) as f32, 0.1 * (k / 11) as f32];
        let cell = |c: u32| {
            let a = c / 10 * 11 + c % 10;
            [[a, a + 1, a + 12], [a, a + 12, a + 11]]
        };
        let mesh =
            Mesh::new("sheet", (0..121).map(point).collect(), (0..100).flat_map(cell).collect()).expect("a mesh");
        let scene = moved(&Scene::of_mesh(mesh), [500_123.26, 7.7, -4_649_776.77]);
        let flat = placed(&build(&scene, Levels::One).view(), &scene, &Executor::sequential());
        assert!(!flat.is_right() && flat.astray == 0 && flat.instance == Some(0), "{flat:?}");
        assert!(flat.loss.share > 0.5 && (0.1..0.5).contains(&flat.loss.farthest), "{flat:?}");
        for levels in [Levels::Auto, Levels::Two] {
            let beside = placed(&build(&scene, levels).view(), &scene, &Executor::sequential());
            assert!(beside.is_right() && beside.triangles == 200 && beside.loss.farthest < 1e-6, "{beside:?}");
        }
        let read = Scene { rounding: crate::scene::Rounding { loss: flat.loss, ..Default::default() }, ..scene };
        assert!(!placed(&build(&read, Levels::Auto).view(), &read, &Executor::sequential()).is_right());
    }
}
