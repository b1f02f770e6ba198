//! [`Standpoint`]: where a picture is taken from, by name, or by what can be seen from there.

use super::lens::Lens;
use crate::cache::{TriangleRecord, View};
use crate::exec::Executor;
use crate::geom::vector::{cross, dot, sub};
use crate::geom::{Aabb, Affine, Ray};
use crate::trace::any_hit;
use crate::trace::probe::{Camera, subject};

/// A place to look at a scene from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standpoint {
    /// Inside or outside, from where the most is seen.
    Auto,
    /// From where the most is seen between the walls.
    Inside,
    /// From where the most is seen around the scene.
    Outside,
    /// From the side that z points to.
    Front,
    /// Against z.
    Back,
    /// Against x.
    Left,
    /// From the side that x points to.
    Right,
    /// From above.
    Top,
    /// From below.
    Bottom,
}

impl Standpoint {
    /// In the order in which help lists them.
    pub const ALL: [Standpoint; 9] = [
        Standpoint::Auto,
        Standpoint::Inside,
        Standpoint::Outside,
        Standpoint::Front,
        Standpoint::Back,
        Standpoint::Left,
        Standpoint::Right,
        Standpoint::Top,
        Standpoint::Bottom,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Standpoint::Auto => "auto",
            Standpoint::Inside => "inside",
            Standpoint::Outside => "outside",
            Standpoint::Front => "front",
            Standpoint::Back => "back",
            Standpoint::Left => "left",
            Standpoint::Right => "right",
            Standpoint::Top => "top",
            Standpoint::Bottom => "bottom",
        }
    }

    /// The camera there, for a film of this size; `up` is the axis, 0 to 2, that points up. Directions are those of a scene with y up: with z up
    /// the front is against y.
    ///
    /// Where nearly all triangles crowd in a small part of the scene, that part is what is looked at.
    pub fn camera(self, view: &View<'_>, up: usize, film: [usize; 2], exec: &Executor) -> Camera {
        let stage = Stage::new(subject(view), up, film);
        let toward = match self {
            Standpoint::Auto => return stage.best(view, &[stage.around(), stage.within()].concat(), exec),
            Standpoint::Inside => return stage.best(view, &stage.within(), exec),
            Standpoint::Outside => return stage.best(view, &stage.around(), exec),
            Standpoint::Front => [0.0, 0.0, 1.0],
            Standpoint::Back => [0.0, 0.0, -1.0],
            Standpoint::Left => [-1.0, 0.0, 0.0],
            Standpoint::Right => [1.0, 0.0, 0.0],
            Standpoint::Top => [0.0, 1.0, 0.0],
            Standpoint::Bottom => [0.0, -1.0, 0.0],
        };
        stage.outside(toward)
    }
}

/// What is looked at, which way is up, and the film.
struct Stage {
    subject: Aabb,
    /// The axes to the right, up, and toward who stands in front, as columns of a turn.
    axes: [[f64; 3]; 3],
    film: [usize; 2],
}

/// Tangent of half the angle of view of every camera here.
const TAN_HALF: f64 = 0.6;
/// Directions in which a camera looks, or from which it does.
const ROUND: usize = 8;
/// Triangles that are asked whether they are seen.
const ASKED: usize = 1024;
/// What is nearer than this share of the diagonal fills the picture and shows nothing.
const TOO_NEAR: f64 = 0.02;
/// What a triangle seen from behind counts: less, so that nobody looks at a solid thing from within.
const BEHIND: f64 = 0.25;

impl Stage {
    fn new(subject: Aabb, up: usize, film: [usize; 2]) -> Stage {
        let axes = match up {
            0 => [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
            2 => [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]],
            _ => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        };
        Stage { subject, axes, film }
    }

