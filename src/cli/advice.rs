//! What helps: the command line's words for the library's errors, which name no flag themselves.

use super::failure::Failure;
use crate::build::{BuildOptions, METHODS, OptionInfo, Spelling, option};
use crate::cache::rules::Remedy;
use crate::scene::{AnimationChoice, Resemblance, SceneError};
use crate::search::NAMED_RECIPE;
use crate::verify::DeviceError;
use std::error::Error;

/// An error's text and its source as a failure's action and facts.
pub fn told(failure: Failure, error: &impl Error) -> Failure {
    match error.source() {
        Some(source) => failure.fact(source.to_string()),
        None => failure,
    }
}

/// For a model that was not read.
pub fn for_scene(error: &SceneError) -> Option<String> {
    let text = match error {
        SceneError::MissingBuffer { .. } => "put the file there, or export the model as one .glb file",
        SceneError::OutsideFolder { .. } => "if you trust this model, allow it with --allow-outside",
        SceneError::NotObj { resembles, .. } | SceneError::InPlaceOfData { resembles, .. } => match resembles {
            Resemblance::LfsPointer => "it is a Git LFS pointer; fetch the file that it stands for: git lfs pull",
            Resemblance::WebPage => "it looks like a web page; download the file itself once more",
            Resemblance::Capitals => "keywords of OBJ are in small letters; export the model once more",
            Resemblance::Utf16 => "save it as UTF-8, for example with: iconv -f UTF-16 -t UTF-8 MODEL > MODEL2",
            Resemblance::CacheFile => "name the model that it was built from; bvhc info tells which",
            Resemblance::Json => "it looks like a glTF; name it so: *.gltf",
            Resemblance::Glb => "it looks like a glTF in its binary form; name it so: *.glb",
            Resemblance::Obj => "it looks like an OBJ; name it so: *.obj",
            Resemblance::Nothing => "export the model once more as OBJ or glTF",
        },
        SceneError::Degenerate { .. } => "leave them out with --degenerate drop",
        SceneError::NoSuchAnimation { asked: AnimationChoice::Name(name), .. } if cut(name).is_some() => {
            return cut(name);
        }
        SceneError::Malformed { line: Some(line), .. } => {
            return Some(format!("correct line {line}, or export the model once more"));
        }
        SceneError::Malformed { .. } => {
            "export the model once more; all that is wrong with a glTF is listed by: npx @gltf-transform/cli validate MODEL"
        }
        SceneError::TooMany { line: Some(_), .. } => "export the model in triangles, or divide such faces before",
        SceneError::TooMany { .. } => "split the model into several",
        SceneError::NoSuchScene { count: 0, .. } => "leave out --scene: all nodes are read then",
        SceneError::NoSuchScene { .. } => "choose one of them, or leave out --scene for the one that the file names",
        SceneError::NoSuchAnimation { count: 0, .. } => "it stands at rest: leave out --clip, --time, --fps and --play",
        SceneError::NoSuchAnimation { .. } => {
            "choose one of them by its number, or by its name letter by letter: --clip NUMBER"
        }
        SceneError::UnknownFormat { .. } => "convert it to one of these",
        SceneError::UnsupportedExtension { extension, ignorable: true, .. } if extension == "CESIUM_RTC" => {
            return Some(format!("build the model around its own origin: --ignore-extension {extension}"));
        }
        SceneError::UnsupportedExtension { extension, ignorable: true, .. } => {
            return Some(format!(
                "export the model without it, or read it as if it were not there: --ignore-extension {extension}"
            ));
        }
        SceneError::UnsupportedExtension { .. } => {
            "decode the model once, for example with: npx @gltf-transform/cli cp in.glb out.glb"
        }
        SceneError::UnsupportedVersion { .. } => "export it as glTF 2.0",
        SceneError::Memory { .. } => "raise it with --max-memory",
        _ => return None,
    };
    Some(text.to_string())
}

/// For who meant by `--clip` how spatial splits cut, which that flag said once.
pub fn cut(name: &str) -> Option<String> {
    let row = option("clip")?;
    row.parse(name).ok().map(|value| format!("what a spatial split cuts is set by {}", typed(row, &value)))
}

/// For a file that breaks a rule.
pub fn for_rule(remedy: Remedy) -> &'static str {
    match remedy {
        Remedy::Rebuild => {
            "Build the file again from its model: bvhc build MODEL -o FILE --force. A cache is made again, never mended."
        }
        Remedy::Newer => {
            "Use the version of bvhc that wrote the file, or a later one; or build the file again with this one: bvhc build MODEL -o FILE --force."
        }
        Remedy::Decoder => {
            "Use a bvhc with what decodes it, or a later version; or build the file again: bvhc build MODEL -o FILE --force."
        }
        Remedy::RightFile => {
            "Check the path; mark *.bvhc as binary in .gitattributes; or build the file again: bvhc build MODEL -o FILE --force."
        }
        Remedy::MoreMemory => {
            "Raise the limit if you trust the file: --max-memory 32G. Raw sections are mapped and take none."
        }
        Remedy::LeaveOut => "Nothing, or leave the section out: bvhc convert FILE -o FILE2 --strip-unknown.",
        _ => {
            "Build again: bvhc build MODEL -o FILE. If the model has not changed and it still happens, please report it."
        }
    }
}

