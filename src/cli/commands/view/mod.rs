//! `bvhc view`: pictures of a file's scene and of what its trees cost, and outlines of the trees.

mod document;
mod letters;
mod options;
mod outline;
mod page;

use self::document::{BoxesReport, Document, PictureReport, PicturedFile, TreeReport};
use self::letters::Colours;
use self::options::{Film, Stand};
use crate::cache::View;
use crate::cli::Context;
use crate::cli::caches;
use crate::cli::drawing;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::report::outline::Outline;
use crate::report::picture::{
    Canvas, Difference, Figures, Lens, Scale, Shade, Shot, Subtree, beside, boxes, heading, stacked,
};
use crate::size::bytes;
use crate::trace::Malformed;
use crate::trace::probe::Camera;
use std::path::Path;

pub use self::options::ViewArgs;

pub fn run(args: &ViewArgs, context: &Context) -> Result<Exit, Failure> {
    let wanted = if args.compare { 2 } else { 1 };
    if args.files.len() != wanted {
        let [needs, help] = match args.compare {
            true => ["--compare takes two files", "bvhc view --compare A B -o PNG"],
            false => ["one file makes a picture", "compare two: bvhc view --compare A B -o PNG"],
        };
        return Err(Failure::new(Exit::Usage, format!("cannot view {} files", args.files.len()))
            .fact(needs)
            .help(help));
    }
    if args.tree {
        return with_view(&args.files[0], args, context, &mut |view| tree(view, args, context));
    }
    if let Some(output) = &args.html {
        return page::run(output, args, context);
    }
    if args.output.is_none() && !args.terminal && !context.terminal.json {
        return Err(Failure::new(Exit::Usage, "cannot show a picture nowhere")
            .fact("a picture goes to a file or to the terminal")
            .help("name a file with -o PICTURE.png, or take --html PAGE.html, --terminal or --tree"));
    }
    if let Some(output) = &args.output {
        drawing::may_replace(output)?;
        drawing::suits(output, &["png"], "name it *.png; a page for browsers is made by --html PAGE.html")?;
    }
    match &args.files[..] {
        [first, second] => with_view(first, args, context, &mut |first| {
            with_view(second, args, context, &mut |second| picture(&[first, second], args, context))
        }),
        _ => with_view(&args.files[0], args, context, &mut |view| picture(&[view], args, context)),
    }
}

