//! Scenes on which builders are known to fail, one for each way of failing, in any size.
//!
//! The numbers are those of the list that the scenes were collected in. Those that are missing here are no scenes that stand still:
//! [motions](super::motion), what is [refused](super::refused), and damaged records.

mod built;
mod hostile;
mod odd;
pub(super) mod shapes;

use crate::geom::{Affine, Point};
use crate::scene::{Instance, Mesh, Part, Scene};
use shapes::Soup;

/// A scene, and what it is there for.
#[derive(Clone, Copy, Debug)]
pub struct Failure {
    /// Its number, such as `F01`; a letter or a word behind it tells two of one number apart.
    pub id: &'static str,
    /// In one word.
    pub name: &'static str,
    /// What is known to fail on it, and how.
    pub breaks: &'static str,
    made: Made,
}

#[derive(Clone, Copy, Debug)]
enum Made {
    /// One mesh of triangles without shared vertices.
    Soup(fn(usize) -> Soup),
    /// Anything else.
    Whole(fn(usize) -> Scene),
}

const fn failure(id: &'static str, name: &'static str, soup: fn(usize) -> Soup, breaks: &'static str) -> Failure {
    Failure { id, name, breaks, made: Made::Soup(soup) }
}

const fn whole(id: &'static str, name: &'static str, scene: fn(usize) -> Scene, breaks: &'static str) -> Failure {
    Failure { id, name, breaks, made: Made::Whole(scene) }
}

/// All of them, in the order of their numbers.
pub const FAILURES: [Failure; 36] = [
    failure("F01", "hall", built::hall, "bins on the longest axis: long pieces lie on both sides of every cut"),
    failure("F02", "rotor", built::rotor, "bins on the longest axis: slanted blades have boxes as large as the rotor"),
    failure("F03", "teapot-in-a-stadium", built::teapot_in_a_stadium, "bins over the node's box: one holds all"),
    failure(
        "F04",
        "geometric-series",
        hostile::geometric_series,
        "any recursion: each split parts one triangle from the rest",
    ),
    failure(
        "F05",
        "one-centre",
        hostile::one_centre,
        "object splits and Morton codes: nothing to tell triangles apart by",
    ),
    failure("F06", "identical", hostile::identical, "merging and reinsertion: every choice ties, no split pays"),
    failure("F07", "one-cell", hostile::one_cell, "short Morton codes: nearly all triangles share one"),
    failure("F08", "ball", built::ball, "spatial splits: duplicates for nothing on an even surface"),
    failure("F09", "hairball", built::hairball, "spatial splits and agglomeration: everything overlaps in the middle"),
    failure("F10", "turned-hall", built::turned_hall, "object splits: slanted long pieces overlap everywhere"),
    failure("F11", "roof", built::roof, "boxes along axes: slanted sheets fill theirs like fog"),
    failure("F12", "scaffold", built::scaffold, "boxes along axes: bars at 45° fill theirs like fog"),
    failure(
        "F13",
        "curtain",
        built::curtain,
        "agglomeration: folds lie nearer to each other than to what they go on in",
    ),
    failure("F14", "pillar", built::pillar, "agglomeration: thousands of triangles in a few leaning planes"),
    failure("F15", "one-plane", hostile::one_plane, "box tests: flat boxes, 0 · ∞"),
    failure("F16", "whole-numbers", hostile::whole_numbers, "box tests: rays in planes and through edges and corners"),
    failure("F17", "without-area", hostile::without_area, "the SAH of nothing: 0 / 0"),
    failure("F18-tiny", "denormal", hostile::denormal, "products that vanish: areas of 0, 1 / 0"),
    failure("F19", "below-every-epsilon", hostile::below_every_epsilon, "fixed epsilons: no split makes progress"),
    failure("F20", "needles", hostile::needles, "spatial splits without a budget: references without end"),
    failure("F21", "far-away", hostile::far_away, "f32 planes and Morton codes: one cell, rounded boxes"),
    failure("F22-huge", "huge", hostile::huge, "fixed epsilons"),
    failure("F22-tiny", "tiny", hostile::tiny, "fixed epsilons"),
    whole("F23", "strewn", odd::strewn, "boxes of all vertices: those that no triangle has make the root too large"),
    failure("F24", "few", hostile::few, "unrolled builders: no triangle, or one to five"),
    failure("F25", "stacks", hostile::stacks, "wide nodes: leaves of more triangles than a child can name"),
    failure("F26", "meadow", built::meadow, "agglomeration: a large triangle is dragged into a deep node"),
    failure("F27", "city", built::city, "agglomeration: equal blocks, and pipes across them"),
    failure(
        "F32",
        "arcade",
        built::arcade,
        "exact planes: each cut is the best for itself, and bins are luckier with the next",
    ),
    failure("F33", "lattice", hostile::lattice, "threads and sorting: exact ties everywhere"),
    failure("F34", "on-split-planes", hostile::on_split_planes, "spatial splits: planes on triangles, an empty side"),
    failure("F35", "terrain", built::terrain, "memory: wide, flat, even"),
    failure("F36", "cloud", hostile::cloud, "axes chosen by spread: none is better"),
    failure(
        "F37",
        "almost-parallel",
        hostile::almost_parallel,
        "oriented boxes: bases that differ by rounding alone, ties in every match",
    ),
    failure("F39", "nested", hostile::nested, "order of visits: a ray starts inside every box"),
    whole("F40", "mirrored", odd::mirrored, "instances: mirrored and sheared ones turn windings and lengths"),
];

impl Failure {
    /// The scene that has this number or this name.
    pub fn named(name: &str) -> Option<&'static Failure> {
        FAILURES.iter().find(|failure| [failure.id, failure.name].contains(&name))
    }

    /// Of about so many triangles; `few` has up to five.
    pub fn scene(&self, count: usize) -> Scene {
        match self.made {
            Made::Soup(soup) => scene_of(&soup(count)),
            Made::Whole(scene) => scene(count),
        }
    }

    /// As an OBJ model, the triangles of every instance where they stand.
    pub fn obj(&self, count: usize) -> String {
        let scene = self.scene(count);
        let mut text = format!("# {} {}: {}\no {}\n", self.id, self.name, self.breaks, self.name);
        let mut written = 0;
        for instance in &scene.instances {
            let Some(mesh) = scene.meshes.get(instance.mesh as usize) else { continue };
            for triangle in 0..mesh.triangles.len() {
                for corner in mesh.corners(triangle) {
                    let [x, y, z] = instance.transform.transform_point(corner.map(f64::from)).map(|c| c as f32);
                    text.push_str(&format!("v {x} {y} {z}\n"));
                }
                text.push_str(&format!("f {} {} {}\n", written + 1, written + 2, written + 3));
                written += 3;
            }
        }
        text
    }
}

/// One mesh where it is, each triangle with corners of its own.
pub(super) fn scene_of(soup: &Soup) -> Scene {
    let positions: Vec<Point> = soup.iter().flatten().map(|p| p.map(|c| c as f32)).collect();
    let triangles: Vec<[u32; 3]> = (0..soup.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let count = triangles.len() as u32;
    let parts = vec![Part { triangle_count: count, prim_count: count, ..Part::default() }];
    let mesh = Mesh { positions, triangles, parts, ..Mesh::default() };
    let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
    Scene { meshes: vec![mesh], instances: vec![instance], ..Scene::default() }
}