/// What to type to give an option of builds a value.
pub fn typed(row: &OptionInfo, value: &str) -> String {
    match row.spelling {
        Spelling::Setting => format!("-O {}={value}", row.name),
        _ => format!("--{} {value}", row.name),
    }
}

/// What to type to build by these options.
pub fn flags(options: &BuildOptions) -> String {
    let typed = options.effective().into_iter().filter_map(|(name, value)| Some(typed(option(&name)?, &value)));
    std::iter::once(format!("--method {}", options.method)).chain(typed).collect::<Vec<_>>().join(" ")
}

/// A note of a file, with the recipe that it may name as what to type: `method=sbvh axes=all` becomes `--method sbvh --axes all`.
pub fn note(text: &str) -> String {
    let Some((start, recipe)) = text.split_once(NAMED_RECIPE) else { return text.to_string() };
    let flag = |pair: &str| match pair.split_once('=')? {
        ("method", value) => Some(format!("--method {value}")),
        (name, value) => Some(typed(option(name)?, value)),
    };
    let flags: Option<Vec<String>> = recipe.split(' ').map(flag).collect();
    flags.map_or_else(|| text.to_string(), |flags| format!("{start}{NAMED_RECIPE}{}", flags.join(" ")))
}

/// The notes of a file as they are told. Unless more was asked for, those of a search are cut to what it took and how to build that without it, of all trees together: what it
/// tried, and each tree by itself, is told by `-v`.
pub fn notes(all: &[String], verbose: u8) -> Vec<String> {
    let is_search = |name: &str| METHODS.iter().any(|row| row.name == name && row.method.is_search());
    let mut taken = false;
    let mut is_shown = |text: &&String| {
        let Some((of, said)) = text.split_once(": ") else { return true };
        let is_first = !taken && is_search(of);
        taken |= is_first;
        verbose > 0
            || is_first
            || !is_search(of.split(", tree ").next().unwrap_or(of))
            || (is_search(of) && said.starts_with(NAMED_RECIPE))
    };
    let shown: Vec<String> = all.iter().filter(&mut is_shown).map(|text| note(text)).collect();
    let hidden = all.len() - shown.len();
    let more = (hidden > 0).then(|| format!("… and {hidden} more; -v shows them"));
    shown.into_iter().chain(more).collect()
}

/// Whether a note has flags to be copied, which must not be broken into lines.
pub fn names_a_recipe(note: &str) -> bool {
    note.contains(NAMED_RECIPE)
}

/// For a device that gave no answer.
pub fn for_device(error: &DeviceError) -> Option<&'static str> {
    Some(match error {
        DeviceError::NoLibrary { .. } => {
            "install an ICD loader and a driver (Debian: apt install ocl-icd-libopencl1 pocl-opencl-icd)"
        }
        DeviceError::NoDevice { .. } => "install a driver (Debian: apt install pocl-opencl-icd)",
        DeviceError::NoSuchDevice { .. } => "bvhc verify --list-devices",
        DeviceError::Unusable { .. } => "choose another one from: bvhc verify --list-devices",
        DeviceError::OutOfMemory { .. } | DeviceError::TooMany { .. } => "pass --device cpu",
        DeviceError::Build { .. } => "update the driver and report this log, or pass --device cpu",
        DeviceError::SelfTest { .. } => "update the driver and report this to its makers, or pass --device cpu",
        DeviceError::Runtime { .. } => "update the driver, or pass --device cpu",
        DeviceError::Malformed { .. } => "bvhc check FILE",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recipe_in_a_note_becomes_what_to_type() {
        let told = "auto: without the search: method=sbvh axes=all max-leaf=8";
        assert_eq!(note(told), "auto: without the search: --method sbvh --axes all -O max-leaf=8");
        // Notes are the file's: what is no recipe stays as it is.
        for odd in ["auto: took sbvh", "without the search: method", "without the search: colour=red", ""] {
            assert_eq!(note(odd), odd);
        }
    }

    #[test]
    fn what_a_search_tried_is_told_where_more_is_asked_for() {
        let all = [
            "animation 0 holds its last value",
            "auto: of 2 trees took sbvh for 2",
            "auto: tried, by 64 rays: sbvh 0.0 %",
            "auto, tree 1: took sbvh for 8 triangles",
            "auto, tree 1: without the search: method=sbvh",
            "auto: without the search: method=sbvh",
            "sbvh: no search",
        ]
        .map(String::from);
        let told = notes(&all, 0);
        let few = [&all[0], &all[1], "auto: without the search: --method sbvh", &all[6], "… and 3 more; -v shows them"];
        assert_eq!(told, few);
        assert_eq!(notes(&all, 1).len(), all.len());
        assert_eq!(notes(&all[..2], 0), all[..2]);
    }

    #[test]
    fn every_remedy_has_words_of_the_program() {
        for remedy in Remedy::ALL {
            let words = for_rule(remedy);
            assert!(words.ends_with('.') && (words.contains("bvhc ") || words.contains("--")), "{remedy:?}: {words}");
        }
    }
}
