//! A sequence against its models: every frame as the still file that it would be.

use super::{CheckArgs, warn_of_rounding};
use crate::cache::check::{Level, Limits, Report, Source, check_bytes};
use crate::cache::{self, FrameRecord, Sequence, WriteOptions, to_bytes};
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::commands::build::clip_of;
use crate::cli::commands::still;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::cli::source::{self, Stated};
use crate::compile;
use crate::scene::ReadOptions;
use crate::scene::frames::Pattern;
use crate::sequence::Cuts;
use std::path::{Path, PathBuf};

/// Check a sequence by itself, and then frame after frame against its models, until one differs.
pub fn check(
    path: &Path,
    bytes: &[u8],
    model: &Path,
    args: &CheckArgs,
    limits: &Limits,
    context: &Context,
) -> Result<Report, Failure> {
    let exec = &context.exec;
    let mut report = check_bytes(bytes, Level::Tree, None, limits, exec);
    if !report.is_valid() {
        return Ok(report);
    }
    report.not_checked.clear();
    let sequence = caches::open_sequence(path, context)?;
    let models = models_of(path, &sequence, model)?;
    // Faces are cut as in the frame that shows them first.
    let mut cuts = Cuts::default();
    let (mut is_first, mut is_bent) = (true, false);
    for index in 0..sequence.frame_count() {
        let frame = sequence.frame_on(index, exec).map_err(|e| caches::failure(&e))?;
        let FrameRecord { number, flags, .. } = *frame.record();
        if flags & FrameRecord::HELD != 0 {
            continue;
        }
        let (image, mut meta) = still::of_frame(&sequence, &frame);
        let stated = Stated { meta: Some(&meta), two_levels: true, has_vertices: !image.vertices.is_empty() };
        let model = models.of(number);
        // META says one way.
        let way = args.reading.ways(path, stated, context)?.into_iter().next();
        let (read, build) = way.ok_or_else(|| Failure::new(Exit::Internal, "no way to read the model was tried"))?;
        let read = ReadOptions { faces: true, ..read };
        let scene = match std::mem::take(&mut is_first) {
            true => source::read(&model, &read, &build, context)?,
            false => source::read_untold(&model, &read, &build, context)?,
        };
        let (inputs, in_f64) = (scene.inputs.clone(), scene.clone());
        // A file that several frames name is listed once, by the first of them.
        let listed = sequence.meta().map_or(&[][..], |meta| &meta.dependencies);
        let named = cache::provenance(meta.recipe(), &inputs, &scene.report).dependencies;
        meta.dependencies =
            named.iter().filter_map(|own| listed.iter().find(|listed| listed.name == own.name)).cloned().collect();
        let mut laid = compile::lay_out(scene, &build, exec).map_err(|e| caches::build_failure(&e))?;
        laid.meshes.iter_mut().for_each(|mesh| _ = cuts.apply(mesh));
        // What reading left out is told of all frames together.
        let source =
            Source { meshes: &laid.meshes, instances: laid.instances.as_deref(), inputs: &inputs, report: None };
        let still = to_bytes(&image, &meta, &WriteOptions::default(), exec).map_err(|e| caches::failure(&e))?;
        let mut compared = check_bytes(&still, Level::Source, Some(&source), limits, exec);
        if !compared.is_valid() {
            compared
                .findings
                .iter_mut()
                .for_each(|found| found.expected = format!("in frame {number} {}", found.expected));
            compared.skip(format!("The frames behind frame {number} against their models."));
            report.append(compared);
            return Ok(report);
        }
        is_bent = is_bent || warn_of_rounding(path, &frame.view(), &in_f64, context);
    }
    Ok(report)
}

/// The models of the frames.
enum Models {
    /// All are moments of one.
    Clip(PathBuf),
    /// A file for each.
    Files(Pattern),
}

impl Models {
    fn of(&self, number: i32) -> PathBuf {
        match self {
            Models::Clip(model) => model.clone(),
            Models::Files(pattern) => pattern.path(number),
        }
    }
}

fn models_of(path: &Path, sequence: &Sequence, model: &Path) -> Result<Models, Failure> {
    let refuse = |fact: &str| {
        Failure::new(Exit::Usage, format!("cannot compare {} with {}", names::path(path), names::path(model)))
            .fact(fact)
    };
    let choice = sequence.meta().and_then(|meta| meta.options.iter().find(|(name, _)| name == "sequence"));
    let Some((_, choice)) = choice else {
        return Err(refuse("it has no META that says which frames it was built from")
            .help("build it again, or compare a frame: bvhc convert FILE -o STILL --frame N"));
    };
    match (clip_of(choice), Pattern::parse(model)) {
        (Some(_), None) => Ok(Models::Clip(model.to_path_buf())),
        (None, Some(Ok(pattern))) => Ok(Models::Files(pattern)),
        (Some(_), Some(_)) => Err(refuse("its frames are moments of one model, and that is a pattern of files")
            .help("name the model: --source MODEL")),
        (None, _) => Err(refuse("its frames are files, and that names one of them at most")
            .help("name them by a pattern, in quotes: --source 'heli.%04d.obj'")),
    }
}
