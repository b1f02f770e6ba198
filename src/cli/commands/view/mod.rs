//! `bvhc view`: pictures of a file's scene and of what its trees cost, and outlines of the trees.

mod document;
mod letters;
mod options;
mod outline;
mod page;
mod serve;

use self::document::{BoxesReport, Document, PictureReport, PicturedFile, TreeReport, ViewReport};
use self::letters::Colours;
use self::options::{Film, Stand};
use crate::cache::View;
use crate::cli::Context;
use crate::cli::caches::{self, KeptOpen};
use crate::cli::drawing;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::frame_list::FrameList;
use crate::cli::names;
use crate::cli::outputs::{self, Source};
use crate::cli::patterns;
use crate::report::outline::Outline;
use crate::report::picture::{
    Canvas, Difference, Figures, Lens, Scale, Shot, Subtree, beside, boxes, heading, stacked,
};
use crate::size::bytes;
use crate::trace::Malformed;
use crate::trace::probe::Camera;
use std::cell::RefCell;
use std::path::{Path, PathBuf};

pub use self::options::ViewArgs;

/// One picture, page or outline: of a file, or of two that are compared.
struct Job<'a> {
    files: &'a [PathBuf],
    /// Of a sequence.
    frame: Option<i32>,
    kept: &'a RefCell<Kept<'a>>,
    output: Option<&'a Path>,
    args: &'a ViewArgs,
    context: &'a Context,
}

/// What the pictures of one sequence's frames share.
struct Kept<'a> {
    open: KeptOpen<'a>,
    /// The file whose frames are shown, and from where.
    camera: Option<(PathBuf, Camera)>,
}

pub fn run(args: &ViewArgs, context: &Context) -> Result<Exit, Failure> {
    args.suits()?;
    let files = patterns::expand(&args.files, patterns::CACHES, "view", &context.terminal)?;
    if args.compare && files.len() != 2 {
        return Err(Failure::new(Exit::Usage, format!("cannot compare {} files", files.len()))
            .fact("--compare takes two files")
            .help("bvhc view --compare A B -o PNG"));
    }
    let goes_nowhere = args.output.is_none() && args.html.is_none() && !args.tree;
    if let Some(port) = args.port(goes_nowhere && !args.terminal, context) {
        return match files.len() {
            1 | 2 if args.compare || files.len() == 1 => serve::run(&files, port, args, context),
            count => Err(Failure::new(Exit::Usage, format!("cannot serve {count} files"))
                .fact("a page shows one file, or two that are compared")
                .help("name one of them, or add --compare")),
        };
    }
    if goes_nowhere && !args.terminal && !context.terminal.json {
        return Err(Failure::new(Exit::Usage, "cannot show a picture nowhere")
            .fact("a picture goes to a file or to the terminal")
            .help("name a file with -o PICTURE.png, or take --html PAGE.html, --serve, --terminal or --tree"));
    }
    let named = args.output.as_ref().or(args.html.as_ref());
    let sources = sources(&files, args, context)?;
    let outputs = named.map(|named| outputs_of(&files, &sources, named, args)).transpose()?;
    let kept = RefCell::new(Kept { open: KeptOpen::new(context), camera: None });
    let mut numbers = 0..;
    let things = sources.iter().map(|source| (source.path.as_path(), source.frame));
    let (views, exit) = caches::each_of(things, context, |(path, frame)| {
        let at = numbers.next().unwrap_or(0);
        let output = outputs.as_ref().and_then(|outputs| outputs.get(at)).map(PathBuf::as_path);
        let files = if args.compare { &files[..] } else { std::slice::from_ref(&sources[at].path) };
        let job = Job { files, frame, kept: &kept, output, args, context };
        output.zip(named).map_or(Ok(()), |(output, named)| outputs::make_folder(output, named))?;
        if sources.len() > 1 && (args.tree || args.terminal) && !context.terminal.json {
            let frame = frame.map_or_else(String::new, |number| format!(", frame {number}"));
            context.terminal.print(&format!("{}{frame}:\n", names::path(path)))?;
        }
        job.run()
    });
    if context.terminal.json {
        context.terminal.document(&Document { schema: "bvhc.view.v1", exit_code: exit.code(), views: &views })?;
    }
    Ok(exit)
}

/// What is shown one after the other: files, frames of them, or two files at once.
fn sources(files: &[PathBuf], args: &ViewArgs, context: &Context) -> Result<Vec<Source>, Failure> {
    if let (true, Some(list)) = (args.compare, &args.frame)
        && list.only().is_none()
        && args.html.is_none()
    {
        return Err(Failure::new(Exit::Usage, "cannot compare several frames")
            .fact("--compare takes one moment of two files")
            .help("choose one frame: --frame N"));
    }
    // A page has all frames of its files.
    let frames = args.frame.as_ref().filter(|_| args.html.is_none());
    let mut sources = FrameList::sources(frames, files, "view", context)?;
    if args.compare {
        sources.truncate(1);
    }
    Ok(sources)
}

/// What is written of each file or frame, or of both that are compared.
fn outputs_of(files: &[PathBuf], sources: &[Source], named: &Path, args: &ViewArgs) -> Result<Vec<PathBuf>, Failure> {
    let (extension, kinds, help): (_, &[&str], _) = match args.html {
        None => ("png", &["png"], "name it *.png; a page for browsers is made by --html PAGE.html"),
        Some(_) => ("html", &["html", "htm"], "name it *.html; a picture is made by -o PICTURE.png"),
    };
    let outputs = match args.compare {
        true => vec![named.to_owned()],
        false => outputs::of_each(sources, named, extension, "view").map_err(|failure| match files {
            [_, _] if args.html.is_none() && !outputs::is_folder(named) => {
                let folder = names::path(named);
                failure
                    .help(format!("write -o {folder}/ for a picture of each, or bvhc view --compare A B -o {folder}"))
            }
            _ => failure,
        })?,
    };
    for output in &outputs {
        drawing::may_replace(output)?;
        drawing::suits(output, kinds, help)?;
    }
    Ok(outputs)
}

