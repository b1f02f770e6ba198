//! Rays between any two places of a scene that see each other: what a tree meets whatever the view.

use super::bounce::{Struck, bounces, camera_rays, strike, toward_occluders};
use super::world::World;
use super::{CHUNK, Camera};
use crate::cache::View;
use crate::exec::Executor;
use crate::geom::Ray;
use crate::geom::vector::dot;
use crate::random::Random;

/// Eyes on each ray that crosses the space.
const EYES: usize = 4;
/// Eyes stand no farther than this share of the scene's diagonal from what they were found by.
const FARTHEST_EYE: f64 = 0.5;

/// About `count` rays in each of three sets, each cut off where it hits.
///
/// Light that bounces off what the four [cameras](Camera::around) see crosses the space in which cameras can stand. So eyes are put at
/// random points of such rays and look in random directions; the other sets are one cosine-weighted bounce off what the eyes see, and
/// occlusion from there. A ray ends at its closest hit, also where any would do, so it meets the boxes that a traversal which went
/// straight to its hit would look into. Nothing depends on the tree of `view`. Empty where the cameras see nothing.
pub fn everywhere(view: &View<'_>, count: usize, exec: &Executor) -> Vec<Ray> {
    let world = &World::new(view);
    let diagonal = world.diagonal();
    let mut random = Random::new(11);
    let few = count.div_ceil(EYES);
    let (_, seen) = cut_off(world, camera_rays(&Camera::around(view), few), exec);
    let (light, _) = cut_off(world, bounces(&seen, few, diagonal, &mut random), exec);

    let eyes = light.iter().cycle().take(if light.is_empty() { 0 } else { count }).map(|ray| {
        let d = ray.direction.map(f64::from);
        let reach = f64::from(ray.t_max).min(FARTHEST_EYE * diagonal / dot(d, d).sqrt()) * random.unit();
        let eye = [0, 1, 2].map(|k| (f64::from(ray.origin[k]) + reach * d[k]) as f32);
        Ray::new(eye, random.direction().map(|c| c as f32))
    });
    let (primary, seen) = cut_off(world, eyes.collect(), exec);
    let (diffuse, _) = cut_off(world, bounces(&seen, count, diagonal, &mut random), exec);
    let occlusion = bounces(&seen, count, diagonal, &mut random);
    let occlusion = occlusion.into_iter().map(|ray| toward_occluders(ray, diagonal)).collect();
    let (occlusion, _) = cut_off(world, occlusion, exec);
    [primary, diffuse, occlusion].concat()
}

/// The rays up to what they hit, and what that is.
fn cut_off(world: &World<'_>, mut rays: Vec<Ray>, exec: &Executor) -> (Vec<Ray>, Vec<Struck>) {
    let struck = exec.map_chunks_mut(&mut rays, CHUNK, |_, chunk| {
        let mut struck = Vec::new();
        for ray in chunk {
            if let Some(surface) = strike(world, ray) {
                ray.t_max = surface.t;
                struck.push(surface);
            }
        }
        struck
    });
    (rays, struck.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, Method, Preset};
    use crate::cache::Image;
    use crate::trace::closest_hit;
    use crate::trace::probe::tests::cube;

    #[test]
    fn rays_end_where_they_hit_and_depend_on_no_thread_and_no_tree() {
        let draft = cube(&BuildOptions::preset(Preset::Draft));
        let rays = everywhere(&draft.view(), 500, &Executor::sequential());
        assert!(rays.len() > 1400, "{}", rays.len());
        for ray in &rays[..rays.len() * 2 / 3] {
            assert!(ray.origin.iter().all(|c| c.abs() <= 1.0) && ray.t_max.is_finite(), "{ray:?}");
            assert_eq!(
                closest_hit(&draft.view(), &ray.until(f32::INFINITY)).unwrap().map(|hit| hit.t),
                Some(ray.t_max)
            );
        }
        let other = BuildOptions { method: Method::Agglomerative, max_leaf: 1, ..BuildOptions::preset(Preset::Draft) };
        assert_eq!(rays, everywhere(&cube(&other).view(), 500, &Executor::new(3).unwrap()));
    }

    #[test]
    fn nothing_to_see() {
        assert!(everywhere(&Image::default().view(), 100, &Executor::sequential()).is_empty());
    }
}
