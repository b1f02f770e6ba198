//! The global flags with their defaults: what is typed, else what the environment says, else what is fixed.

use super::args::GlobalArgs;
use super::exit::Exit;
use super::failure::Failure;
use super::figures;
use super::terminal::ColorChoice;
use crate::scene::ReadOptions;
use clap::ValueEnum;

/// What holds for a whole run.
#[derive(Clone, Debug)]
pub struct Settings {
    pub quiet: bool,
    pub verbose: u8,
    pub color: ColorChoice,
    pub json: bool,
    /// Threads; 0 means all cores.
    pub jobs: usize,
    pub no_mmap: bool,
    /// In bytes.
    pub max_memory: u64,
}

impl Settings {
    /// `variable` gives the value of an environment variable.
    ///
    /// # Errors
    /// A variable whose flag is not typed and whose value the flag does not take. One that is empty counts as unset.
    pub fn new(typed: &GlobalArgs, variable: impl Fn(&str) -> Option<String>) -> Result<Settings, Failure> {
        let variable = |name: &'static str| Some(name).zip(variable(name).filter(|value| !value.is_empty()));
        Ok(Settings {
            quiet: typed.quiet,
            verbose: typed.verbose,
            color: choose(typed.color, variable("BVHC_COLOR"), color, ColorChoice::Auto)?,
            json: typed.json,
            jobs: choose(typed.jobs, variable("BVHC_JOBS"), figures::parse_jobs, 0)?,
            no_mmap: typed.no_mmap,
            max_memory: choose(
                typed.max_memory,
                variable("BVHC_MAX_MEMORY"),
                figures::parse_size,
                ReadOptions::DEFAULT_MAX_MEMORY,
            )?,
        })
    }
}

fn choose<T>(
    typed: Option<T>,
    variable: Option<(&str, String)>,
    parse: impl Fn(&str) -> Result<T, String>,
    default: T,
) -> Result<T, Failure> {
    match (typed, variable) {
        (Some(typed), _) => Ok(typed),
        (None, None) => Ok(default),
        (None, Some((name, value))) => parse(&value).map_err(|why| {
            Failure::new(Exit::Usage, format!("cannot take the environment variable {name}"))
                .fact(why)
                .help(format!("unset {name}"))
        }),
    }
}

fn color(text: &str) -> Result<ColorChoice, String> {
    ColorChoice::from_str(text, false).map_err(|_| {
        let names = ColorChoice::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let names: Vec<String> = names.map(|value| value.get_name().to_owned()).collect();
        format!("`{text}` is none of {}", names.join(", "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(jobs: Option<usize>) -> GlobalArgs {
        GlobalArgs { quiet: false, verbose: 0, color: None, json: false, jobs, no_mmap: false, max_memory: None }
    }

    #[test]
    fn what_is_typed_wins_and_what_is_empty_is_unset() {
        let jobs = |flag, value: Option<&str>| {
            let variable = |name: &str| value.filter(|_| name == "BVHC_JOBS").map(str::to_owned);
            Settings::new(&typed(flag), variable).map(|settings| settings.jobs)
        };
        assert_eq!(jobs(None, None), Ok(0));
        assert_eq!(jobs(None, Some("")), Ok(0));
        assert_eq!(jobs(None, Some("3")), Ok(3));
        assert_eq!(jobs(Some(2), Some("3")), Ok(2));
        assert_eq!(jobs(Some(2), Some("many")), Ok(2), "nobody asks the variable");
        let refused = jobs(None, Some("many")).unwrap_err();
        assert!(refused.action.contains("BVHC_JOBS") && refused.facts[0].contains("`many`"), "{refused:?}");
    }

    #[test]
    fn a_colour_that_is_none_is_told_with_the_choices() {
        assert_eq!(color("never"), Ok(ColorChoice::Never));
        assert_eq!(color("blue"), Err("`blue` is none of auto, always, never".to_owned()));
    }
}
