//! What can be typed: the global flags and the list of commands. Each command's own flags stand in its file.

use super::commands::{build, chart, check, completions, convert, explain, info, man, reference, stats, verify, view};
use super::terminal::ColorChoice;
use super::{exit, figures};
use clap::{Args, Parser, Subcommand};

/// Compile triangle scenes into bounding volume hierarchies, once, offline, and store them in a checked cache file that
/// renderers, engines and simulators map into memory and traverse at once.
#[derive(Debug, Parser)]
#[command(name = "bvhc", version, max_term_width = 110, after_help = exit::help_table(), after_long_help = after_long_help())]
#[command(subcommand_required = true, arg_required_else_help = true)]
pub struct Cli {
    #[command(flatten)]
    pub global: GlobalArgs,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Global options")]
pub struct GlobalArgs {
    /// Say nothing but errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say more: times, memory, what was dropped
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    /// When to use colour [default: auto] [env: BVHC_COLOR]
    #[arg(long, global = true, value_name = "WHEN", value_enum)]
    pub color: Option<ColorChoice>,
    /// Write one JSON document to stdout, and errors as JSON to stderr
    #[arg(long, global = true)]
    pub json: bool,
    /// Threads to use; 0 means all cores. The output is the same for any number [default: 0] [env: BVHC_JOBS]
    #[arg(short, long, global = true, value_name = "N", value_parser = figures::parse_jobs)]
    pub jobs: Option<usize>,
    /// Read cache files into memory instead of mapping them: slower, but safe against files that others change meanwhile
    #[arg(long, global = true)]
    pub no_mmap: bool,
    /// Refuse to hold more than this when reading a file, or to set aside more when building, for example 512M [default: 8G] [env: BVHC_MAX_MEMORY]
    #[arg(long, global = true, value_name = "SIZE", value_parser = figures::parse_size)]
    pub max_memory: Option<u64>,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Build(build::BuildArgs),
    Info(info::InfoArgs),
    Stats(stats::StatsArgs),
    Check(check::CheckArgs),
    Verify(verify::VerifyArgs),
    View(view::ViewArgs),
    Chart(chart::ChartArgs),
    Convert(convert::ConvertArgs),
    Explain(explain::ExplainArgs),
    Completions(completions::CompletionsArgs),
    Man(man::ManArgs),
    #[command(hide = true)]
    Reference(reference::ReferenceArgs),
}

impl Command {
    /// What a command writes that is no document, and has no form as one.
    pub fn without_document(&self) -> Option<&'static str> {
        match self {
            Command::Completions(_) => Some("completions are a script for a shell"),
            Command::Man(_) => Some("manual pages are text for man"),
            Command::Reference(_) => Some("the reference is text of the documentation"),
            _ => None,
        }
    }
}

fn after_long_help() -> String {
    format!(
        "Examples:\n  \
         bvhc build rock.glb -o rock.bvhc          compile one scene\n  \
         bvhc build a.obj b.gltf -o caches/        compile several into a folder\n  \
         bvhc check rock.bvhc                      prove that a file is intact and well formed\n  \
         bvhc verify rock.bvhc --source rock.glb   prove that traversing it finds the right hits\n  \
         bvhc stats rock.bvhc                      what the trees are like\n  \
         bvhc view rock.bvhc -o rock.png           a picture of it\n  \
         bvhc chart rock.glb -o rock.html          what each recipe takes to build, and what rays cost then\n\n{}",
        exit::help_table()
    )
}
