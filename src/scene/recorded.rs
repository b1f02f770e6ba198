//! The options of reading that decide what is read, as a file records them and a build key holds them: one row each.

use super::animation::{AnimationChoice, Moment};
use super::options::{Degenerate, ReadOptions};
use std::collections::BTreeSet;

/// One option by name.
struct Row {
    name: &'static str,
    /// The value; `None` where the option is not recorded, so that a recipe without it stays what it was before there was such an option.
    write: fn(&ReadOptions) -> Option<String>,
    /// Takes the value over. What is no value leaves the option as it is.
    #[cfg_attr(not(any(feature = "cli", test)), allow(dead_code))]
    read: fn(&mut ReadOptions, &str),
}

/// In the order in which META and the build key name them. `allow_outside` and `max_memory` only decide whether there is a result.
const ROWS: [Row; 8] = [
    Row {
        name: "degenerate",
        write: |options| Some(options.degenerate.name().to_owned()),
        read: |options, text| {
            let known = [Degenerate::Keep, Degenerate::Drop, Degenerate::Error];
            options.degenerate = known.into_iter().find(|d| d.name() == text).unwrap_or(options.degenerate);
        },
    },
    Row {
        name: "scene",
        write: |options| Some(options.scene.map_or_else(|| "default".to_owned(), |number| number.to_string())),
        read: |options, text| options.scene = text.parse().ok(),
    },
    Row {
        name: "animation_number",
        write: |options| match &options.moment.as_ref()?.animation {
            AnimationChoice::Number(number) => Some(number.to_string()),
            _ => None,
        },
        read: |options, text| {
            if let Ok(number) = text.parse() {
                moment(options).animation = AnimationChoice::Number(number);
            }
        },
    },
    Row {
        name: "animation",
        write: |options| match &options.moment.as_ref()?.animation {
            AnimationChoice::Name(name) => Some(name.clone()),
            _ => None,
        },
        read: |options, text| moment(options).animation = AnimationChoice::Name(text.to_owned()),
    },
    Row {
        name: "time",
        // A moment always has this one, and a word stands for the first key.
        write: |options| {
            Some(options.moment.as_ref()?.time.map_or_else(|| "first".to_owned(), |time| time.to_string()))
        },
        read: |options, text| moment(options).time = text.parse().ok(),
    },
    Row {
        name: "ignore_extensions",
        write: |options| {
            // In one order, each once, however they were given.
            let ignored: BTreeSet<&str> = options.ignore_extensions.iter().map(String::as_str).collect();
            (!ignored.is_empty()).then(|| ignored.into_iter().collect::<Vec<_>>().join(","))
        },
        read: |options, text| options.ignore_extensions = text.split(',').map(str::to_owned).collect(),
    },
    Row {
        name: VERTICES,
        write: |options| options.vertices.then(|| YES.to_owned()),
        read: |options, text| options.vertices = text == YES,
    },
    Row {
        name: "vertex_bits",
        write: |options| Some(options.vertex_bits?.to_string()),
        read: |options, text| options.vertex_bits = text.parse().ok(),
    },
];

const VERTICES: &str = "vertices";
const YES: &str = "true";

fn moment(options: &mut ReadOptions) -> &mut Moment {
    options.moment.get_or_insert_default()
}

impl ReadOptions {
    /// The options that decide what is read, by name, as a file records them and a build key holds them.
    pub fn effective(&self) -> Vec<(String, String)> {
        ROWS.iter().filter_map(|row| Some((row.name.to_owned(), (row.write)(self)?))).collect()
    }

    /// What [`ReadOptions::effective`] recorded among a file's options; the default where it does not say.
    pub(crate) fn recorded(among: &[(String, String)]) -> ReadOptions {
        let mut options = ReadOptions::default();
        for row in &ROWS {
            if let Some((_, value)) = among.iter().find(|(name, _)| name == row.name) {
                (row.read)(&mut options, value);
            }
        }
        options
    }

    /// What is recorded of geometry that no file was read for: whether it keeps the numbers of its vertices.
    pub(crate) fn effective_of_arrays(vertices: bool) -> Vec<(String, String)> {
        let all = ReadOptions { vertices, ..ReadOptions::default() }.effective();
        all.into_iter().filter(|(name, _)| name == VERTICES).collect()
    }
}

/// Whether recorded options ask for the numbers of vertices.
pub(crate) fn asks_for_vertices(recorded: &[(String, String)]) -> bool {
    recorded.iter().any(|(name, value)| name == VERTICES && value == YES)
}

#[cfg(test)]
mod tests {
    use super::super::animation::Seconds;
    use super::*;

    fn pairs(list: &[(&str, &str)]) -> Vec<(String, String)> {
        list.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect()
    }

    #[test]
    fn what_is_recorded_is_read_back() {
        let animations = [
            AnimationChoice::Only,
            AnimationChoice::Number(3),
            AnimationChoice::Name("3".into()),
            AnimationChoice::Name("a,b=c".into()),
        ];
        let times = [None, Seconds::new(0.1), Seconds::new(-1e-9), Seconds::new(1e300)];
        let moments = animations
            .iter()
            .flat_map(|animation| times.map(|time| Some(Moment { animation: animation.clone(), time })));
        for moment in moments.chain([None]) {
            for degenerate in [Degenerate::Keep, Degenerate::Drop, Degenerate::Error] {
                for (scene, vertices) in [(None, false), (Some(0), true), (Some(u32::MAX), false)] {
                    for ignore_extensions in [vec![], vec!["A_b".to_owned()], vec!["A_b".to_owned(), "C_d".to_owned()]]
                    {
                        let moment = moment.clone();
                        let options = ReadOptions {
                            degenerate,
                            scene,
                            moment,
                            ignore_extensions,
                            vertices,
                            ..ReadOptions::default()
                        };
                        let recorded = options.effective();
                        assert_eq!(ReadOptions::recorded(&recorded), options, "{recorded:?}");
                        assert_eq!(asks_for_vertices(&recorded), vertices);
                    }
                }
            }
        }
    }

    #[test]
    fn recipes_of_old_have_the_names_that_they_had() {
        let plain = [("degenerate", "drop"), ("scene", "default")];
        assert_eq!(ReadOptions::default().effective(), pairs(&plain));
        let all = ReadOptions {
            degenerate: Degenerate::Keep,
            scene: Some(2),
            moment: Some(Moment { animation: AnimationChoice::Name("Walk".into()), time: None }),
            ignore_extensions: vec!["X_b".into(), "X_a".into(), "X_b".into()],
            vertices: true,
            vertex_bits: super::super::VertexBits::new(16),
            ..ReadOptions::default()
        };
        let named = [
            ("degenerate", "keep"),
            ("scene", "2"),
            ("animation", "Walk"),
            ("time", "first"),
            ("ignore_extensions", "X_a,X_b"),
            ("vertices", "true"),
            ("vertex_bits", "16"),
        ];
        assert_eq!(all.effective(), pairs(&named));
        assert_eq!(ReadOptions::effective_of_arrays(true), pairs(&named[5..6]));
        assert_eq!(ReadOptions::effective_of_arrays(false), []);
    }

    #[test]
    fn what_no_file_records_is_the_default() {
        let odd = pairs(&[("degenerate", "melt"), ("scene", "main"), ("animation_number", "-1"), ("bins", "8")]);
        assert_eq!(ReadOptions::recorded(&odd), ReadOptions::default());
        assert_eq!(ReadOptions::recorded(&[]), ReadOptions::default());
    }
}
