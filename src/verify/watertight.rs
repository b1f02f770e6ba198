//! Watertightness: from inside of a closed mesh no ray gets out.
//!
//! A mesh is closed if every edge belongs to an even number of triangles. Whoever crosses an odd number of triangles on the way out is then inside: each
//! ray from there meets a triangle, if edges and corners belong to them. So rays are shot where cracks would be, at vertices, at
//! middles of edges and at other points of edges, by any [`Device`].

use super::device::{Device, DeviceError, Query};
use crate::exec::Executor;
use crate::geom::{Point, Ray};
use crate::random::Random;
use crate::scene::Mesh;
use crate::trace::exact::{Ratio, meet};
use std::cmp::Ordering;

/// Edges that belong to an odd number of triangles, by their ends' positions: none in a closed mesh.
///
/// # Panics
/// Where the mesh is not sound: [`Mesh::validate`] finds that.
pub fn open_edges(mesh: &Mesh) -> Vec<[Point; 2]> {
    // -0.0 becomes +0.0, so that equal places have equal bits.
    let bits = |p: Point| p.map(|c| (c + 0.0).to_bits());
    let mut edges: Vec<[[u32; 3]; 2]> = Vec::with_capacity(3 * mesh.triangles.len());
    for i in 0..mesh.triangles.len() {
        let c = mesh.corners(i).map(bits);
        let ends = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| [c[a].min(c[b]), c[a].max(c[b])]);
        edges.extend(ends.into_iter().filter(|[a, b]| a != b));
    }
    edges.sort_unstable();
    let odd = edges.chunk_by(|a, b| a == b).filter(|run| run.len() % 2 == 1);
    odd.map(|run| run[0].map(|p| p.map(f32::from_bits))).collect()
}

