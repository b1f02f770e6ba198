//! One file: opened, its scene read, verified.

use super::VerifyArgs;
use super::devices::{self, Bench};
use crate::cache::check::{Finding, Limits};
use crate::cache::rules::{self, Severity};
use crate::cache::{self, Cache, Codec, Image, Meta, OpenOptions, Sequence, Validation, View, WriteOptions};
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::frame_list::FrameList;
use crate::cli::names;
use crate::cli::patterns;
use crate::cli::progress::Bar;
use crate::cli::source::{self, Stated};
use crate::compile::{self, LaidOut};
use crate::geom::Affine;
use crate::layout::max_depth;
use crate::scene::{Instance, Scene};
use crate::verify::{Cpu, Outcome, Placed, Plan, Subject, VerifyError, is_of_model, placed, scene_of_file};
use std::path::{Path, PathBuf};

/// A file with its verdict.
pub struct Verified {
    pub path: PathBuf,
    /// Of a sequence: the frame's number.
    pub frame: Option<i32>,
    /// The model that the oracle was told of; `None`: the file's own triangles.
    pub source: Option<PathBuf>,
    /// How many rays were traced: those asked for, or as many as the file's trees allow.
    pub rays: u64,
    /// Whether these are fewer than a run takes elsewhere.
    pub is_lowered: bool,
    pub outcome: Outcome,
    /// Nodes that wait at most on the one stack of a traversal which goes to the nearer child at once (SPEC.md, section 10.1).
    pub stack: u32,
    /// Whether the triangles are where the model has them.
    pub placed: Option<Placed>,
}

impl Verified {
    /// The file, and of a sequence which frame of it.
    pub fn title(&self) -> String {
        let frame = self.frame.map_or_else(String::new, |number| format!(" frame {number}"));
        names::path(&self.path) + &frame
    }

    pub fn is_right(&self) -> bool {
        self.outcome.is_right() && self.placed.as_ref().is_none_or(Placed::is_right)
    }

    pub fn exit(&self) -> Exit {
        if self.is_right() { Exit::Success } else { Exit::Negative }
    }
}

pub fn verify(
    path: &Path,
    args: &VerifyArgs,
    plan: &Plan,
    bench: &Bench,
    context: &Context,
) -> Result<Verified, Failure> {
    let bar = Bar::new(&context.terminal, &names::path(path));
    bar.spin("opening");
    let cache = caches::open(path, context)?;
    verify_opened(&cache, path, args, plan, bench, &bar, context)
}

/// Fewest rays of a frame, where it is not said how many.
const LEAST_RAYS: u64 = 20_000;

/// Each of the frames of a sequence that are asked for, as the still file that it is.
pub fn verify_frames(
    path: &Path,
    frames: &FrameList,
    args: &VerifyArgs,
    plan: &Plan,
    bench: &Bench,
    context: &Context,
    mut each: impl FnMut(i32, Result<Verified, Failure>) -> Result<(), Failure>,
) -> Result<(), Failure> {
    cache::sound_sequence(path, &caches::options(context), &context.exec).map_err(|e| caches::failure(&e))?;
    let sequence = caches::open_sequence(path, context)?;
    let numbers = frames.of(&sequence, path, "verify")?;
    // What is a million rays for a still file is shared by the frames.
    let rays = args.rays.unwrap_or_else(|| (plan.rays / numbers.len() as u64).max(LEAST_RAYS));
    let plan = &Plan { rays, ..plan.clone() };
    for number in numbers {
        let bar = Bar::new(&context.terminal, &format!("{} frame {number}", names::path(path)));
        let verified = still(&sequence, path, number, context)
            .and_then(|cache| verify_opened(&cache, path, args, plan, bench, &bar, context))
            .map(|verified| Verified { frame: Some(number), ..verified });
        each(number, verified)?;
    }
    Ok(())
}

/// A frame as a still file in memory.
fn still(sequence: &Sequence, path: &Path, number: i32, context: &Context) -> Result<Cache, Failure> {
    let frame = caches::frame(sequence, path, number, context)?;
    let image = Image::of_frame(sequence, &frame);
    let options = WriteOptions { codec: Codec::Raw, check: false };
    let bytes = cache::to_bytes(&image, &Meta::default(), &options, &context.exec).map_err(|e| caches::failure(&e))?;
    let open = OpenOptions { validation: Validation::Quick, ..caches::options(context) };
    Cache::from_bytes_on(&bytes, &open, &context.exec).map_err(|e| caches::failure(&e))
}

fn verify_opened(
    cache: &Cache,
    path: &Path,
    args: &VerifyArgs,
    plan: &Plan,
    bench: &Bench,
    bar: &Bar,
    context: &Context,
) -> Result<Verified, Failure> {
    let finding = check_first(cache, path, context)?;
    let told = |failure: Failure| finding.iter().fold(failure, |failure, f| failure.fact(f.to_string()));
    let Held { scene, placed } = scene_for(cache, path, args, context).map_err(told)?;
    let subject = Subject::new(cache.view(), &scene, &context.exec);
    let of_this_file = |failure: Failure| failure.fact(format!("the file is {}", names::path(path)));
    let mut others = bench.devices(cache, &context.exec).map_err(|e| of_this_file(devices::failure(&e)))?;
    let most = plan.rays;
    let plan = match args.rays {
        Some(_) => plan.clone(),
        None => plan.affordable(&subject.view, &subject.sampler, &context.exec),
    };
    bar.phase("verifying", plan.rays);
    match crate::verify::run(&subject, &mut Cpu::new(cache.view(), &context.exec), &mut others, &plan, bar) {
        Ok(outcome) => match finding.filter(|_| outcome.is_right()) {
            Some(finding) => Err(broken(&finding, path).fact("no ray showed it")),
            None => {
                let (path, source, rays) = (path.to_path_buf(), args.source.clone(), plan.rays);
                let (is_lowered, stack) = (rays < most, stack(&cache.view()));
                Ok(Verified { path, frame: None, source, rays, is_lowered, outcome, stack, placed })
            }
        },
        Err(VerifyError::Device(error)) => Err(of_this_file(devices::failure(&error))),
        Err(VerifyError::Cancelled) => Err(Failure::interrupted()),
    }
}