    /// From the scene's directions to the world's.
    fn turned(&self, v: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| (0..3).map(|axis| v[axis] * self.axes[axis][k]).sum())
    }

    fn middle(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| 0.5 * (f64::from(self.subject.min[k]) + f64::from(self.subject.max[k])))
    }

    fn diagonal(&self) -> f64 {
        let extent = self.subject.extent().map(f64::from);
        dot(extent, extent).sqrt()
    }

    /// Looking at the middle from `toward`, as near as the whole subject fits the film.
    fn outside(&self, toward: [f64; 3]) -> Camera {
        let (toward, middle) = (self.turned(toward), self.middle());
        let camera = |distance: f64| Camera {
            eye: [0, 1, 2].map(|k| middle[k] + distance * toward[k]),
            look_at: middle,
            up: self.axes[1],
            tan_half: TAN_HALF,
        };
        // From the middle itself, a corner is as far to the side and ahead as it stays when the eye steps back.
        let lens =
            Lens::new(&Camera { eye: middle, look_at: sub(middle, toward), ..camera(0.0) }, self.film[0], self.film[1]);
        let tangents = lens.tangents();
        let corners = (0..8).map(|i| [0, 1, 2].map(|k| f64::from([self.subject.min, self.subject.max][i >> k & 1][k])));
        let far_enough = corners.map(|corner| {
            let [right, above, ahead] = lens.seen_from_eye(corner);
            (right.abs() / tangents[0]).max(above.abs() / tangents[1]) - ahead
        });
        let distance = far_enough.fold(0.0, f64::max);
        camera(if distance > 0.0 { 1.04 * distance } else { 1.0 })
    }

    /// Around the subject, a little and well above it.
    fn around(&self) -> Vec<Camera> {
        let rings = [0.3f64, 0.75].into_iter().flat_map(|above| directions().map(move |d| (above, d)));
        rings
            .map(|(above, [x, z])| {
                let length = (1.0 + above * above).sqrt();
                self.outside([x, above, z].map(|c| c / length))
            })
            .collect()
    }

    /// At places all over the subject's box, looking to all sides.
    fn within(&self) -> Vec<Camera> {
        const ALONG: [f64; 4] = [0.12, 0.37, 0.63, 0.88];
        const ABOVE: [f64; 3] = [0.2, 0.4, 0.7];
        let (middle, extent) = (self.middle(), self.subject.extent().map(f64::from));
        let place = |share: [f64; 3]| {
            let offset = self.turned(share.map(|s| s - 0.5));
            [0, 1, 2].map(|k| middle[k] + offset[k] * extent[k])
        };
        let shares = ABOVE.into_iter().flat_map(|y| ALONG.into_iter().flat_map(move |z| ALONG.map(|x| [x, y, z])));
        let reach = self.diagonal().max(f64::MIN_POSITIVE);
        let looking = |eye: [f64; 3]| {
            directions().map(move |[x, z]| {
                let ahead = self.turned([x, 0.0, z]);
                Camera {
                    eye,
                    look_at: [0, 1, 2].map(|k| eye[k] + reach * ahead[k]),
                    up: self.axes[1],
                    tan_half: TAN_HALF,
                }
            })
        };
        shares.flat_map(|share| looking(place(share)).collect::<Vec<_>>()).collect()
    }

    /// The camera that frames most of the triangles that its eye sees; the first of equals. Cameras with one eye stand together.
    fn best(&self, view: &View<'_>, cameras: &[Camera], exec: &Executor) -> Camera {
        let (spots, near) = (spots(view), TOO_NEAR * self.diagonal());
        let eyes: Vec<&[Camera]> = cameras.chunk_by(|a, b| a.eye == b.eye).collect();
        let scores = exec.map_chunks(&eyes, 1, |_, group| {
            let cameras = group[0];
            let seen: Vec<(f64, [f64; 3])> =
                spots.iter().filter_map(|spot| spot.worth(view, cameras[0].eye, near)).collect();
            let score = |camera: &Camera| {
                let lens = Lens::new(camera, self.film[0], self.film[1]);
                seen.iter().filter(|(_, point)| lens.frames(*point)).map(|(worth, _)| worth).sum::<f64>()
            };
            cameras.iter().map(score).collect::<Vec<f64>>()
        });
        let scored = scores.concat().into_iter().zip(cameras);
        let first = (0.0, self.outside([0.48, 0.36, 0.8]));
        scored.fold(first, |best, (score, camera)| if score > best.0 { (score, *camera) } else { best }).1
    }
}

