//! `bvhc chart`: what each recipe takes to build against what rays cost then, and other pictures of speed against accuracy, on one page.
//!
//! `recipes` lists what is tried, `measure` measures a model or the frames of a sequence, `sections` makes pictures and tables of that, `document` says it
//! as JSON and as comma-separated values. `applies` refuses flags that are about something else, and `preset` says which preset suits. `forms` and `prediction` are pictures of their own. `stability` judges scenes that builders fail on instead.
//! `output` writes what either made.

mod applies;
mod document;
mod forms;
mod measure;
mod output;
mod prediction;
mod preset;
mod recipes;
mod sections;
mod stability;

use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::figures;
use crate::cli::interrupt;
use crate::cli::names;
use crate::cli::patterns;
use crate::cli::reading::ModelReading;
use crate::report::chart::page::Section;
use crate::report::tradeoff::Worker;
use clap::Args;
use document::Document;
use measure::Charted;
use output::Made;
use recipes::Given;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Chart build time against ray cost over all recipes, and rays a second against wrong hits
///
/// Every preset, every method and every --recipe builds the model's trees, once from the quickest to the slowest, then in rounds as long as the budget lasts; the
/// median of the rounds counts, and what the rounds cannot tell apart is said. Ray cost is 1.2 · nodes + triangle tests a ray, a mean over camera rays, one
/// diffuse bounce and ambient occlusion: a count, the same on every machine. Other arithmetics are judged and timed as by `verify --accuracy`. Of a sequence, a
/// file of many frames, ray cost and bytes are shown frame by frame. SIGINT ends the measuring, and what is measured is written.
#[derive(Clone, Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ChartArgs {
    /// Models, or sequences that `bvhc build` made
    #[arg(required_unless_present = "stability", value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// Judge every preset, method and pass on scenes that builders are known to fail on, and print what each comes to: all, or those of these numbers or names
    #[arg(long, value_name = "SCENES", num_args = 0..=1, require_equals = true, default_missing_value = "", value_delimiter = ',', conflicts_with_all = ["models", "recipes", "accuracy_rays", "degenerate", "allow_outside", "scene", "clip", "time", "ignore_extensions"])]
    stability: Option<Vec<String>>,
    /// Triangles of each scene of --stability, about, in a small and in a large form [default: 700,2100]
    #[arg(long, value_name = "SMALL,LARGE", value_parser = parse_sizes)]
    sizes: Option<Sizes>,
    /// Page to write; it holds all that it shows, and asks no network
    #[arg(short, long, value_name = "PAGE.html")]
    output: Option<PathBuf>,
    /// Draw all pictures into one SVG file
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Draw all pictures into one PNG file
    #[arg(long, value_name = "FILE")]
    png: Option<PathBuf>,
    /// Write all figures as comma-separated values, with a heading
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Print the figures as Markdown
    #[arg(long, conflicts_with = "json")]
    markdown: bool,
    /// Another recipe, by the flags of `bvhc build`, with or without a name before it; may be given again
    #[arg(long = "recipe", value_name = "[NAME=]FLAGS", value_parser = recipes::parse, allow_hyphen_values = true)]
    recipes: Vec<Given>,
    /// A builder of someone else's beside ours, embree, obvhs, bvh or tinybvh, by the program that benches/ has for it and what that is started with; may be given again
    #[arg(long = "peer", value_name = "NAME=PROGRAM", value_parser = recipes::peer, conflicts_with = "stability")]
    peers: Vec<Worker>,
    /// When to stop, all models together; the quickest recipe of each is built in any case [default: 60s, with --stability 15m]
    #[arg(long, value_name = "TIME", value_parser = figures::parse_seconds)]
    budget: Option<Duration>,
    /// How often each recipe is built at most [default: 9, with --stability 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: Option<u32>,
    /// Rays in each of three sets by which the cost of a ray is counted, from four cameras around the scene or each frame
    #[arg(long, value_name = "N", value_parser = some_rays, default_value = "4096")]
    rays: u32,
    /// Rays that judge other arithmetics; 0 leaves that picture out [default: 20k]
    #[arg(long, value_name = "N", value_parser = figures::parse_count)]
    accuracy_rays: Option<u64>,

    #[command(flatten)]
    reading: ModelReading,
}

const EXAMPLES: &str = "Examples:
  bvhc chart rock.glb -o rock.html
  bvhc chart hall.obj rock.glb -o both.html --budget 5m --svg both.svg --csv both.csv
  bvhc chart rock.glb --recipe 'moved=--method sweep --reinsert 8' --recipe '--preset draft --adapt 1024'
  bvhc chart heli.bvhc -o frames.html
  bvhc chart rock.glb --peer obvhs=target/obvhs-parallel/release/obvhs_worker -o rock.html
  bvhc chart --stability -o stability.html
  bvhc chart --stability=hall,needles --sizes 1000,8000";