impl Job<'_> {
    /// Open a file, or the frame of a sequence, every record checked, and show it to `then`.
    fn with_view(
        &self,
        path: &Path,
        then: &mut dyn FnMut(&View<'_>) -> Result<ViewReport, Failure>,
    ) -> Result<ViewReport, Failure> {
        let context = self.context;
        let Some(number) = self.frame else {
            if caches::is_sequence(path, context) {
                return Err(Failure::new(Exit::Usage, format!("cannot view {}", names::path(path)))
                    .fact("it is a sequence, and a picture shows one frame")
                    .help("choose frames: --frame N, or all into a folder; bvhc info FILE says which there are"));
            }
            return then(&caches::open_checked(path, context)?.view());
        };
        let mut open = std::mem::replace(&mut self.kept.borrow_mut().open, KeptOpen::new(context));
        let shown = match open.sequence(path) {
            Ok(sequence) => caches::frame(sequence, path, number, context).and_then(|frame| then(&frame.view())),
            Err(failure) => Err(failure),
        };
        self.kept.borrow_mut().open = open;
        shown
    }

    /// From where a picture is taken: the frames of a sequence all from one place.
    fn camera(&self, view: &View<'_>, film: &Film) -> Camera {
        if self.frame.is_none() {
            return camera(view, film, self.args, self.context);
        }
        let (mut kept, file) = (self.kept.borrow_mut(), &self.files[0]);
        match &kept.camera {
            Some((path, camera)) if path == file => *camera,
            _ => kept.camera.insert((file.clone(), camera(view, film, self.args, self.context))).1,
        }
    }

    fn run(&self) -> Result<ViewReport, Failure> {
        let (files, args, context) = (self.files, self.args, self.context);
        if args.tree {
            return self.with_view(&files[0], &mut |view| self.tree(view));
        }
        if let (Some(output), Some(_)) = (self.output, &args.html) {
            return page::make(files, output, args, context);
        }
        match files {
            [first, second] => {
                self.with_view(first, &mut |first| self.with_view(second, &mut |second| self.picture(&[first, second])))
            }
            _ => self.with_view(&files[0], &mut |view| self.picture(&[view])),
        }
    }

    fn tree(&self, view: &View<'_>) -> Result<ViewReport, Failure> {
        let (args, terminal) = (self.args, &self.context.terminal);
        let outline = Outline::of_view(view, args.root, args.depth);
        let outline = outline.ok_or_else(|| no_node(args.root.unwrap_or(0), view))?;
        if !terminal.json {
            terminal.print(&outline::text(&outline))?;
        }
        let path = self.files[0].to_string_lossy().into_owned();
        let tree = TreeReport { path, frame: self.frame, of: outline.of, nodes: outline.nodes };
        Ok(ViewReport { output: None, picture: None, tree: Some(tree) })
    }

    fn picture(&self, views: &[&View<'_>]) -> Result<ViewReport, Failure> {
        let (args, context) = (self.args, self.context);
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
        let shade = args.shade();
        let camera = self.camera(views[0], &film);
        let fine = usize::from(args.samples);
        let lens = Lens::new(&camera, film.width * fine, film.height * fine);
        let shots: Result<Vec<Shot>, Malformed> =
            views.iter().map(|view| Shot::take(view, &lens, &context.exec)).collect();
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
            frame: self.frame,
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
            files: self.files.iter().zip(&shots).map(file).collect(),
            difference: difference.map(|d| d.figures),
        };
        self.show(&panels, report)
    }

    /// Write or print the panels, and tell what they show.
    fn show(&self, panels: &[(Canvas, Option<Scale>)], report: PictureReport) -> Result<ViewReport, Failure> {
        let (args, terminal) = (self.args, &self.context.terminal);
        let named = names::headings(&self.files.iter().map(PathBuf::as_path).collect::<Vec<_>>());
        let mut written = None;
        if let Some(path) = self.output {
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
            let size = format!("{} x {} pixels", canvas.width(), canvas.height());
            written = Some(format!("{}  {size}, {length}\n", names::path(path)));
        }
        if args.terminal {
            let colours = Colours::of(terminal.wants_colour(), |name| std::env::var(name).ok());
            for (canvas, scale) in panels {
                terminal.print(&colours.text(canvas))?;
                if let Some(scale) = scale {
                    terminal.print(&document::legend(scale))?;
                }
            }
        }
        if !terminal.quiet && !terminal.json {
            terminal.print(&(written.unwrap_or_default() + &report.text(&named)))?;
        }
        let output = self.output.map(|path| path.to_string_lossy().into_owned());
        Ok(ViewReport { output, picture: Some(report), tree: None })
    }
}

/// Why node `root` cannot be shown.
fn no_node(root: u64, view: &View<'_>) -> Failure {
    Failure::new(Exit::Usage, format!("cannot start at node {root}"))
        .fact(format!("there are {} records of nodes, and the second of each tree is unused", view.nodes.len()))
        .help("see which there are: bvhc view FILE --tree")
}

/// Checked records are a tree, so only a bug of the check ends here.
fn malformed(error: Malformed) -> Failure {
    Failure::new(Exit::Negative, "cannot trace the picture").fact(error.to_string()).help("bvhc check FILE")
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
