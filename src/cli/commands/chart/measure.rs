//! One model, or the frames of one sequence, measured.

use super::ChartArgs;
use crate::cache::{self, CacheError};
use crate::cli::Context;
use crate::cli::advice;
use crate::cli::caches;
use crate::cli::commands::frames::{self, Ear};
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::progress::Bar;
use crate::report::frames::{Measure as FrameMeasure, SequenceReport};
use crate::report::tradeoff::{Contest, Effort, FormRow, LeftOut, Origin, Reason, Recipe, TradeOff, Watch, forms};
use crate::scene::{self, ReadOptions, Scene};
use crate::verify::accuracy::{AccuracyError, Measure, Report, measure as measure_accuracy};
use crate::verify::{Subject, scene_of_file};
use std::path::{Path, PathBuf};
use std::sync::RwLockReadGuard;
use std::time::Instant;

/// What was measured of one input.
pub enum Charted {
    Model(Box<Model>),
    Sequence(Sequence),
}

/// What was measured of the frames of one file.
pub struct Sequence {
    pub path: PathBuf,
    pub report: SequenceReport,
    /// Seconds that opening each frame takes, the least of a few times.
    pub opened: Vec<f64>,
}

/// What was measured of one model.
pub struct Model {
    pub path: PathBuf,
    /// Of the scene's meshes, each counted once.
    pub triangles: u64,
    /// Each mesh counted as often as it stands in the scene.
    pub instanced_triangles: u64,
    pub recipes: TradeOff,
    pub arithmetic: Result<Arithmetic, Missing>,
    /// The forms of one of the trees, and by which recipe those are; nothing where there was no time.
    pub forms: Option<(String, Vec<FormRow>)>,
}

/// Other arithmetics on one of the trees.
pub struct Arithmetic {
    /// The recipe of the tree.
    pub tree: String,
    pub report: Report,
}

/// Why there is no picture of arithmetics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    NotAsked,
    Budget,
    Interrupted,
}

impl Charted {
    pub fn path(&self) -> &Path {
        match self {
            Charted::Model(model) => &model.path,
            Charted::Sequence(sequence) => &sequence.path,
        }
    }

    /// Whether a builder of someone else's failed.
    pub fn misses_a_peer(&self) -> bool {
        let Charted::Model(model) = self else { return false };
        let failed = |left: &LeftOut| left.origin == Origin::Peer && matches!(left.reason, Reason::Failed(_));
        model.recipes.left_out.iter().any(failed)
    }
}

/// Permission to publish, once there is something to publish: until then a signal ends the process at once.
pub type Held = Option<RwLockReadGuard<'static, ()>>;

fn hold(publishing: &mut Held) -> Result<(), Failure> {
    if publishing.is_none() {
        *publishing = Some(interrupt::publish()?);
    }
    Ok(())
}

pub fn measure(
    path: &Path,
    recipes: &[Recipe],
    until: Instant,
    publishing: &mut Held,
    args: &ChartArgs,
    context: &Context,
) -> Result<Charted, Failure> {
    let bar = Bar::new(&context.terminal, &names::path(path));
    if caches::is_sequence(path, context) {
        return sequence(path, publishing, args, &bar, context);
    }
    if caches::head(path, context).is_ok() {
        return Err(Failure::new(Exit::Usage, format!("cannot chart {}", names::path(path)))
            .fact("it is a cache file, whose trees are built already, and recipes build a model's")
            .help(format!(
                "name its model; what rays cost in the file says bvhc stats {} --rays 4096",
                names::path(path)
            )));
    }
    model(path, recipes, until, publishing, args, &bar, context)
}

/// How often a frame is opened for its time.
const OPENED: u32 = 3;

fn sequence(
    path: &Path,
    publishing: &mut Held,
    args: &ChartArgs,
    bar: &Bar,
    context: &Context,
) -> Result<Charted, Failure> {
    cache::sound_sequence(path, &caches::options(context), &context.exec).map_err(|e| caches::failure(&e))?;
    let sequence = caches::open_sequence(path, context)?;
    hold(publishing)?;
    let frames = sequence.frame_count() as u64;
    bar.phase("measuring frames of", frames);
    let measure = FrameMeasure { rays: args.rays as usize, fresh: false };
    let name = path.to_string_lossy().into_owned();
    let done = |done| bar.set(done, frames);
    let report = SequenceReport::of(name, &sequence, &measure, &context.exec, &Ear(bar), done);
    let report = report.map_err(|error| frames::failure(&error, path))?;
    let opened = (0..sequence.frame_count()).map(|index| {
        let once = |_| {
            let start = Instant::now();
            std::hint::black_box(sequence.frame(index)).map(|_| start.elapsed().as_secs_f64())
        };
        (0..OPENED).map(once).try_fold(f64::INFINITY, |least, seconds| Ok(seconds?.min(least)))
    });
    let opened = opened.collect::<Result<_, _>>().map_err(|e: CacheError| caches::failure(&e))?;
    Ok(Charted::Sequence(Sequence { path: path.to_owned(), report, opened }))
}