/// All around, as shares of x and z: first from the corner between front and right.
fn directions() -> impl Iterator<Item = [f64; 2]> {
    const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let all: [[f64; 2]; ROUND] =
        [[HALF, HALF], [-HALF, HALF], [HALF, -HALF], [-HALF, -HALF], [0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]];
    all.into_iter()
}

/// A point of the surface, and which way it faces.
struct Spot {
    point: [f64; 3],
    normal: [f64; 3],
}

impl Spot {
    /// What it counts for an eye, if that sees it.
    fn worth(&self, view: &View<'_>, eye: [f64; 3], near: f64) -> Option<(f64, [f64; 3])> {
        let way = sub(self.point, eye);
        let ray = Ray::new(eye.map(|c| c as f32), way.map(|c| c as f32)).until(0.999);
        let is_hidden = dot(way, way) < near * near || any_hit(view, &ray) != Ok(false);
        let worth = if dot(way, self.normal) < 0.0 { 1.0 } else { BEHIND };
        (!is_hidden).then_some((worth, self.point))
    }
}

/// The centres of about [`ASKED`] triangles, the same ones whatever the trees: as many of each instance, or of some of them.
fn spots(view: &View<'_>) -> Vec<Spot> {
    let of_tree = |number: usize, count: usize| -> Vec<[[f32; 3]; 3]> {
        let (Some(tree), Some(record)) = (view.blas(number), view.blases.get(number)) else { return Vec::new() };
        let step = (record.prim_count as usize).div_ceil(count.max(1)).max(1);
        let is_asked = |t: &&TriangleRecord| (t.prim as usize).is_multiple_of(step);
        let mut asked: Vec<&TriangleRecord> = tree.triangles.iter().filter(is_asked).collect();
        asked.sort_unstable_by_key(|t| (t.geom, t.prim));
        asked.dedup_by_key(|t| (t.geom, t.prim));
        asked.into_iter().map(TriangleRecord::corners).collect()
    };
    if view.instances.is_empty() {
        let count = ASKED.div_ceil(view.blases.len().max(1));
        let all = (0..view.blases.len()).flat_map(|number| of_tree(number, count));
        return all.map(|corners| spot(corners, &Affine::IDENTITY)).collect();
    }
    let step = view.instances.len().div_ceil(ASKED);
    let mut order: Vec<&crate::cache::InstanceRecord> = view.instances.iter().collect();
    order.sort_unstable_by_key(|instance| instance.id);
    let chosen = || order.iter().step_by(step);
    let count = ASKED.div_ceil(chosen().count().max(1));
    let mut trees = std::collections::BTreeMap::new();
    for instance in chosen() {
        trees.entry(instance.blas).or_insert_with(|| of_tree(instance.blas as usize, count));
    }
    let of_instance = |(turn, instance): (usize, &&crate::cache::InstanceRecord)| {
        let place = Affine::from_f32(&instance.object_to_world);
        let tree = trees.get(&instance.blas).map_or(&[][..], |tree| tree);
        // Where a tree gives more than its share, each instance shows others of its triangles.
        let some = tree.iter().cycle().skip(turn % tree.len().max(1)).take(count.min(tree.len()));
        some.map(|corners| spot(*corners, &place)).collect::<Vec<Spot>>()
    };
    chosen().enumerate().flat_map(of_instance).collect()
}

