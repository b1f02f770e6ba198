use super::options::*;
use super::registry::*;
use super::row::*;
use super::settings::Setting;
use super::table::{OPTIONS, option};
use crate::build::error::BuildError;

const PRESETS_ALL: [Preset; 4] = [Preset::Auto, Preset::Draft, Preset::Balanced, Preset::Best];

fn of(method: Method) -> BuildOptions {
    BuildOptions { method, ..BuildOptions::default() }
}

fn settings(list: &[(&str, &str)]) -> Vec<Setting> {
    list.iter().map(|(name, value)| Setting::new(name, value).unwrap()).collect()
}

#[test]
fn methods_and_presets_find_their_own_rows() {
    for row in METHODS {
        assert_eq!(row.method.info().name, row.name);
    }
    for preset in PRESETS_ALL {
        assert_eq!(preset.info().preset, preset);
        assert_eq!(BuildOptions::preset(preset).method, preset.info().method);
    }
    assert_eq!(PRESETS.len(), PRESETS_ALL.len());
}

#[test]
fn every_row_is_complete() {
    for (i, row) in OPTIONS.iter().enumerate() {
        let name = row.name;
        assert!(!name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c == '-'), "{name}");
        assert!(OPTIONS[..i].iter().all(|other| other.name != name), "{name} has two rows");
        assert!(std::ptr::eq(option(name).unwrap(), row), "{name}");
        assert!(!["help", "method", "preset", "flatten"].contains(&name), "{name} means something else");
        assert!(!row.placeholder.is_empty() && row.placeholder.chars().all(|c| c.is_ascii_uppercase()), "{name}");
        assert!(!row.help.is_empty() && !row.help.contains('\n') && !row.help.ends_with('.'), "{name}: {}", row.help);
        assert!(row.details.ends_with('.') && !row.details.contains('\n'), "{name}: {}", row.details);
        assert!(!row.reader_names().is_empty(), "no method reads {name}");
        for preset in PRESETS_ALL {
            assert!(row.is_valid(&BuildOptions::preset(preset)), "{name} in {preset}");
            assert_eq!(row.parse(&row.default_in(preset)), Ok(row.default_in(preset)), "{name} in {preset}");
        }
        if row.key == InKey::UnlessOff {
            assert!(row.parse("0").is_ok() || row.parse("false").is_ok(), "{name} cannot be off");
        }
    }
}

#[test]
fn ranges_hold_their_ends_and_nothing_else() {
    for row in OPTIONS {
        let takes = |text: String| row.parse(&text).is_ok();
        match row.kind {
            Kind::Count(least, most) => {
                assert!(takes(least.to_string()) && takes(most.to_string()), "{}", row.name);
                assert!(!takes((i64::from(least) - 1).to_string()) && !takes((most + 1).to_string()), "{}", row.name);
            }
            Kind::Real(least, most) => {
                assert!(takes(least.to_string()) && takes(most.to_string()), "{}", row.name);
                let beyond = [least.next_down().to_string(), most.next_up().to_string()];
                assert!(
                    beyond.into_iter().chain(["nan".into(), "inf".into()]).all(|text| !takes(text)),
                    "{}",
                    row.name
                );
            }
            Kind::Switch => assert!(takes("true".into()) && takes("false".into())),
            Kind::Choice(names) => assert!(names().into_iter().all(|name| takes(name.to_string()))),
        }
        assert!(!takes(String::new()) && !takes("some".into()), "{}", row.name);
    }
}

/// Each row sets its own field, and its value reads back.
#[test]
fn a_row_sets_one_field() {
    for row in OPTIONS {
        let base = BuildOptions::default();
        let value = match row.kind {
            Kind::Count(_, most) => most.to_string(),
            Kind::Real(_, most) => most.to_string(),
            Kind::Switch => (row.value(&base) != "true").to_string(),
            Kind::Choice(names) => names().into_iter().find(|name| *name != row.value(&base)).unwrap().to_string(),
        };
        let mut options = base.clone();
        row.set(&mut options, &value).unwrap();
        assert_eq!(row.value(&options), value, "{}", row.name);
        let changed = OPTIONS.iter().filter(|other| other.value(&options) != other.value(&base));
        assert_eq!(changed.map(|other| other.name).collect::<Vec<_>>(), [row.name]);

        let before = options.clone();
        assert!(matches!(row.set(&mut options, "no"), Err(BuildError::Option { option, .. }) if option == row.name));
        assert_eq!(options, before);
    }
}

