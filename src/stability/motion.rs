//! Motions that trees are known to fail on: every frame is judged, and what rays cost in it is held beside trees that are built for it.

use super::scenes::scene_of;
use super::scenes::shapes::{Point, Soup, add, bar, scale, sheet};
use crate::build::{BuildOptions, Method, NoProgress, Preset};
use crate::cache::{self, Codec, Sequence};
use crate::compile::build_tree;
use crate::exec::Executor;
use crate::random::Random;
use crate::report::frames::{Measure, SequenceReport};
use crate::scene::{Mesh, ReadReport, Scene};
use crate::sequence::{FrameLabel, Refit, RefitPolicy, SequenceBuilder};
use crate::trace::brute::Oracle;
use crate::trace::compare::compare;
use crate::trace::probe::{Camera, ProbeRays};
use crate::trace::rays::Sampler;
use crate::tree::{Tree, refit_on};
use serde::Serialize;
use std::f64::consts::FRAC_1_SQRT_2;

/// A mesh that moves, and what it is there for.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Its number in the list of failures.
    pub id: &'static str,
    /// In one word.
    pub name: &'static str,
    /// What is known to fail on it, and how.
    pub breaks: &'static str,
    /// How many frames it has.
    pub frames: usize,
    soup: fn(usize, usize) -> Soup,
    /// In which order a frame lists its triangles' corners.
    shuffled: bool,
    /// Most trees that may be built for all frames, and the most that rays may cost in any of them, by the policy that is the default.
    pub gate: (u64, f64),
}

const fn motion(
    id: &'static str,
    name: &'static str,
    (frames, soup): (usize, fn(usize, usize) -> Soup),
    gate: (u64, f64),
    breaks: &'static str,
) -> Motion {
    Motion { id, name, breaks, frames, soup, shuffled: false, gate }
}

/// All of them, in the order of their numbers.
pub const MOTIONS: [Motion; 6] = [
    motion(
        "F02-turning",
        "turning-rotor",
        (5, turning),
        (5, 1.3),
        "bins on the longest axis: cost jumps with where the blades stand",
    ),
    motion(
        "F28",
        "explosion",
        (16, explosion),
        (14, 1.6),
        "refitting: what was near is far, and every box holds everything",
    ),
    Motion {
        shuffled: true,
        ..motion(
            "F28-shuffled",
            "shuffled-vertices",
            (6, drift),
            (6, 1.1),
            "refitting by the numbers of vertices: they are others in each frame, so trees are built",
        )
    },
    motion(
        "F28-walk",
        "random-walk",
        (16, random_walk),
        (16, 1.3),
        "refitting: cost grows from frame to frame without a jump to notice it by",
    ),
    motion(
        "F30",
        "come-and-go",
        (7, come_and_go),
        (3, 1.3),
        "refitting: triangles that were not there, in places of others",
    ),
    motion(
        "F31",
        "gait",
        (18, gait),
        (6, 1.6),
        "rebuilding above a threshold: what comes back is built again and again",
    ),
];

/// What became of a motion by one policy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionRow {
    /// `auto`, `always` or `never`: whether trees are refitted.
    pub refit: &'static str,
    /// Rays whose hit no correct traversal gives, over all frames.
    pub wrong: u64,
    /// Trees that were built for all frames.
    pub built: u64,
    /// What a ray costs over what it costs in trees that are built for the frame: the mean over the frames.
    pub mean_over: f64,
    /// The frame in which that is worst.
    pub worst_over: f64,
    /// Bytes of the file.
    pub bytes: u64,
}

/// A motion by every policy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionReport {
    /// As [`Motion::id`].
    pub id: &'static str,
    /// As [`Motion::name`].
    pub name: &'static str,
    /// As [`Motion::breaks`].
    pub breaks: &'static str,
    /// Of a frame, the most.
    pub triangles: u64,
    /// How many there are.
    pub frames: u64,
    /// A row a policy.
    pub rows: Vec<MotionRow>,
    /// Most trees, and the most that rays may cost over new trees in any frame, by the default policy.
    pub gate: (u64, f64),
}