fn spot(corners: [[f32; 3]; 3], place: &Affine) -> Spot {
    let [a, b, c] = corners.map(|p| place.transform_point(p.map(f64::from)));
    let mirror = if place.mirrors() { -1.0 } else { 1.0 };
    let normal = cross(sub(b, a), sub(c, a)).map(|v| v * mirror);
    Spot { point: [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0), normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress, Preset, initial_tree};
    use crate::cache::Image;
    use crate::scene::Mesh;

    /// Boxes of 12 triangles each; the sign says whether they face outward.
    fn boxes(all: &[([f32; 3], [f32; 3], bool)]) -> Image {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for (min, max, outward) in all {
            let first = positions.len() as u32;
            positions.extend((0..8usize).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { min[k] } else { max[k] })));
            let quads: [[u32; 4]; 6] =
                [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
            for [a, b, c, d] in quads.map(|quad| quad.map(|i| first + i)) {
                let two = if *outward { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                triangles.extend(two);
            }
        }
        let mesh = Mesh::new("", positions, triangles).unwrap();
        let exec = Executor::sequential();
        let tree = initial_tree(&mesh, &BuildOptions::preset(Preset::Draft), &exec, &NoProgress).unwrap();
        Image::of_tree(&mesh, &tree, &exec).unwrap()
    }

    fn taken(image: &Image, standpoint: Standpoint) -> Camera {
        let camera = standpoint.camera(&image.view(), 1, [320, 200], &Executor::sequential());
        assert_eq!(camera, standpoint.camera(&image.view(), 1, [320, 200], &Executor::new(3).unwrap()));
        camera
    }

    fn is_inside(camera: &Camera, min: [f64; 3], max: [f64; 3]) -> bool {
        (0..3).all(|k| camera.eye[k] > min[k] && camera.eye[k] < max[k])
    }

    #[test]
    fn a_solid_thing_is_seen_outside_and_whole() {
        let image = boxes(&[([-1.0; 3], [1.0; 3], true)]);
        let camera = taken(&image, Standpoint::Auto);
        assert!(!is_inside(&camera, [-1.0; 3], [1.0; 3]), "{camera:?}");
        let lens = Lens::new(&camera, 320, 200);
        for i in 0..8 {
            assert!(lens.frames([0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 })));
        }
    }

    /// A room with furniture, in a hull with a wall of its own thickness between the two.
    #[test]
    fn a_furnished_room_is_seen_from_within_and_not_from_its_wall() {
        let mut all =
            vec![([-12.0, -6.0, -12.0], [12.0, 6.0, 12.0], true), ([-8.0, -3.0, -8.0], [8.0, 3.0, 8.0], false)];
        all.extend((0..30u8).map(|i| {
            let (x, z) = (f32::from(i % 6) * 2.4 - 6.5, f32::from(i / 6) * 2.4 - 5.5);
            ([x, -3.0, z], [x + 0.5, -2.0, z + 0.5], true)
        }));
        let image = boxes(&all);
        let camera = taken(&image, Standpoint::Auto);
        assert!(is_inside(&camera, [-8.0, -3.0, -8.0], [8.0, 3.0, 8.0]), "{camera:?}");
        assert_eq!(camera, taken(&image, Standpoint::Inside));
        assert!(!is_inside(&taken(&image, Standpoint::Outside), [-12.0, -6.0, -12.0], [12.0, 6.0, 12.0]));
    }

    #[test]
    fn names_are_directions_and_up_may_be_another_axis() {
        let image = boxes(&[([0.0; 3], [1.0, 2.0, 3.0], true)]);
        let front = taken(&image, Standpoint::Front);
        assert!(front.eye[2] > 3.0 && front.eye[0] == 0.5 && front.eye[1] == 1.0, "{front:?}");
        let top = Standpoint::Top.camera(&image.view(), 2, [100, 100], &Executor::sequential());
        assert!(top.eye[2] > 3.0 && top.up == [0.0, 0.0, 1.0], "{top:?}");
        let names: std::collections::BTreeSet<_> = Standpoint::ALL.map(Standpoint::name).into();
        assert_eq!(names.len(), Standpoint::ALL.len());
    }

    #[test]
    fn nothing_to_see() {
        let image = Image::default();
        for standpoint in Standpoint::ALL {
            assert!(taken(&image, standpoint).eye.iter().all(|c| c.is_finite()), "{standpoint:?}");
        }
    }
}