fn model(
    path: &Path,
    recipes: &[Recipe],
    until: Instant,
    publishing: &mut Held,
    args: &ChartArgs,
    bar: &Bar,
    context: &Context,
) -> Result<Charted, Failure> {
    bar.phase("reading", 1);
    let read = ReadOptions { max_memory: context.global.max_memory, ..args.reading.resolve() };
    let mut progress = |done: u64, length: u64| bar.set(done, length);
    let scene = scene::read_with(path, &read, &context.exec, &mut progress).map_err(|e| caches::scene_failure(&e))?;
    if scene.instanced_triangles() == 0 {
        return Err(
            Failure::new(Exit::Model, format!("cannot chart {}", names::path(path))).fact("there is no triangle in it")
        );
    }
    for recipe in recipes {
        caches::fits(path, &scene, &recipe.options, context)?;
    }
    hold(publishing)?;
    let effort = Effort { rays: args.rays as usize, rounds: args.rounds(), until };
    let mut contest = Contest::new(&scene, recipes, effort, &context.exec, bar);
    contest.first_round(&advice::flags).map_err(|e| caches::failure(&e))?;
    contest.peers(&args.peers);
    let arithmetic = accuracy(&contest, &scene, until, args, bar, context)?;
    let forms = shapes(&contest, until, args, bar)?;
    contest.release();
    contest.more_rounds();
    let measured = contest.finish();
    if measured.recipes.is_empty() {
        let failed = measured.left_out.iter().find_map(|left| match &left.reason {
            Reason::Failed(why) => {
                Some(Failure::new(Exit::Model, format!("cannot chart {}", names::path(path))).fact(why))
            }
            _ => None,
        });
        return Err(failed.unwrap_or_else(Failure::interrupted));
    }
    let path = path.to_owned();
    let (triangles, instanced_triangles) =
        (scene.meshes.iter().map(|mesh| mesh.triangles.len() as u64).sum(), scene.instanced_triangles());
    let recipes = measured;
    Ok(Charted::Model(Box::new(Model { path, triangles, instanced_triangles, recipes, arithmetic, forms })))
}

/// The forms of the trees that were kept.
fn shapes(
    contest: &Contest<'_>,
    until: Instant,
    args: &ChartArgs,
    bar: &Bar,
) -> Result<Option<(String, Vec<FormRow>)>, Failure> {
    let goes_on = || !Watch::is_cancelled(bar) && Instant::now() < until;
    let Some((tree, image)) = contest.kept().filter(|_| goes_on()) else { return Ok(None) };
    bar.phase("tracing forms of trees of", 1);
    let rows = forms(image, args.rays as usize, TIMED_ROUNDS.min(args.rounds()), goes_on);
    let failed = |e: crate::trace::Malformed| Failure::new(Exit::Internal, "cannot trace a tree").fact(e.to_string());
    let rows = rows.map_err(failed)?;
    Ok((!rows.is_empty()).then(|| (tree.to_string(), rows)))
}

impl Watch for Bar {
    fn is_cancelled(&self) -> bool {
        crate::build::Progress::is_cancelled(self)
    }

    fn step(&self, recipe: &str, round: u32, done: u64, of: u64) {
        self.phase(&format!("round {round}, {recipe}:"), of);
        self.set(done, of);
    }
}

/// Fair rays that are timed by each arithmetic, and how often; and what brute force may spend, in rays × triangles: a page is made in a minute.
const TIMED: u64 = 1 << 13;
const TIMED_ROUNDS: u32 = 5;
const ORACLE_WORK: u64 = 2_000_000_000;

fn accuracy(
    contest: &Contest<'_>,
    scene: &Scene,
    until: Instant,
    args: &ChartArgs,
    bar: &Bar,
    context: &Context,
) -> Result<Result<Arithmetic, Missing>, Failure> {
    let Some((tree, image)) = contest.kept().filter(|_| args.accuracy_rays() > 0) else {
        return Ok(Err(Missing::NotAsked));
    };
    let internal = |text: String| Failure::new(Exit::Internal, "cannot judge arithmetics").fact(text);
    let view = image.view();
    // The triangles in the coordinates of the trees; what reading lost is the same for all arithmetics.
    let held = scene_of_file(&view, cache::Names::new(&[])).map_err(|e| internal(e.to_string()))?;
    let subject = Subject::new(view, &held, &context.exec);
    let rays = args.accuracy_rays();
    let how = Measure {
        rays,
        timed: TIMED.min(rays),
        rounds: TIMED_ROUNDS.min(args.rounds()),
        oracle_work: ORACLE_WORK,
        ..Measure::default()
    };
    bar.phase("judging arithmetics on", how.steps(scene.instanced_triangles()));
    let ear = Until { bar, until };
    match measure_accuracy(&subject.view, &subject.oracle, &subject.sampler, &how, &context.exec, &ear) {
        Ok(report) => Ok(Ok(Arithmetic { tree: tree.to_string(), report })),
        Err(AccuracyError::Cancelled) if Watch::is_cancelled(bar) => Ok(Err(Missing::Interrupted)),
        Err(AccuracyError::Cancelled) => Ok(Err(Missing::Budget)),
        Err(error) => Err(internal(error.to_string())),
    }
}

/// A bar that stops at a time.
struct Until<'a> {
    bar: &'a Bar,
    until: Instant,
}

impl crate::build::Progress for Until<'_> {
    fn is_cancelled(&self) -> bool {
        crate::build::Progress::is_cancelled(self.bar) || Instant::now() >= self.until
    }

    fn advance(&self, steps: u64) {
        crate::build::Progress::advance(self.bar, steps);
    }
}
