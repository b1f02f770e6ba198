//! Flags that choose a recipe: a preset, a method, and an option of the library's table for each setting. What a flag is called, takes and
//! means stands in that table.

use super::listing;
use crate::build::{BuildError, BuildOptions, Kind, Method, Named, OPTIONS, OptionInfo, Preset, Setting, Spelling};
use crate::cli::advice;
use crate::cli::reading::choice;
use clap::builder::{PossibleValuesParser, TypedValueParser, ValueParser};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

const HEADING: &str = "Tree options";
/// The id of `-O`.
const SETTING: &str = "setting";

/// The flags as typed. Each one overrides the preset.
#[derive(Clone, Debug)]
pub struct TreeArgs {
    preset: Preset,
    method: Option<Method>,
    settings: Vec<Setting>,
}

impl TreeArgs {
    /// Whether anything was typed of how trees are built.
    pub fn is_given(&self) -> bool {
        self.preset != Preset::Auto || self.method.is_some() || !self.settings.is_empty()
    }

    /// What is told of a search that was not named and gave way to a recipe of its own, as [`BuildOptions::with_settings`] says.
    pub fn search_given_up(&self, resolved: &BuildOptions) -> Option<String> {
        let search = BuildOptions::preset(self.preset).method;
        let ignored = self.settings.iter().find(|setting| !setting.option().is_read_by(search))?;
        (self.method.is_none() && search.is_search() && resolved.method != search).then(|| {
            format!(
                "note: the search `{search}` does not read {}, so `{}` builds without a search",
                advice::typed(ignored.option(), ignored.value()),
                resolved.method
            )
        })
    }

    /// The preset with everything that was typed on top.
    ///
    /// # Errors
    /// As [`BuildOptions::with_settings`]: for an option that the method does not read, or one that is set twice.
    pub fn resolve(&self) -> Result<BuildOptions, BuildError> {
        BuildOptions::with_settings(self.preset, self.method, &self.settings)
    }
}

impl Args for TreeArgs {
    fn augment_args(command: Command) -> Command {
        let preset = Arg::new("preset")
            .long("preset")
            .value_name("NAME")
            .value_parser(ValueParser::new(choice::<Preset>()))
            .default_value("auto")
            .help("Where to start from; the flags below override it, and one of sbvh that `auto` or `best` does not read makes it sbvh")
            .long_help(preset_help());
        let method = Arg::new("method")
            .long("method")
            .visible_alias("builder")
            .value_name("NAME")
            .value_parser(ValueParser::new(choice::<Method>()))
            .help(
                "How trees are built: binned (object splits only), sbvh (object and spatial splits), sweep (object splits at every \
                 plane), bonsai (many small sweep trees under one), agglomerative (neighbours merge, from the triangles up), oabb (the same by oriented boxes), or a search \
                 that tries several: auto (stops where the rest cannot pay) or best (the whole list)",
            );
        let setting = Arg::new(SETTING)
            .short('O')
            .value_name("NAME=VALUE")
            .action(ArgAction::Append)
            .value_parser(SettingParser)
            .help(format!(
                "Set any option by its name, as in -O max-leaf=4; `-O help` lists them. Without a flag of their own are {}",
                names_of(Spelling::Setting).join(", ")
            ));
        let flatten = Arg::new("flatten")
            .long("flatten")
            .action(ArgAction::SetTrue)
            .conflicts_with("levels")
            .help("Bake all instances into one tree; short for `--levels one`");
        let flags = OPTIONS.iter().filter(|row| row.spelling == Spelling::Flag).map(flag);
        let all = [preset, method].into_iter().chain(flags).chain([flatten, setting]);
        command.args(all.map(|arg| arg.help_heading(HEADING)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        TreeArgs::augment_args(command)
    }
}

impl FromArgMatches for TreeArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<TreeArgs, clap::Error> {
        let flags = OPTIONS.iter().filter(|row| row.spelling == Spelling::Flag);
        let mut settings: Vec<Setting> =
            flags.filter_map(|row| matches.get_one::<Setting>(row.name)).cloned().collect();
        if matches.get_flag("flatten") {
            settings.extend(Setting::new("levels", "one"));
        }
        settings.extend(matches.get_many::<Setting>(SETTING).into_iter().flatten().cloned());
        let preset = matches.get_one("preset").copied().unwrap_or(Preset::Auto);
        Ok(TreeArgs { preset, method: matches.get_one("method").copied(), settings })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = TreeArgs::from_arg_matches(matches)?;
        Ok(())
    }
}

/// The flag of an option.
fn flag(row: &'static OptionInfo) -> Arg {
    let setting = |text: &str| Setting::new(row.name, text).map_err(|e| reason(&e));
    let parser = match row.kind {
        Kind::Choice(names) => ValueParser::new(PossibleValuesParser::new(names()).try_map(move |text| setting(&text))),
        _ => ValueParser::new(setting),
    };
    Arg::new(row.name)
        .long(row.name)
        .value_name(row.placeholder)
        .value_parser(parser)
        .help(row.help)
        .long_help(format!("{}\n\n{}\n\nRead by {}.", row.help, row.details, row.readers_in_words()))
}

/// What clap puts behind the value that it refuses.
fn reason(error: &BuildError) -> String {
    match error {
        BuildError::Option { rule, .. } => rule.clone(),
        BuildError::UnknownName { name, nearest: Some(nearest), .. } => {
            format!("there is no option {name}; did you mean {nearest}? -O help lists them")
        }
        BuildError::UnknownName { name, choices, .. } => format!("there is no option {name}, only {choices}"),
        other => other.to_string(),
    }
}

/// Reads `name=value`; `help` ends the parse with the list of options.
#[derive(Clone)]
struct SettingParser;

impl TypedValueParser for SettingParser {
    type Value = Setting;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &std::ffi::OsStr) -> Result<Setting, clap::Error> {
        if value == "help" {
            return Err(listing::asked_for());
        }
        let parse = |text: &str| {
            let (name, value) = text.split_once('=').ok_or("it takes NAME=VALUE; `-O help` lists the names")?;
            Setting::new(name, value).map_err(|e| reason(&e))
        };
        TypedValueParser::parse_ref(&parse, command, arg, value)
    }
}