#[test]
fn options_that_a_method_ignores_are_not_part_of_its_recipe() {
    let base = of(Method::Binned);
    let other = BuildOptions { split_alpha: 0.5, spatial_bins: 7, unsplit: false, ..base.clone() };
    assert_eq!(base.effective(), other.effective());
    let sbvh = BuildOptions { method: Method::Sbvh, ..base.clone() };
    assert_ne!(sbvh.effective(), BuildOptions { method: Method::Sbvh, ..other }.effective());
    assert!(base.effective().contains(&("sah-trav".into(), "1.2".into())));
}

#[test]
fn passes_are_part_of_every_recipe_that_does_them() {
    for row in METHODS.iter().filter(|row| !row.method.is_search()) {
        let without = of(row.method);
        let is_pass = |name: &str| ["reinsert", "adapt", "collapse", "presplit"].contains(&name);
        assert!(without.effective().iter().all(|(name, _)| !is_pass(name)));
        let with = BuildOptions { reinsert: 7, adapt: 9, collapse: true, ..without };
        let named = |name: &str, value: &str| with.effective().contains(&(name.into(), value.into()));
        assert!(named("reinsert", "7") && named("adapt", "9") && named("collapse", "true"));
        let cut = BuildOptions { presplit: 0.25, ..with.clone() };
        assert_eq!(cut.effective() != with.effective(), option("presplit").unwrap().is_read_by(row.method));
    }
}

#[test]
fn a_search_has_another_revision_when_a_method_has_and_reads_no_pass() {
    let is_taken = |method: Method| !method.is_search() && method != Method::Oabb;
    let others: u32 = METHODS.iter().filter(|row| is_taken(row.method)).map(|row| row.revision).sum();
    for method in [Method::Auto, Method::Best] {
        assert!(method.revision() > method.info().revision + others, "what it takes may be adapted");
        let plain = of(method);
        let passed = BuildOptions { reinsert: 5, adapt: 5, collapse: true, bins: 3, ..plain.clone() };
        assert_eq!(plain.effective(), passed.effective());
        assert_ne!(plain.effective(), BuildOptions { split_budget: 1.1, ..plain.clone() }.effective());
    }
    assert_eq!(Method::Sweep.revision(), Method::Sweep.info().revision);
}

#[test]
fn both_zeros_are_one_value() {
    let plus = BuildOptions { split_alpha: 0.0, ..of(Method::Sbvh) };
    let minus = BuildOptions { split_alpha: -0.0, ..of(Method::Sbvh) };
    assert_eq!(plus.effective(), minus.effective());
    assert_eq!(Setting::new("split-alpha", "-0").unwrap().value(), "0");
}

#[test]
fn settings_stand_on_a_preset() {
    assert_eq!(BuildOptions::with_settings(Preset::Best, None, &[]).unwrap(), BuildOptions::preset(Preset::Best));
    let set = settings(&[("bins", "8"), ("unsplit", "false"), ("levels", "one")]);
    let made = BuildOptions::with_settings(Preset::Draft, Some(Method::Sbvh), &set).unwrap();
    let by_hand = BuildOptions {
        method: Method::Sbvh,
        bins: 8,
        unsplit: false,
        levels: Levels::One,
        ..BuildOptions::preset(Preset::Draft)
    };
    assert_eq!(made, by_hand);
}