impl MotionReport {
    /// What is broken, in words; nothing where all is kept.
    pub fn broken(&self) -> Option<String> {
        if let Some(row) = self.rows.iter().find(|row| row.wrong > 0) {
            return Some(format!("refit {}: {} wrong hits", row.refit, row.wrong));
        }
        let (trees, over) = self.gate;
        let auto = self.rows.iter().find(|row| row.refit == "auto")?;
        if auto.built > trees {
            return Some(format!("{} trees, above {trees}", auto.built));
        }
        (auto.worst_over > over)
            .then(|| format!("rays cost {:.2} times as much in a frame, above {over}", auto.worst_over))
    }
}

/// Why a motion could not be judged, which none of the list should be a reason for.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// No folder for the file.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// The file could not be built.
    #[error(transparent)]
    Sequence(#[from] crate::sequence::SequenceError),
    /// It could not be opened.
    #[error(transparent)]
    Cache(#[from] crate::cache::CacheError),
    /// Its frames could not be measured.
    #[error(transparent)]
    Frames(#[from] crate::report::frames::FramesError),
    /// A frame could not be judged.
    #[error(transparent)]
    Judge(#[from] super::judge::JudgeError),
}

const POLICIES: [(&str, Refit); 3] = [("auto", Refit::Auto), ("always", Refit::Always), ("never", Refit::Never)];
/// Trees are built by a recipe that can be refitted, quickly.
const METHOD: Method = Method::Sweep;

impl Motion {
    /// A frame of about so many triangles.
    pub fn frame(&self, count: usize, frame: usize) -> Scene {
        let mut scene = scene_of(&(self.soup)(count, frame));
        if self.shuffled {
            scene.meshes.iter_mut().for_each(|mesh| shuffle(mesh, frame));
        }
        scene
    }

    /// Build all frames by every policy, and judge each with about `rays` rays.
    ///
    /// # Errors
    /// Where it cannot be built, opened or traced.
    pub fn judged(&self, count: usize, rays: usize, exec: &Executor) -> Result<MotionReport, MotionError> {
        let place = tempfile::tempdir()?;
        let options = BuildOptions { method: METHOD, ..BuildOptions::preset(Preset::Draft) };
        let (method, builder_revision) = (options.method.to_string(), options.revision());
        let recipe = cache::keys::Recipe { method, builder_revision, options: options.effective() };
        let mut rows = Vec::new();
        let mut triangles = 0;
        for (refit, policy) in POLICIES {
            let path = place.path().join(refit).with_extension("bvhc");
            let policy = RefitPolicy { refit: policy, ..RefitPolicy::default() };
            let mut builder = SequenceBuilder::new(&path, &options, policy, Codec::Raw, exec, &NoProgress)?;
            let mut built = 0;
            for frame in 0..self.frames {
                let label = FrameLabel { number: frame as i32, ..FrameLabel::default() };
                built += builder.add(self.frame(count, frame), label)?.built;
            }
            builder.finish(&cache::provenance(recipe.clone(), &[], &ReadReport::default()))?;
            let sequence = Sequence::open(&path)?;
            let measure = Measure { rays, fresh: true };
            let report = SequenceReport::of(String::new(), &sequence, &measure, exec, &NoProgress, |_| {})?;
            let over: Vec<f64> = report.frames.iter().filter_map(|frame| frame.ray_ratio).collect();
            triangles = report.frames.iter().map(|frame| frame.instanced_triangles).max().unwrap_or(0);
            rows.push(MotionRow {
                refit,
                wrong: self.wrong(&sequence, count, rays, exec)?,
                built,
                mean_over: over.iter().sum::<f64>() / over.len().max(1) as f64,
                worst_over: over.iter().copied().fold(0.0, f64::max),
                bytes: report.file_len,
            });
        }
        let (frames, gate) = (self.frames as u64, self.gate);
        Ok(MotionReport { id: self.id, name: self.name, breaks: self.breaks, triangles, frames, rows, gate })
    }

    fn wrong(&self, sequence: &Sequence, count: usize, rays: usize, exec: &Executor) -> Result<u64, MotionError> {
        let mut wrong = 0;
        for index in 0..sequence.frame_count() {
            let scene = self.frame(count, index);
            let frame = sequence.frame_on(index, exec)?;
            let oracle = Oracle::of_file(&scene, &frame.view(), exec);
            let rays = Sampler::new(&scene).mixed(rays as u64 / 4 + 1, 1 + index as u64);
            let answers = oracle.trace_all(&rays, exec);
            let tally =
                compare(&frame.view(), &oracle, &rays, &answers, exec).map_err(super::judge::JudgeError::from)?;
            wrong += tally.wrong();
        }
        Ok(wrong)
    }
}

/// What spatial splits leave in motion (F29): a tree with and one without them, over the first frame of the turning rotor, in every frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SplitReport {
    /// Of the mesh.
    pub triangles: u64,
    /// References a triangle of the tree with splits.
    pub references: f64,
    /// What a ray costs in the refitted tree with splits over what it costs in the refitted one without, frame by frame; in the first frame neither is
    /// refitted, and in the one behind it the tree with splits is refitted to where it was.
    pub over: Vec<f64>,
}

/// Both trees, refitted.
///
/// # Errors
/// Where they cannot be built.
pub fn splits(count: usize, rays: usize, exec: &Executor) -> Result<SplitReport, MotionError> {
    let rotor = &MOTIONS[0];
    let build = |method, mesh: &Mesh| {
        let options = BuildOptions { method, ..BuildOptions::preset(Preset::Best) };
        build_tree(mesh, &options, exec, &NoProgress).map_err(super::judge::JudgeError::from)
    };
    let first = rotor.frame(count, 0).meshes.remove(0);
    let trees = [build(Method::Sbvh, &first)?, build(Method::Sweep, &first)?];
    let cost = |mesh: &Mesh, tree: &Tree, fitted: bool| -> Result<f64, MotionError> {
        let mut tree = tree.clone();
        if fitted {
            let corners = |slot: usize| mesh.corners(tree.refs[slot] as usize);
            refit_on(&mut tree.nodes, corners, exec).map_err(|e| std::io::Error::other(e.to_string()))?;
        }
        let image = cache::Image::of_tree(mesh, &tree, exec)?;
        let probe = ProbeRays::around(&image.view(), &Camera::around(&image.view()), rays);
        Ok(probe.cost(&image.view(), exec).mean())
    };
    let mut over = Vec::new();
    let meshes = std::iter::once((first.clone(), false))
        .chain((0..rotor.frames).map(|frame| (rotor.frame(count, frame).meshes.remove(0), true)));
    for (mesh, fitted) in meshes {
        let [with, without] = [cost(&mesh, &trees[0], fitted)?, cost(&mesh, &trees[1], fitted)?];
        over.push(if without > 0.0 { with / without } else { 1.0 });
    }
    let triangles = first.triangles.len() as u64;
    Ok(SplitReport { triangles, references: trees[0].refs.len() as f64 / triangles.max(1) as f64, over })
}

/// The same triangles by vertices with other numbers.
fn shuffle(mesh: &mut Mesh, frame: usize) {
    let count = mesh.positions.len();
    // A prime that does not divide the count makes every number once.
    let step = [1, 7, 11, 13, 17, 19][frame % 6];
    if count.is_multiple_of(step) && step > 1 {
        return;
    }
    let number = |corner: usize| (corner * step + frame) % count;
    let mut positions = mesh.positions.clone();
    (0..count).for_each(|corner| positions[number(corner)] = mesh.positions[corner]);
    mesh.positions = positions;
    mesh.triangles.iter_mut().flatten().for_each(|corner| *corner = number(*corner as usize) as u32);
}

fn cloud(count: usize) -> Soup {
    let mut random = Random::new(28);
    let at = |random: &mut Random| [0; 3].map(|_| random.unit() - 0.5);
    (0..count)
        .map(|_| {
            let place = at(&mut random);
            [0, 1, 2].map(|k| [0, 1, 2].map(|axis| place[axis] + if axis == k { 0.06 } else { 0.0 }))
        })
        .collect()
}

/// Each triangle by a vector of its own.
fn moved(soup: Soup, by: impl Fn(usize) -> Point) -> Soup {
    let place = |(i, corners): (usize, [Point; 3])| corners.map(|corner| add(corner, by(i)));
    soup.into_iter().enumerate().map(place).collect()
}

fn flights(count: usize) -> Vec<Point> {
    let mut random = Random::new(29);
    (0..count).map(|_| random.direction()).collect()
}

fn explosion(count: usize, frame: usize) -> Soup {
    let flights = flights(count);
    moved(cloud(count), |i| scale(flights[i], 0.05 * (frame * frame) as f64))
}

fn drift(count: usize, frame: usize) -> Soup {
    moved(cloud(count), |_| [0.1 * frame as f64, 0.0, 0.0])
}

fn random_walk(count: usize, frame: usize) -> Soup {
    let mut random = Random::new(30);
    let mut places = vec![[0.0; 3]; count];
    for _ in 0..frame {
        places.iter_mut().for_each(|place| *place = add(*place, scale(random.direction(), 0.1)));
    }
    moved(cloud(count), |i| places[i])
}

fn come_and_go(count: usize, frame: usize) -> Soup {
    let mut soup = cloud(count);
    soup.truncate([count * 4 / 5, count * 4 / 5, count, count, count * 4 / 5, 0, count * 4 / 5][frame % 7]);
    soup
}

/// A step takes six frames; to and fro along parabolas, which no library of functions has a part in.
fn gait(count: usize, frame: usize) -> Soup {
    let part = (frame % 6) as f64 / 3.0;
    let swing = if part < 1.0 { 4.0 * part * (1.0 - part) } else { -4.0 * (part - 1.0) * (2.0 - part) };
    let flights = flights(count);
    moved(cloud(count), |i| scale(flights[i], swing))
}

/// A body that stands and eight blades that turn by 15° a frame, beside a floor.
fn turning(count: usize, frame: usize) -> Soup {
    let mut soup = Soup::new();
    let side = ((count / 4) as f64).sqrt().max(1.0) as usize;
    sheet(&mut soup, side, side, |u, v| [2.0 * u - 1.0, 0.2 * u * v, 2.0 * v - 1.0]);
    let blades = (count / 16).max(1);
    // 15° and 45° to the last digit that matters here, put together by products.
    let turn = |(cos, sin): (f64, f64), (c, s): (f64, f64)| (cos * c - sin * s, sin * c + cos * s);
    let mut start = (1.0, 0.0);
    (0..frame).for_each(|_| start = turn(start, (0.965_925_826, 0.258_819_045)));
    for blade in 0..blades {
        let mut way = start;
        (0..blade % 8).for_each(|_| way = turn(way, (FRAC_1_SQRT_2, FRAC_1_SQRT_2)));
        let (y, reach) = (1.5 + 0.01 * (blade / 8) as f64, 9.0);
        bar(&mut soup, [0.3 * way.0, y, 0.3 * way.1], [reach * way.0, y, reach * way.1], 0.08);
    }
    soup
}

#[cfg(test)]
mod tests {
    use super::super::Failure;
    use super::*;

    #[test]
    fn frames_of_a_motion_have_the_triangles_that_were_asked_for() {
        for motion in &MOTIONS {
            for frame in 0..motion.frames {
                let triangles = motion.frame(160, frame).meshes[0].triangles.len();
                assert!(triangles <= 200 && (triangles >= 100 || motion.id == "F30"), "{}: {triangles}", motion.name);
            }
        }
        assert!(Failure::named("F02").is_some());
    }

    #[test]
    fn shuffled_vertices_are_the_same_triangles() {
        let motion = MOTIONS.iter().find(|motion| motion.shuffled).unwrap();
        let still = scene_of(&(motion.soup)(64, 3)).meshes.remove(0);
        let shuffled = motion.frame(64, 3).meshes.remove(0);
        assert_ne!(still.triangles, shuffled.triangles);
        assert!((0..64).all(|i| still.corners(i) == shuffled.corners(i)));
    }
}