fn names_of(spelling: Spelling) -> Vec<&'static str> {
    OPTIONS.iter().filter(|row| row.spelling == spelling).map(|row| row.name).collect()
}

/// Each preset with its expansion, one a line.
pub fn preset_lines() -> Vec<(String, String)> {
    Preset::names().iter().map(|(p, name)| (name.to_string(), advice::flags(&BuildOptions::preset(*p)))).collect()
}

fn preset_help() -> String {
    let mut text = String::from(
        "Where to start from; the flags below override it. Each preset stands for what follows. \
         With auto or best, a flag that they do not read chooses a recipe: --method sbvh, if no other is named.\n",
    );
    for (name, flags) in preset_lines() {
        text.push_str(&format!("\n{name}:\n  {flags}"));
    }
    text
}
#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{Levels, METHODS};
    use clap::Parser;

    #[derive(Parser)]
    struct Bare {
        #[command(flatten)]
        tree: TreeArgs,
    }

    fn parsed(args: &str) -> Result<TreeArgs, clap::Error> {
        Bare::try_parse_from(std::iter::once("x").chain(args.split_whitespace())).map(|bare| bare.tree)
    }

    fn resolved(args: &str) -> BuildOptions {
        parsed(args).unwrap().resolve().unwrap()
    }

    #[test]
    fn the_default_is_the_library_default() {
        assert_eq!(resolved(""), BuildOptions::default());
    }

    #[test]
    fn flags_override_the_preset() {
        let o = resolved("--preset draft --builder sbvh --bins 8 -O unsplit=false -Omax-leaf=3 --flatten");
        assert_eq!((o.method, o.bins, o.unsplit, o.max_leaf, o.levels), (Method::Sbvh, 8, false, 3, Levels::One));
    }

    #[test]
    fn every_option_can_be_set_by_its_name_and_has_a_flag_only_where_the_table_says_so() {
        let command = TreeArgs::augment_args(Command::new("x"));
        for row in OPTIONS {
            let value = row.default_in(Preset::Auto);
            let [named, flagged] = [format!("-O {}={value}", row.name), format!("--{} {value}", row.name)];
            let [named, flagged] = [parsed(&named), parsed(&flagged)];
            assert_eq!(named.unwrap().settings[0].option().name, row.name);
            assert_eq!(flagged.is_ok(), row.spelling == Spelling::Flag, "{}", row.name);
            let arg = command.get_arguments().find(|arg| arg.get_long() == Some(row.name));
            assert_eq!(arg.is_some_and(|arg| arg.get_help().unwrap().to_string() == row.help), flagged.is_ok());
        }
    }

    #[test]
    fn an_option_is_set_once() {
        for twice in ["-O bins=8 -O bins=9", "--bins 8 -O bins=8", "--flatten -O levels=two"] {
            let refused = parsed(&format!("--preset draft {twice}")).unwrap().resolve();
            assert!(matches!(refused, Err(BuildError::Option { .. })), "{twice}");
        }
        assert!(parsed("--flatten --levels two").is_err());
    }

    #[test]
    fn the_flags_of_a_recipe_give_the_recipe() {
        for (name, flags) in preset_lines() {
            assert_eq!(
                advice::flags(&resolved(&format!("--preset {name}"))),
                advice::flags(&resolved(&flags)),
                "{name}"
            );
        }
        for row in METHODS {
            let mut options = BuildOptions { method: row.method, ..BuildOptions::default() };
            for (option, value) in
                [("bins", "9"), ("unsplit", "false"), ("prune", "3"), ("collapse", "true"), ("presplit", "0.1")]
            {
                crate::build::option(option).unwrap().set(&mut options, value).unwrap();
            }
            assert_eq!(resolved(&advice::flags(&options)).effective(), options.effective(), "{}", row.name);
        }
    }

    #[test]
    fn absurd_values_are_refused() {
        for bad in [
            "--bins 1",
            "--split-alpha 2",
            "--split-budget 0.5",
            "--split-budget nan",
            "--reinsert -1",
            "--adapt 1048577",
            "-O presplit=64",
            "--axes two",
            "-O max-leaf=0",
            "-O sah-trav=0",
            "-O radius=32",
            "-O unsplit=yes",
            "-O clip=round",
            "-O max-leaf",
            "-O octaves=3",
            "-O method=sweep",
        ] {
            assert!(parsed(bad).is_err(), "{bad}");
        }
    }
}