/// The rule of [`BuildOptions::with_settings`], option by option: kept where the method reads it, a recipe of its own where a search
/// that nobody named does not, and refused everywhere else.
#[test]
fn a_setting_that_is_not_read_is_refused_or_switches_a_search_off() {
    for row in OPTIONS {
        let set = settings(&[(row.name, &row.default_in(Preset::Auto))]);
        let refused_by = |preset, method| match BuildOptions::with_settings(preset, method, &set) {
            Ok(_) => None,
            Err(BuildError::NotRead { option, method, readers, .. }) => {
                let named = match row.name {
                    "rays-for" => "auto and best, and every other method with adapt".to_string(),
                    _ => row.reader_names().join(", "),
                };
                assert_eq!((option, readers), (row.name, named));
                Some(method)
            }
            other => panic!("{other:?}"),
        };
        for info in METHODS {
            let expected = (!row.is_read_in(&of(info.method))).then_some(info.name);
            assert_eq!(refused_by(Preset::Auto, Some(info.method)), expected, "{}", row.name);
        }
        for preset in PRESETS_ALL {
            let method = preset.info().method;
            if method.is_search() && !row.is_read_by(method) && row.is_read_by(Method::Sbvh) {
                let made = BuildOptions::with_settings(preset, None, &set).unwrap();
                assert_eq!(made.method, Method::Sbvh, "{} on {preset}", row.name);
            } else {
                let expected = (!row.is_read_in(&BuildOptions::preset(preset))).then_some(method.info().name);
                assert_eq!(refused_by(preset, None), expected, "{} on {preset}", row.name);
            }
        }
    }
    // What rays are for matters where some are traced.
    let [bake, adapt] = [("rays-for", "bake"), ("adapt", "64")];
    for (method, set, is_read) in [
        (None, vec![bake], true),
        (Some(Method::Sweep), vec![bake], false),
        (Some(Method::Sweep), vec![bake, adapt], true),
        (None, vec![bake, ("reinsert", "8")], false),
    ] {
        let made = BuildOptions::with_settings(Preset::Auto, method, &settings(&set));
        assert_eq!(made.is_ok(), is_read, "{set:?}");
        assert!(made.is_ok_and(|made| made.effective().iter().any(|(name, _)| name == "rays-for")) == is_read);
    }
    let idle = BuildOptions { purpose: Purpose::Bake, ..of(Method::Sweep) };
    assert_eq!(idle.effective(), of(Method::Sweep).effective(), "a build key does not depend on what does nothing");

    // One that sbvh reads does not carry along one that it does not.
    let set = settings(&[("bins", "8"), ("presplit", "0.3")]);
    let refused = BuildOptions::with_settings(Preset::Auto, None, &set).unwrap_err().to_string();
    assert!(
        refused.contains("presplit 0.3: method auto") && refused.contains("by binned, bonsai, sweep, agglom"),
        "{refused}"
    );
}

#[test]
fn a_setting_is_known_valid_and_made_once() {
    match Setting::new("max-leav", "3").unwrap_err() {
        BuildError::UnknownName { name, choices, nearest, .. } => {
            assert_eq!((name.as_str(), nearest.as_deref()), ("max-leav", Some("max-leaf")));
            assert!(choices.starts_with("axes, bins, "), "{choices}");
        }
        other => panic!("{other:?}"),
    }
    match Setting::new("bins", "1").unwrap_err() {
        BuildError::Option { option, value, rule, default } => {
            assert_eq!((option, value.as_str(), default.as_deref()), ("bins", "1", Some("128")));
            assert_eq!(rule, "it must be a whole number between 2 and 256");
        }
        other => panic!("{other:?}"),
    }
    let twice = settings(&[("bins", "8"), ("axes", "all"), ("bins", "9")]);
    let refused = BuildOptions::with_settings(Preset::Draft, None, &twice).unwrap_err().to_string();
    assert!(refused.contains("bins 9: it is set to 8 already"), "{refused}");
}

/// Fields that came with a preset pass, whatever the method; others must be read by it.
#[test]
fn a_field_that_is_not_read_is_refused_unless_a_preset_brought_it() {
    for info in METHODS {
        for preset in PRESETS_ALL {
            let carried = BuildOptions { method: info.method, ..BuildOptions::preset(preset) };
            assert_eq!(carried.refuse_unread(), Ok(()), "{} on {preset}", info.name);
        }
        for row in OPTIONS {
            let known = PRESETS_ALL.map(|preset| row.default_in(preset));
            let candidates = match row.kind {
                Kind::Count(..) | Kind::Real(..) => ["9", "0.7", "1.7"].map(String::from).to_vec(),
                Kind::Switch => ["true", "false"].map(String::from).to_vec(),
                Kind::Choice(names) => names().into_iter().map(String::from).collect(),
            };
            let other = candidates.into_iter().find(|text| row.parse(text).is_ok() && !known.contains(text)).unwrap();
            let mut options = of(info.method);
            row.set(&mut options, &other).unwrap();
            let refused = options.refuse_unread();
            match refused {
                Err(BuildError::NotRead { option, value, method, .. }) => {
                    assert_eq!((option, value, method), (row.name, other, info.name));
                    assert!(!row.is_read_in(&options));
                }
                other => assert_eq!((other, row.is_read_in(&options)), (Ok(()), true), "{} {}", info.name, row.name),
            }
        }
    }
}