/// Close a mesh with triangles from every open edge to one point, the middle of all open edges.
///
/// Every vertex has an even number of open edges, so the new edges come in pairs too.
///
/// # Panics
/// Where the mesh is not sound: [`Mesh::validate`] finds that.
pub fn close(mesh: &mut Mesh) {
    let open = open_edges(mesh);
    let count = 2.0 * open.len() as f64;
    let sum = open.iter().flatten().fold([0.0; 3], |s, p| [0, 1, 2].map(|a| s[a] + f64::from(p[a])));
    let apex = sum.map(|s| (s / count) as f32);
    for [a, b] in open {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([a, b, apex]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
}

/// Whether a point is inside of a closed mesh: a ray from it crosses an odd number of triangles. Decided exactly; `None` where the
/// ray of that direction touches an edge, or starts on a triangle.
fn is_inside(mesh: &Mesh, point: Point, direction: Point, exec: &Executor) -> Option<bool> {
    let ray = Ray::new(point, direction);
    let crosses = |corners: [Point; 3]| {
        let Some(meeting) = meet(&ray, corners) else { return Some(false) };
        if meeting.t.compare(0.0) == Some(Ordering::Less) {
            return Some(false);
        }
        let is_zero = |v: &Ratio| v.compare(0.0) == Some(Ordering::Equal);
        let touches = [&meeting.t, &meeting.u, &meeting.v, &meeting.w].into_iter().any(is_zero);
        (!touches).then_some(true)
    };
    let parts = exec.map_chunks(&mesh.triangles, CHUNK, |chunk_index, chunk| {
        let mut triangles = (0..chunk.len()).map(|i| crosses(mesh.corners(chunk_index * CHUNK + i)));
        triangles.try_fold(false, |odd, crosses| Some(odd != crosses?))
    });
    parts.into_iter().try_fold(false, |odd, part| Some(odd != part?))
}

/// Triangles that a task looks at.
const CHUNK: usize = 1 << 8;

/// Points inside of a closed mesh, found by trying points of its box: up to `count`, fewer where the mesh has hardly any inside.
///
/// Coordinates have few bits, so that directions from them to vertices are often exact.
///
/// # Panics
/// Where the mesh is not sound: [`Mesh::validate`] finds that.
pub fn eyes_inside(mesh: &Mesh, count: usize, seed: u64, exec: &Executor) -> Vec<Point> {
    let mut random = Random::new(seed);
    let bounds = (0..mesh.triangles.len()).map(|i| mesh.triangle_box(i)).reduce(|a, b| a.union(b));
    let Some(bounds) = bounds else { return Vec::new() };
    let extent = bounds.extent().into_iter().fold(0.0, f32::max);
    let step = extent / 1024.0;
    let step = f32::from_bits(step.max(f32::MIN_POSITIVE).to_bits() & 0x7F80_0000);
    let mut eyes = Vec::new();
    for _ in 0..64 * count {
        let point = [0, 1, 2].map(|a| {
            let v = bounds.min[a] + (bounds.max[a] - bounds.min[a]) * random.unit() as f32;
            (v / step).round() * step
        });
        let direction = random.direction().map(|d| d as f32);
        if eyes.len() < count && is_inside(mesh, point, direction, exec) == Some(true) {
            eyes.push(point);
        }
    }
    eyes
}

/// What came of shooting at cracks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Escapes {
    /// How many were traced.
    pub rays: u64,
    /// How many met nothing, though the mesh is closed around their start.
    pub escaped: u64,
    /// The first that got out, and what was asked.
    pub first: Option<(Ray, Query)>,
}

/// Rays in memory at once, and rays that share a seed.
const BATCH: u64 = 1 << 18;
const UNIT: u64 = 1 << 12;

/// Trace `count` rays from `eyes` at edges and vertices of `mesh` on a device; batches alternate between closest and any hit.
///
/// The device traces the closed mesh, in world space. Without eyes or triangles there are no rays.
pub fn escapes(
    device: &mut dyn Device,
    mesh: &Mesh,
    eyes: &[Point],
    count: u64,
    seed: u64,
    exec: &Executor,
) -> Result<Escapes, DeviceError> {
    let mut out = Escapes::default();
    if eyes.is_empty() || mesh.triangles.is_empty() {
        return Ok(out);
    }
    for (number, first) in (0..count).step_by(BATCH as usize).enumerate() {
        let units: Vec<u64> = (first / UNIT..(first + BATCH).min(count).div_ceil(UNIT)).collect();
        let rays = exec.map(units, |_, unit| {
            let mut random = Random::new(Random::new(seed ^ unit << 20).bits());
            let size = UNIT.min(count - unit * UNIT) as usize;
            (0..size).map(|_| aim(mesh, eyes, &mut random)).collect::<Vec<_>>()
        });
        let rays = rays.concat();
        let query = if number % 2 == 0 { Query::Closest } else { Query::Any };
        let records = device.trace(&rays, query)?;
        for (ray, record) in rays.iter().zip(&records) {
            out.rays += 1;
            if !record.is_hit() {
                out.escaped += 1;
                out.first.get_or_insert((*ray, query));
            }
        }
    }
    Ok(out)
}

/// From an eye at a corner, the middle of an edge or some point of an edge, exactly where `f32` can say so.
fn aim(mesh: &Mesh, eyes: &[Point], random: &mut Random) -> Ray {
    let eye = eyes[random.below(eyes.len() as u64) as usize];
    let corners = mesh.corners(random.below(mesh.triangles.len() as u64) as usize);
    let first = random.below(3) as usize;
    let (a, b) = (corners[first].map(f64::from), corners[(first + 1) % 3].map(f64::from));
    let from = eye.map(f64::from);
    let part = random.unit();
    let direction = match random.below(3) {
        0 => [0, 1, 2].map(|k| a[k] - from[k]),
        1 => [0, 1, 2].map(|k| a[k] + b[k] - 2.0 * from[k]),
        _ => [0, 1, 2].map(|k| a[k] + part * (b[k] - a[k]) - from[k]),
    };
    let direction = direction.map(|d| d as f32);
    Ray::new(eye, if direction == [0.0; 3] { [0.0, 0.0, 1.0] } else { direction })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress};
    use crate::cache::Image;
    use crate::compile::compile;
    use crate::geom::Affine;
    use crate::scene::{Instance, Scene};
    use crate::verify::Cpu;

    static EXEC: Executor = Executor::sequential();

    /// An octahedron, closed.
    fn octahedron() -> Mesh {
        let mut mesh = Mesh::default();
        for corner in 0..8 {
            let signs = [0, 1, 2].map(|a| if corner >> a & 1 == 0 { 1.0f32 } else { -1.0 });
            let first = mesh.positions.len() as u32;
            mesh.positions.extend([[signs[0], 0.0, 0.0], [0.0, signs[1], 0.0], [0.0, 0.0, signs[2]]]);
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        mesh
    }

    fn shoot(mesh: &Mesh, eyes: &[Point], count: u64) -> Escapes {
        let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
        let scene = Scene { meshes: vec![mesh.clone()], instances: vec![instance], ..Scene::default() };
        let accel = compile(scene, &BuildOptions::default(), &EXEC, &NoProgress).expect("a tree");
        let image = Image::new(&accel, &EXEC).unwrap();
        escapes(&mut Cpu::new(image.view(), &EXEC), mesh, eyes, count, 1, &EXEC).expect("a walk")
    }

    #[test]
    fn a_hole_is_seen_as_open_edges_and_as_escapes() {
        let mut mesh = octahedron();
        assert!(open_edges(&mesh).is_empty());
        let eyes = eyes_inside(&mesh, 8, 3, &EXEC);
        assert_eq!(eyes.len(), 8);
        assert!(eyes.iter().all(|p| p.iter().map(|c| c.abs()).sum::<f32>() < 1.0));
        assert_eq!(shoot(&mesh, &eyes, 10_000), Escapes { rays: 10_000, ..Escapes::default() });

        // Through the hole the rays at its edges still hit the neighbours, but those at the lost triangle's own vertex do not.
        mesh.triangles.truncate(5);
        assert_eq!(open_edges(&mesh).len(), 5);
        assert!(shoot(&octahedron(), &eyes, 1000).escaped == 0);
        let through = escapes_of(&mesh, &octahedron(), &eyes);
        assert!(through.escaped > 0 && through.first.is_some(), "{through:?}");

        // A cap over the hole, and it is tight again.
        close(&mut mesh);
        assert!(open_edges(&mesh).is_empty());
        let eyes = eyes_inside(&mesh, 8, 3, &EXEC);
        assert_eq!(shoot(&mesh, &eyes, 10_000).escaped, 0);
    }

    /// Rays at all edges of `whole` through a tree over `part` of it.
    fn escapes_of(part: &Mesh, whole: &Mesh, eyes: &[Point]) -> Escapes {
        let instance = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
        let scene = Scene { meshes: vec![part.clone()], instances: vec![instance], ..Scene::default() };
        let accel = compile(scene, &BuildOptions::default(), &EXEC, &NoProgress).expect("a tree");
        let image = Image::new(&accel, &EXEC).unwrap();
        escapes(&mut Cpu::new(image.view(), &EXEC), whole, eyes, 10_000, 1, &EXEC).expect("a walk")
    }

    #[test]
    fn inside_is_told_from_outside_and_an_edge_is_no_answer() {
        let mesh = octahedron();
        assert_eq!(is_inside(&mesh, [0.1, 0.2, 0.3], [1.0, 0.3, 0.2], &EXEC), Some(true));
        assert_eq!(is_inside(&mesh, [0.5, 0.5, 0.5], [1.0, 0.3, 0.2], &EXEC), Some(false));
        assert_eq!(is_inside(&mesh, [-2.0, 0.1, 0.2], [1.0, 0.01, 0.02], &EXEC), Some(false));
        assert_eq!(is_inside(&mesh, [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], &EXEC), None);
        assert_eq!(is_inside(&mesh, [0.0, 0.25, 0.0], [1.0, 0.0, 0.0], &EXEC), None);
    }

    #[test]
    fn no_eyes_no_rays() {
        assert_eq!(shoot(&octahedron(), &[], 100), Escapes::default());
    }
}