/// What rays cost is told by some at least.
fn some_rays(text: &str) -> Result<u32, String> {
    match figures::parse_rays(text)? {
        0 => Err("no ray tells what rays cost; write 1 or more".to_string()),
        count => Ok(count),
    }
}

/// Triangles of a scene in its two forms.
#[derive(Clone, Copy, Debug)]
struct Sizes([usize; 2]);

fn parse_sizes(text: &str) -> Result<Sizes, String> {
    let sizes: Option<Vec<usize>> = text.split(',').map(|size| size.trim().parse().ok()).collect();
    match sizes.as_deref() {
        Some([small, large]) if small < large && *large <= MOST_TRIANGLES => Ok(Sizes([*small, *large])),
        _ => Err(format!("it takes two ascending numbers up to {MOST_TRIANGLES}, such as 700,2100")),
    }
}

/// Brute force tests every triangle with every ray.
const MOST_TRIANGLES: usize = 1_000_000;
const BUDGET: Duration = Duration::from_secs(60);
const BUDGET_OF_STABILITY: Duration = Duration::from_secs(900);
const SIZES: [usize; 2] = [700, 2100];
const ACCURACY_RAYS: u64 = 20_000;
const ROUNDS: u32 = 9;
const ROUNDS_OF_STABILITY: u32 = 3;

impl ChartArgs {
    fn budget(&self) -> Duration {
        self.budget.unwrap_or(if self.stability.is_some() { BUDGET_OF_STABILITY } else { BUDGET })
    }

    fn sizes(&self) -> [usize; 2] {
        self.sizes.map_or(SIZES, |sizes| sizes.0)
    }

    fn accuracy_rays(&self) -> u64 {
        self.accuracy_rays.unwrap_or(ACCURACY_RAYS)
    }

    fn rounds(&self) -> u32 {
        self.rounds.unwrap_or(if self.stability.is_some() { ROUNDS_OF_STABILITY } else { ROUNDS })
    }
}

pub fn run(args: &ChartArgs, context: &Context) -> Result<Exit, Failure> {
    applies::flags(args)?;
    if let Some(asked) = &args.stability {
        return stability::run(asked, args, context);
    }
    let recipes = recipes::all(&args.recipes)?;
    let args = &ChartArgs {
        models: patterns::expand(&args.models, patterns::MODELS, "chart", &context.terminal)?,
        ..args.clone()
    };
    applies::inputs(args, context)?;
    output::may_write(args)?;

    // Once there is something to measure a signal waits until that is written. The permission is held to the end, also while the document is printed.
    let deadline = Instant::now() + args.budget();
    let mut publishing = None;
    let (mut charted, mut exits) = (Vec::new(), Vec::new());
    for (number, path) in args.models.iter().enumerate() {
        if is_interrupted() {
            break;
        }
        // What a model leaves of its share, the others have.
        let left = deadline.saturating_duration_since(Instant::now());
        let until = Instant::now() + left / (args.models.len() - number) as u32;
        match measure::measure(path, &recipes, until, &mut publishing, args, context) {
            Ok(one) => {
                exits.push(Exit::Success);
                charted.push(one);
            }
            Err(failure) => {
                if failure.exit != Exit::Interrupted {
                    context.terminal.error(&failure);
                }
                exits.push(failure.exit);
            }
        }
    }
    if publishing.is_none() {
        publishing = Some(interrupt::publish()?);
    }
    let interrupted = is_interrupted();
    if charted.is_empty() {
        return if interrupted { Err(Failure::interrupted()) } else { Ok(Exit::combine(exits)) };
    }
    for missing in charted.iter().filter_map(sections::left_out) {
        context.terminal.warn(&missing);
    }
    let few: Vec<String> = charted.iter().filter_map(|one| sections::few_rays(one, args)).collect();
    few.iter().for_each(|few| context.terminal.warn(few));
    let mut exit = if interrupted { Exit::Interrupted } else { Exit::combine(exits) };
    // What others' builders would have shown is missing; what ours show is there.
    if exit == Exit::Success && charted.iter().any(Charted::misses_a_peer) {
        exit = Exit::Io;
    }
    let sections = pictures(&charted, args, context);
    let (lead, warnings) = told(args, &charted, exit, context);
    let made = Made {
        title: sections::title(args),
        lead,
        warnings,
        printed: sections.clone(),
        sections,
        csv: document::csv(&charted),
        advice: charted.iter().filter_map(|one| sections::advice(one, args)).collect(),
    };
    output::write(args, &made, context, |outputs| Document::new(args, &charted, outputs, exit, context))?;
    drop(publishing);
    Ok(exit)
}

