//! `bvhc build`: models in, cache files out.
//!
//! `options` are the flags that change the output, `plan` decides what has to be done and why, `make` does it for one output,
//! `outcome` says what was done.

pub mod options;

use crate::cli::Context;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use clap::Args;
use std::path::PathBuf;

/// Compile models into cache files
///
/// Reads OBJ, glTF and GLB. An output whose inputs, options and builder have not changed is left alone.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct BuildArgs {
    /// Models to compile
    #[arg(required = true, value_name = "INPUT")]
    pub inputs: Vec<PathBuf>,
    /// File to write, or with several inputs the folder (`DIR/`) that receives one .bvhc file per input
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    /// Build even what is up to date
    #[arg(short, long)]
    pub force: bool,
    /// Only say what would be built, and why
    #[arg(short = 'n', long)]
    pub dry_run: bool,
    /// With --dry-run: exit with 1 if anything would be built
    #[arg(long, requires = "dry_run")]
    pub exit_code: bool,
    /// Give outputs that are up to date a new time stamp, for Make
    #[arg(long)]
    pub touch: bool,
    /// Do not read the written file back to check it
    #[arg(long)]
    pub no_check: bool,
    /// How sections are stored: raw can be mapped, zstd is smaller
    #[arg(long, value_name = "raw|zstd[:LEVEL]", default_value = "raw")]
    pub codec: String,

    #[command(flatten)]
    pub tree: options::TreeArgs,
}

const EXAMPLES: &str = "Examples:
  bvhc build rock.glb -o rock.bvhc
  bvhc build *.obj -o caches/ --preset balanced
  bvhc build rock.gltf -o rock.bvhc --depfile rock.bvhc.d     for Ninja and Make
  bvhc build rock.glb -o rock.bvhc --dry-run                  says why it would build";

pub fn run(_args: &BuildArgs, _context: &Context) -> Result<Exit, Failure> {
    Err(Failure::new(Exit::Unsupported, "cannot build yet"))
}
