//! [`Shot`]: the scene seen through a lens: what each pixel's ray hits, and the work that it caused.

use super::depths::Depths;
use super::lens::Lens;
use crate::cache::View;
use crate::exec::Executor;
use crate::geom::vector::{cross, dot, sub};
use crate::trace::probe::World;
use crate::trace::{Counters, Malformed, try_closest_hit};

/// A picture before it has colours: a pixel a ray, row by row from the upper left corner.
#[derive(Clone, Debug)]
pub struct Shot {
    /// The camera and the film.
    pub lens: Lens,
    /// `width` × `height` of them.
    pub pixels: Vec<Pixel>,
}

/// What one ray found, and what it took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Nothing where the ray left the scene.
    pub seen: Option<Seen>,
    /// Inner nodes that the ray entered, on both levels.
    pub visits: u32,
    /// Triangles that it was tested with.
    pub tests: u32,
}

/// A hit as a picture needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Distance along the view.
    pub depth: f32,
    /// Of the triangle, of length 1 and on the eye's side; all zero where the triangle has none.
    pub normal: [f32; 3],
    /// Row of `GEOM`.
    pub part: u32,
    /// Number of the triangle in its source mesh.
    pub prim: u32,
    /// Number of the instance in the scene's order; 0 in a file of one level.
    pub instance: u32,
    /// Steps from the root to the leaf that holds the triangle, on both levels.
    pub leaf_depth: u32,
}

/// Rows of pixels that a task traces. A constant, so that nothing depends on the number of threads.
const ROWS: usize = 4;

impl Shot {
    /// Trace a ray through the middle of each pixel.
    ///
    /// # Errors
    /// Where the records are no tree.
    pub fn take(view: &View<'_>, lens: &Lens, exec: &Executor) -> Result<Shot, Malformed> {
        let (world, depths) = (World::new(view), Depths::of(view)?);
        let rows: Vec<usize> = (0..lens.height).collect();
        let parts = exec.map_chunks(&rows, ROWS, |_, rows| -> Result<Vec<Pixel>, Malformed> {
            let places = rows.iter().flat_map(|y| (0..lens.width).map(move |x| (x, *y)));
            places.map(|(x, y)| look(&world, &depths, lens, x as f64 + 0.5, y as f64 + 0.5)).collect()
        });
        let mut pixels = Vec::with_capacity(lens.width * lens.height);
        for part in parts {
            pixels.extend(part?);
        }
        Ok(Shot { lens: *lens, pixels })
    }
}

fn look(world: &World<'_>, depths: &Depths, lens: &Lens, x: f64, y: f64) -> Result<Pixel, Malformed> {
    let ray = lens.ray(x, y);
    let mut work = Counters::default();
    let hit = try_closest_hit(world.view, &ray, &mut work)?;
    let seen = hit.map(|hit| {
        let [a, b, c] = world.corners(&hit);
        let n = cross(sub(b, a), sub(c, a));
        let length = dot(n, n).sqrt();
        let away = dot(n, ray.direction.map(f64::from)) > 0.0;
        let k = if length > 0.0 { if away { -1.0 / length } else { 1.0 / length } } else { 0.0 };
        Seen {
            depth: hit.t,
            normal: n.map(|v| (v * k) as f32),
            part: hit.geom,
            prim: hit.prim,
            instance: hit.instance.unwrap_or(0),
            leaf_depth: depths.of_hit(&hit),
        }
    });
    let few = |count: u64| u32::try_from(count).unwrap_or(u32::MAX);
    Ok(Pixel { seen, visits: few(work.inner_nodes), tests: few(work.triangles) })
}
