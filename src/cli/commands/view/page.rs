//! `--html`: a page that carries the trees with it.

use super::document::ViewReport;
use super::options::{Stand, ViewArgs};
use crate::cache::View;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::drawing;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::frame_list::FrameList;
use crate::cli::interrupt;
use crate::cli::names;
use crate::report::page::{Below, MOST_BYTES, PackError, PageCamera, PageScene, Together, bytes_of, pack, page};
use crate::size::bytes;
use std::path::{Path, PathBuf};

/// A film of about the shape that a page shows, to choose a camera by.
const FILM: [usize; 2] = [1280, 800];

/// Write the page of one file, or of two that are compared.
pub fn make(files: &[PathBuf], output: &Path, args: &ViewArgs, context: &Context) -> Result<ViewReport, Failure> {
    let (text, frames) = text(files, args, context)?;
    {
        let _publishing = interrupt::publish()?;
        drawing::put(output, "the page", text.as_bytes())?;
    }
    if !context.terminal.quiet && !context.terminal.json {
        let frames = if frames > 1 { format!(", {frames} frames") } else { String::new() };
        context.terminal.print(&format!("{}  {}{frames}\n", names::path(output), bytes(text.len() as u64)))?;
    }
    Ok(ViewReport { output: Some(output.to_string_lossy().into_owned()), picture: None, tree: None })
}

/// The page, and how many frames of one file it has.
pub fn text(files: &[PathBuf], args: &ViewArgs, context: &Context) -> Result<(String, usize), Failure> {
    let (mut scenes, mut camera) = (Vec::new(), None);
    for (path, name) in files.iter().zip(titles(files)) {
        read(path, &name, args, context, &mut scenes, &mut camera)?;
    }
    let (together, frames) = match args.compare {
        true => (Together::Compare, 1),
        false => (Together::Frames, scenes.len()),
    };
    Ok((page(&scenes, together, camera), frames))
}

/// What a page calls its files: their own names, or with folders where two have one name.
fn titles(files: &[PathBuf]) -> Vec<String> {
    let own: Vec<_> = files.iter().map(|file| file.file_name().unwrap_or(file.as_os_str())).collect();
    match own.as_slice() {
        [a, b] if a == b => names::headings(&files.iter().map(PathBuf::as_path).collect::<Vec<_>>()),
        _ => own.iter().map(|name| name.to_string_lossy().into_owned()).collect(),
    }
}

/// Add the scene of a still file, or the frames of a sequence: the one that was asked for, or all.
fn read(
    path: &Path,
    name: &str,
    args: &ViewArgs,
    context: &Context,
    scenes: &mut Vec<PageScene>,
    camera: &mut Option<PageCamera>,
) -> Result<(), Failure> {
    let mut add = |view: &View<'_>, frame: Option<i32>, parts: Vec<String>| -> Result<(), Failure> {
        let below = match args.root {
            Some(root) => Some(Below::of(view, root).ok_or_else(|| super::no_node(root, view))?),
            None => None,
        };
        let view = below.as_ref().map_or(*view, |below| below.view(view));
        let packed = pack(&view).map_err(|e| refused(&e, path, args))?;
        camera.get_or_insert_with(|| stand(&view, args, context));
        let facts = args.root.map(|root| ("Below".to_string(), format!("node {root} of the file")));
        scenes.push(PageScene {
            name: name.to_string(),
            frame,
            facts: facts.into_iter().collect(),
            parts,
            counts: packed.counts,
            data: packed.data,
        });
        Ok(())
    };
    // Of a still file there is no frame: opening it as a sequence says so.
    if args.frame.is_none() && !caches::is_sequence(path, context) {
        let cache = caches::open_checked(path, context)?;
        let parts = (0..cache.view().geoms.len()).map(|row| cache.name(row as u32).to_string()).collect();
        return add(&cache.view(), None, parts);
    }
    let sequence = caches::open_sequence(path, context)?;
    let chosen = args.frame.as_ref().unwrap_or(&FrameList::All).of(&sequence, path, "make a page of")?;
    let mut taken = 0;
    for number in &chosen {
        let frame = caches::frame(&sequence, path, *number, context)?;
        taken += bytes_of(&frame.view());
        if taken > MOST_BYTES && chosen.len() > 1 {
            return Err(Failure::new(Exit::Usage, format!("cannot make a page of {}", names::path(path)))
                .fact(format!(
                    "{} of its frames have more than {} of records, the most of a page",
                    chosen.len(),
                    bytes(MOST_BYTES)
                ))
                .help("show fewer of them: --frame LIST"));
        }
        let parts = frame
            .parts()
            .iter()
            .map(|row| sequence.names().get(*row as usize).unwrap_or_default().to_string())
            .collect();
        add(&frame.view(), Some(*number), parts)?;
    }
    Ok(())
}

fn refused(error: &PackError, path: &Path, args: &ViewArgs) -> Failure {
    let failure = Failure::new(Exit::Usage, format!("cannot make a page of {}", names::path(path)));
    match error {
        PackError::TooLarge { bytes: taken, most } => failure
            .fact(format!(
                "its nodes, triangles and instances take {}, and a page stays smooth up to {}",
                bytes(*taken),
                bytes(*most)
            ))
            .help(match args.root {
                None => "show a part of it: --root NODE, with a number from bvhc view FILE --tree",
                Some(_) => "choose a node farther down, with a number from bvhc view FILE --tree",
            }),
        PackError::Malformed(_) => failure.fact(error.to_string()).help("bvhc check FILE"),
    }
}

fn stand(view: &View<'_>, args: &ViewArgs, context: &Context) -> PageCamera {
    let up = args.up.axis();
    let camera = match args.camera {
        Stand::Named(standpoint) => standpoint.camera(view, up, FILM, &context.exec),
        Stand::Typed(camera) => camera,
    };
    PageCamera { eye: camera.eye, target: camera.look_at, fov: 2.0 * camera.tan_half.atan().to_degrees(), up }
}
