//! What is tried: every preset, every method, and what the user gives, each by the flags that are typed for it.

use crate::build::{BuildOptions, METHODS, Named, Preset};
use crate::cli::commands::build::options::TreeArgs;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::names;
use crate::report::tradeoff::{Origin, PEERS, Recipe, Worker};
use clap::Parser;
use std::path::Path;

/// A recipe of `--recipe`.
#[derive(Clone, Debug)]
pub struct Given {
    /// As it was typed.
    pub typed: String,
    name: String,
    flags: String,
    options: BuildOptions,
}

#[derive(Parser)]
#[command(name = "recipe", no_binary_name = true, disable_help_flag = true)]
struct Flags {
    #[command(flatten)]
    tree: TreeArgs,
}

/// The reading of `--method sweep --reinsert 8`, or of `NAME=` and such flags.
pub fn parse(text: &str) -> Result<Given, String> {
    let (name, flags) = match text.split_once('=').filter(|_| !text.trim_start().starts_with('-')) {
        Some((name, flags)) => (Some(name.trim()), flags.trim()),
        None => (None, text.trim()),
    };
    if flags.is_empty() || name.is_some_and(str::is_empty) {
        return Err(
            "it takes the flags of a recipe, such as '--method sweep --reinsert 8', or NAME= before them".into()
        );
    }
    let options = options(flags)?;
    let name = name.map_or_else(|| flags.replace("--method ", "").replace("--preset ", ""), str::to_string);
    Ok(Given { typed: text.to_string(), name, flags: flags.to_string(), options })
}

/// The reading of `obvhs=target/obvhs-parallel/release/obvhs_worker`.
pub fn peer(text: &str) -> Result<Worker, String> {
    let names = || PEERS.map(|(name, _)| name).join(", ");
    let (name, command) = text.split_once('=').ok_or("it takes NAME=PROGRAM")?;
    let mut words = command.split_whitespace();
    let program = words.next().ok_or("it takes NAME=PROGRAM, and there is no program")?;
    let worker = Worker::of(name.trim(), Path::new(program), &words.collect::<Vec<_>>());
    worker.ok_or_else(|| format!("no peer is called {}; there are {}", names::escape(name), names()))
}

fn options(flags: &str) -> Result<BuildOptions, String> {
    let told = |error: clap::Error| {
        let text = error.render().to_string();
        let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage")).filter(|l| !l.is_empty());
        lines.collect::<Vec<_>>().join("; ").trim_start_matches("error: ").to_string()
    };
    if flags.split_whitespace().collect::<Vec<_>>().windows(2).any(|two| two == ["-O", "help"]) {
        return Err("bvhc build -O help lists the options".into());
    }
    let parsed = Flags::try_parse_from(flags.split_whitespace()).map_err(told)?;
    parsed.tree.resolve().map_err(|e| e.to_string())
}

/// Presets and methods, and what was given; what builds the trees of an earlier one is left out.
///
/// # Errors
/// Where two recipes have one name.
pub fn all(given: &[Given]) -> Result<Vec<Recipe>, Failure> {
    let presets = Preset::names().into_iter().map(|(_, name)| (Origin::Preset, name, format!("--preset {name}")));
    let methods = METHODS.iter().map(|row| (Origin::Method, row.name, format!("--method {}", row.name)));
    let mut recipes: Vec<Recipe> = Vec::new();
    for (origin, name, flags) in presets.chain(methods) {
        let options =
            options(&flags).map_err(|e| Failure::new(Exit::Internal, format!("cannot read {flags}")).fact(e))?;
        if !recipes.iter().any(|known| known.builds_as(&options)) {
            recipes.push(Recipe { name: name.to_string(), origin, flags, options });
        }
    }
    for one in given {
        let Given { name, flags, options, .. } = one.clone();
        if recipes.iter().any(|known| known.name == name && !known.builds_as(&options)) {
            return Err(Failure::new(Exit::Usage, format!("cannot chart another recipe {}", names::escape(&name)))
                .fact("there is one of that name, and points are told by their names")
                .help("name it before its flags: --recipe 'NAME=FLAGS'"));
        }
        if !recipes.iter().any(|known| known.builds_as(&options)) {
            recipes.push(Recipe { name, origin: Origin::Given, flags, options });
        }
    }
    Ok(recipes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::advice;

    #[test]
    fn every_preset_and_method_is_there_once() {
        let recipes = all(&[]).unwrap();
        for row in METHODS {
            assert!(recipes.iter().any(|recipe| recipe.options.method == row.method), "{}", row.name);
        }
        for (preset, name) in Preset::names() {
            let own = recipes.iter().find(|recipe| recipe.builds_as(&BuildOptions::preset(preset)));
            assert_eq!(own.map(|recipe| recipe.name.as_str()), Some(name));
        }
        // `auto` and `best` are presets and methods.
        assert_eq!(recipes.len(), METHODS.len() + Preset::names().len() - 2);
    }

    #[test]
    fn recipes_are_read_with_and_without_a_name() {
        let plain = parse("--method sweep --reinsert 8").unwrap();
        assert_eq!((plain.name.as_str(), plain.options.reinsert), ("sweep --reinsert 8", 8));
        let named = parse("cut = --method sweep -O presplit=0.3").unwrap();
        assert_eq!((named.name.as_str(), named.options.presplit), ("cut", 0.3));
        for bad in ["", "x=", "=--method sweep", "sweep", "--method swep", "--method sweep --split-alpha 1", "-O help"]
        {
            assert!(parse(bad).is_err(), "{bad}");
        }
        assert!(parse("--method swep").unwrap_err().contains("sweep"), "{}", parse("--method swep").unwrap_err());
    }

    #[test]
    fn what_a_search_chose_is_read_back_from_its_flags() {
        for recipe in all(&[]).unwrap().iter().filter(|recipe| !recipe.options.method.is_search()) {
            let again = options(&advice::flags(&recipe.options)).unwrap();
            assert!(recipe.builds_as(&again), "{}", advice::flags(&recipe.options));
        }
    }

    #[test]
    fn peers_are_read_with_what_their_programs_are_started_with() {
        let embree = peer("embree=worker libembree4.so 2").unwrap();
        assert_eq!(
            (embree.name, embree.settings.len(), &embree.arguments[..]),
            ("embree", 3, &["libembree4.so".to_string(), "2".into()][..])
        );
        for bad in ["embree", "embree=", "nobody=worker"] {
            assert!(peer(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_name_stands_for_one_recipe() {
        let given = |text: &str| vec![parse(text).unwrap()];
        assert_eq!(all(&given("draft=--method sweep")).unwrap_err().exit, Exit::Usage);
        // A preset by another name is that preset.
        assert_eq!(all(&given("mine=--preset draft")).unwrap(), all(&[]).unwrap());
    }
}