fn pictures(charted: &[Charted], args: &ChartArgs, context: &Context) -> Vec<Section> {
    let mut all = Vec::new();
    for one in charted {
        all.extend(sections::of(one, args, context));
        if let Charted::Model(model) = one {
            all.extend(model.forms.iter().map(|(tree, rows)| forms::section(&model.path, tree, rows, args)));
        }
    }
    all.extend(prediction::section(charted, args));
    all
}

fn is_interrupted() -> bool {
    interrupt::flag().load(Ordering::SeqCst)
}

/// What stands above the pictures: how it was measured, and what must be known before it is believed.
fn told(args: &ChartArgs, charted: &[Charted], exit: Exit, context: &Context) -> (Vec<String>, Vec<String>) {
    let threads = figures::counted(context.exec.threads() as u64, "thread", "threads");
    let lead = vec![
        format!(
            "bvhc {} on {} {}, {threads}. At most {} of each recipe, alternating over the recipes, within {}.",
            env!("CARGO_PKG_VERSION"),
            std::env::consts::OS,
            std::env::consts::ARCH,
            figures::counted(args.rounds().into(), "build", "builds"),
            figures::seconds(args.budget()),
        ),
        "Ray cost is a count, the same on every machine. Times and speeds are this machine's. Select a point for its figures and the flags to type.".into(),
    ];
    let mut warnings = Vec::new();
    if exit == Exit::Interrupted {
        warnings.push("The run was interrupted: what had been measured by then is here.".to_string());
    }
    if charted.len() < args.models.len() {
        let missing = args.models.iter().filter(|path| !charted.iter().any(|one| one.path() == path.as_path()));
        let missing: Vec<String> = missing.map(|path| names::path(path)).collect();
        warnings.push(format!("Not measured: {}.", missing.join(", ")));
    }
    warnings.extend(charted.iter().filter_map(sections::left_out));
    warnings.extend(charted.iter().filter_map(|one| Some(format!("{}.", sections::few_rays(one, args)?))));
    (lead, warnings)
}

/// What to type to make the pictures of one model again, apart from its outputs.
fn command(args: &ChartArgs, path: &Path) -> String {
    typed(args, &[path])
}

/// What to type for the pictures of all models together.
fn commands(args: &ChartArgs) -> String {
    typed(args, &args.models.iter().map(PathBuf::as_path).collect::<Vec<_>>())
}

fn typed(args: &ChartArgs, paths: &[&Path]) -> String {
    let mut words = vec!["bvhc".to_string(), "chart".into()];
    words.extend(paths.iter().map(|path| quoted(&path.to_string_lossy())));
    let output = args.output.as_ref().filter(|_| args.models.len() == paths.len());
    words.extend(["-o".to_string(), output.map_or("chart.html".into(), |output| quoted(&output.to_string_lossy()))]);
    for given in &args.recipes {
        words.extend(["--recipe".to_string(), quoted(&given.typed)]);
    }
    for peer in &args.peers {
        let program =
            std::iter::once(peer.program.to_string_lossy().into_owned()).chain(peer.arguments.iter().cloned());
        words.extend([
            "--peer".to_string(),
            quoted(&format!("{}={}", peer.name, program.collect::<Vec<_>>().join(" "))),
        ]);
    }
    words.extend(["--budget".to_string(), format!("{}s", args.budget().as_secs_f64())]);
    words.extend(["--rounds".to_string(), args.rounds().to_string()]);
    words.extend(["--rays".to_string(), args.rays.to_string()]);
    words.extend(["--accuracy-rays".to_string(), args.accuracy_rays().to_string()]);
    words.extend(args.reading.typed().iter().map(|word| quoted(word)));
    words.join(" ")
}

/// What to type for the stability table, apart from its outputs.
fn stability_command(args: &ChartArgs) -> String {
    let asked = args.stability.iter().flatten().filter(|name| !name.is_empty()).cloned().collect::<Vec<_>>().join(",");
    let [small, large] = args.sizes();
    let which = if asked.is_empty() { String::new() } else { format!("={}", quoted(&asked)) };
    let output = args.output.as_ref().map_or("stability.html".into(), |output| quoted(&output.to_string_lossy()));
    format!(
        "bvhc chart --stability{which} --sizes {small},{large} --rays {} --rounds {} -o {output}",
        args.rays,
        args.rounds()
    )
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,%+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_string();
    }
    format!("'{}'", names::escape(word).replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_where_a_shell_would_split_them() {
        assert_eq!(quoted("a/b-1.obj"), "a/b-1.obj");
        assert_eq!(quoted("a b"), "'a b'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
        assert_eq!(quoted("$x"), "'$x'");
    }
}
