//! Our recipes by the flags that a user would type.

use bvhc::build::{BuildOptions, Levels};
use bvhc::cli::commands::build::options::TreeArgs;
use clap::Parser;

/// A line here is all that a new recipe needs: its name, and the flags of `bvhc build` that it stands for.
const RECIPES: &[(&str, &str)] = &[
    ("draft", "--preset draft"),
    ("draft + adapted", "--preset draft --adapt 1024"),
    ("draft + 2 rounds", "--preset draft --reinsert 2"),
    ("draft + 2 rounds + adapted", "--preset draft --reinsert 2 --adapt 1024"),
    ("binned", "--preset draft --method binned --bins 16"),
    ("bonsai", "--method bonsai"),
    ("bonsai + 2 rounds", "--method bonsai --reinsert 2"),
    ("bonsai + 8 rounds", "--method bonsai --reinsert 8"),
    ("cut bonsai", "--method bonsai -O presplit=0.3"),
    ("cut bonsai + 8 rounds", "--method bonsai -O presplit=0.3 --reinsert 8"),
    ("sweep", "--method sweep"),
    ("sweep + 8 rounds", "--method sweep --reinsert 8"),
    ("sweep + 8 rounds + adapted", "--method sweep --reinsert 8 --adapt 4096"),
    ("cut sweep + 8 rounds", "--method sweep -O presplit=0.3 --reinsert 8"),
    ("near agglomerative 1", "--method agglomerative -O radius=1"),
    ("near agglomerative 2", "--method agglomerative -O radius=2"),
    ("near agglomerative 4", "--method agglomerative -O radius=4"),
    ("agglomerative", "--method agglomerative"),
    ("agglomerative + 1 round", "--method agglomerative --reinsert 1"),
    ("agglomerative + 1 round + adapted", "--method agglomerative --reinsert 1 --adapt 256"),
    ("agglomerative + 2 rounds", "--method agglomerative --reinsert 2"),
    ("agglomerative + 8 rounds", "--method agglomerative --reinsert 8"),
    ("oabb", "--method oabb"),
    ("oabb along leaves", "--method oabb -O basis=leaf"),
    ("balanced", "--preset balanced"),
    ("balanced + 2 rounds", "--preset balanced --reinsert 2"),
    ("coarse sbvh + 8 rounds", "--preset balanced --reinsert 8"),
    ("sbvh", "--method sbvh"),
    ("sbvh + 8 rounds", "--method sbvh --reinsert 8"),
    ("sbvh + 8 rounds + adapted", "--method sbvh --reinsert 8 --adapt 4096"),
    ("sbvh + 20 rounds + collapse", "--method sbvh --reinsert 20 -O collapse=true"),
    ("auto", "--preset auto"),
    ("best", "--preset best"),
];

pub struct Recipe {
    pub name: String,
    pub options: BuildOptions,
}

#[derive(Parser)]
struct Flags {
    #[command(flatten)]
    tree: TreeArgs,
}

/// The listed recipes whose names are wanted (all if none is), and those given as `NAME=FLAGS`.
pub fn recipes(wanted: &[String], given: &[String]) -> Result<Vec<Recipe>, String> {
    let mut out = Vec::new();
    let listed = RECIPES.iter().map(|(name, flags)| (name.to_string(), flags.to_string()));
    for (name, flags) in listed.filter(|(name, _)| wanted.is_empty() || wanted.contains(name)) {
        out.push(parse(name, &flags)?);
    }
    for text in given {
        let (name, flags) = text.split_once('=').ok_or_else(|| format!("--recipe {text}: it takes NAME=FLAGS"))?;
        out.push(parse(name.trim().to_string(), flags)?);
    }
    let names: Vec<&str> = RECIPES.iter().map(|r| r.0).collect();
    match wanted.iter().find(|w| !names.contains(&w.as_str())) {
        Some(unknown) => Err(format!("no recipe is called {unknown}; there are {}", names.join(", "))),
        None => Ok(out),
    }
}

fn parse(name: String, flags: &str) -> Result<Recipe, String> {
    let args = std::iter::once("peers").chain(flags.split_whitespace());
    let flags = Flags::try_parse_from(args).map_err(|e| format!("recipe {name}: {e}"))?;
    let asked = flags.tree.resolve().map_err(|e| format!("recipe {name}: {e}"))?;
    Ok(Recipe { name, options: BuildOptions { levels: Levels::One, ..asked } })
}