/// Open a file, or the frame of a sequence, every record checked, and show it to `then`.
fn with_view(
    path: &Path,
    args: &ViewArgs,
    context: &Context,
    then: &mut dyn FnMut(&View<'_>) -> Result<Exit, Failure>,
) -> Result<Exit, Failure> {
    let Some(number) = args.frame else {
        if caches::is_sequence(path, context) {
            return Err(Failure::new(Exit::Usage, format!("cannot view {}", names::path(path)))
                .fact("it is a sequence, and a picture shows one frame")
                .help("choose one: --frame N; bvhc info FILE says which there are"));
        }
        return then(&caches::open_checked(path, context)?.view());
    };
    let sequence = caches::open_sequence(path, context)?;
    let frame = caches::frame(&sequence, path, number, context)?;
    then(&frame.view())
}

/// Why node `root` cannot be shown.
fn no_node(root: u64, view: &View<'_>) -> Failure {
    Failure::new(Exit::Usage, format!("cannot start at node {root}"))
        .fact(format!("there are {} records of nodes, and the second of each tree is unused", view.nodes.len()))
        .help("see which there are: bvhc view FILE --tree")
}

fn tree(view: &View<'_>, args: &ViewArgs, context: &Context) -> Result<Exit, Failure> {
    let outline = Outline::of_view(view, args.root, args.depth);
    let Some(outline) = outline else { return Err(no_node(args.root.unwrap_or(0), view)) };
    if !context.terminal.json {
        context.terminal.print(&outline::text(&outline))?;
        return Ok(Exit::Success);
    }
    let path = args.files[0].to_string_lossy().into_owned();
    let tree = Some(TreeReport { path, frame: args.frame, of: outline.of, nodes: &outline.nodes });
    document(&Document { schema: "bvhc.view.v1", exit_code: 0, output: None, picture: None, tree }, context)
}

fn document(document: &Document<'_>, context: &Context) -> Result<Exit, Failure> {
    context.terminal.document(document)?;
    Ok(Exit::Success)
}

/// Checked records are a tree, so only a bug of the check ends here.
fn malformed(error: Malformed) -> Failure {
    Failure::new(Exit::Negative, "cannot trace the picture").fact(error.to_string()).help("bvhc check FILE")
}

fn picture(views: &[&View<'_>], args: &ViewArgs, context: &Context) -> Result<Exit, Failure> {
    let part = match args.root {
        None => None,
        Some(root) => Some(Subtree::of(views[0], root).ok_or_else(|| no_node(root, views[0]))?),
    };
    let below = part.as_ref().map(|part| part.view(views[0]));
    let views: Vec<&View<'_>> = below.as_ref().map_or_else(|| views.to_vec(), |below| vec![below]);

    let size = match args.terminal {
        true => Film { width: 80, height: 44 },
        false => Film { width: 1280, height: 800 },
    };
    let film = args.size.unwrap_or(size);
    let shade = args.shade.unwrap_or(if args.compare { Shade::Cost } else { Shade::Lit });
    let camera = camera(views[0], &film, args, context);
    let fine = usize::from(args.samples);
    let lens = Lens::new(&camera, film.width * fine, film.height * fine);
    let shots: Result<Vec<Shot>, Malformed> = views.iter().map(|view| Shot::take(view, &lens, &context.exec)).collect();
    let shots = shots.map_err(malformed)?;

    let scale = shade.scale(&shots.iter().collect::<Vec<_>>(), args.scale);
    let difference = match &shots[..] {
        [first, second] => Some(Difference::of(first, second, shade)),
        _ => None,
    };
    let mut panels = Vec::new();
    let mut drawn = None;
    for (shot, view) in shots.iter().zip(&views) {
        let mut canvas = shade.paint(shot, scale.as_ref()).shrunk(fine);
        if let Some(level) = args.boxes {
            let boxes = boxes::boxes(view, level).map_err(malformed)?;
            boxes::draw(&mut canvas, shot, &boxes);
            drawn.get_or_insert(BoxesReport { level, count: boxes.len() as u64 });
        }
        panels.push((canvas, scale.clone()));
    }
    if let Some(difference) = &difference {
        let scale = difference.scale(None);
        panels.push((difference.paint(&scale).shrunk(fine), Some(scale)));
    }

    let file = |(path, shot): (&std::path::PathBuf, &Shot)| PicturedFile {
        path: path.to_string_lossy().into_owned(),
        frame: args.frame,
        figures: Figures::of(shot),
    };
    let report = PictureReport {
        shade: shade.name(),
        width: film.width,
        height: film.height,
        samples: args.samples,
        camera: (&camera).into(),
        scale: scale.as_ref().map(|scale| scale.most),
        root: args.root,
        boxes: drawn,
        files: args.files.iter().zip(&shots).map(file).collect(),
        difference: difference.map(|d| d.figures),
    };
    show(&panels, report, args, context)
}

fn camera(view: &View<'_>, film: &Film, args: &ViewArgs, context: &Context) -> Camera {
    let axis = args.up.axis();
    match args.camera {
        Stand::Named(standpoint) => standpoint.camera(view, axis, [film.width, film.height], &context.exec),
        Stand::Typed(camera) => {
            let mut up = [0.0; 3];
            up[axis] = 1.0;
            Camera { up, ..camera }
        }
    }
}

/// Write or print the panels, and tell what they show.
fn show(
    panels: &[(Canvas, Option<Scale>)],
    report: PictureReport,
    args: &ViewArgs,
    context: &Context,
) -> Result<Exit, Failure> {
    let paths: Vec<&Path> = args.files.iter().map(std::path::PathBuf::as_path).collect();
    let named = names::headings(&paths);
    let mut written = None;
    if let Some(path) = &args.output {
        let titles = named.iter().map(String::as_str).chain(["difference"]);
        let whole = |((canvas, scale), title): (&(Canvas, Option<Scale>), &str)| {
            let mut parts = Vec::new();
            if args.compare {
                parts.push(heading(canvas.width(), title));
            }
            parts.push(canvas.clone());
            parts.extend(scale.as_ref().map(|scale| scale.strip(canvas.width())));
            stacked(&parts)
        };
        let all: Vec<Canvas> = panels.iter().zip(titles).map(whole).collect();
        let canvas = beside(&all);
        let length = bytes(drawing::picture(path, &canvas)?);
        written = Some(format!("{}  {} x {} pixels, {length}\n", names::path(path), canvas.width(), canvas.height()));
    }
    if context.terminal.json {
        let output = args.output.as_ref().map(|path| path.to_string_lossy().into_owned());
        let picture = Some(report);
        return document(&Document { schema: "bvhc.view.v1", exit_code: 0, output, picture, tree: None }, context);
    }
    if args.terminal {
        let colours = Colours::of(context.terminal.wants_colour(), |name| std::env::var(name).ok());
        for (canvas, scale) in panels {
            context.terminal.print(&colours.text(canvas))?;
            if let Some(scale) = scale {
                context.terminal.print(&document::legend(scale))?;
            }
        }
    }
    if !context.terminal.quiet {
        context.terminal.print(&(written.unwrap_or_default() + &report.text(&named)))?;
    }
    Ok(Exit::Success)
}