fn stack(view: &View<'_>) -> u32 {
    let bottom = view.blases.iter().map(|blas| blas.max_depth).max().unwrap_or(0);
    bottom + max_depth(view.tlas_nodes)
}

/// Rules without which there is nothing to trace: the records are no tree, or no numbers. And the hole in a cut triangle, which is proved
/// where it is found. What breaks any other rule is left for rays to show, with the record that is to blame; what no ray
/// can show is told in the end.
const NO_RAYS: [&str; 12] =
    ["E0401", "E0402", "E0403", "E0404", "E0405", "E0406", "E0408", "E0410", "E0412", "E0417", "E0425", "E0503"];

/// Hold the file against every rule before any ray is traced; the first breach that rays may show is handed back.
fn check_first(cache: &Cache, path: &Path, context: &Context) -> Result<Option<Finding>, Failure> {
    let limits = Limits { max_issues: 1, ..Limits::default() };
    let report = cache.check(&limits, &context.exec);
    if report.count(&rules::E0127) > 0 {
        return Err(Failure::new(Exit::Limit, format!("cannot verify {}", names::path(path)))
            .fact(report.not_checked.join("\n"))
            .help(caches::MORE_MEMORY));
    }
    let errors: Vec<Finding> = report.findings.into_iter().filter(|f| f.rule.severity() == Severity::Error).collect();
    // Beside the counts, the rules of that hundred are about names, vertices and sides.
    let is_count = |f: &&Finding| f.rule.id.starts_with("E03") && f.rule.id < "E0320";
    match errors.iter().find(|f| is_count(f) || NO_RAYS.contains(&f.rule.id)) {
        Some(finding) => Err(broken(finding, path)),
        None => Ok(errors.into_iter().next()),
    }
}

fn broken(finding: &Finding, path: &Path) -> Failure {
    Failure::new(Exit::Negative, format!("cannot verify {}: it breaks a rule", names::path(path)))
        .fact(finding.to_string())
        .help(format!("bvhc check {}", names::path(path)))
}

/// What a file should hold.
pub struct Held {
    /// The triangles in the coordinates of the file's trees, and its instances.
    pub scene: Scene,
    /// How they stand to the model; `None` without one.
    pub placed: Option<Placed>,
}

/// The model, read as the file says that it was read and laid out as it was built, or else what the file itself says.
pub fn scene_for(cache: &Cache, path: &Path, args: &VerifyArgs, context: &Context) -> Result<Held, Failure> {
    let Some(model) = &args.source else {
        let scene = scene_of_file(&cache.view(), cache.names()).map_err(|e| {
            let failure = Failure::new(Exit::Negative, e.to_string());
            failure.fact(format!("the file is {}", names::path(path))).help(format!("bvhc check {}", names::path(path)))
        })?;
        return Ok(Held { scene, placed: None });
    };
    let model = &patterns::one(model, patterns::MODELS, "compare with", &context.terminal)?;
    let meta_missing = cache.meta().is_none();
    // Rays meet no numbers of vertices.
    let stated = Stated { meta: cache.meta(), two_levels: !cache.view().tlas_nodes.is_empty(), has_vertices: false };
    let mut first = None;
    for (read, build) in args.reading.ways(path, stated, context)? {
        let scene = source::read(model, &read, &build, context)?;
        let laid = compile::lay_out(scene.clone(), &build, &context.exec).map_err(|e| caches::build_failure(&e))?;
        let laid = as_scene(laid);
        match is_of_model(&cache.view(), &laid) {
            Ok(()) => {
                return Ok(Held { placed: Some(placed(&cache.view(), &scene, &context.exec)), scene: laid });
            }
            Err(error) => {
                first.get_or_insert(error);
            }
        }
    }
    let error = first.map_or_else(|| "no way to read the model was tried".to_owned(), |error| error.to_string());
    let failure = Failure::new(Exit::Negative, error);
    let (file, model) = (names::path(path), names::path(model));
    let failure = failure.fact(format!("the file is {file}")).fact(format!("the model is {model}"));
    let failure =
        if meta_missing { failure.fact("META, which would say how the model was read, is missing") } else { failure };
    Err(failure.help(format!("bvhc check {file} --source {model}")))
}

/// What is laid out as a scene: a single tree has one instance, which stays where it is.
fn as_scene(laid: LaidOut) -> Scene {
    let whole = Instance { mesh: 0, transform: Affine::IDENTITY, node: 0, name: String::new() };
    let LaidOut { meshes, instances, .. } = laid;
    let instances = instances.unwrap_or_else(|| meshes.first().map(|_| whole).into_iter().collect());
    Scene { meshes, instances, ..Scene::default() }
}
