use super::*;

/// A folder with empty files of these names.
fn folder(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    names.iter().for_each(|name| std::fs::write(folder.path().join(name), "").unwrap());
    folder
}

fn args(frames: Option<&str>, missing: Missing) -> FrameArgs {
    FrameArgs {
        frames: frames.map(|list| list.parse().unwrap()),
        missing: Some(missing),
        fps: None,
        play: None,
        refit: None,
        trees: None,
        rebuild_ratio: None,
        keyframe_every: None,
        literal: false,
    }
}

fn find_in(folder: &tempfile::TempDir, pattern: &str, args: &FrameArgs) -> Result<Sequence, Failure> {
    resolve(&folder.path().join(pattern), args).expect("it is a pattern")
}

/// Number and name of the model of each frame.
fn models(sequence: &Sequence) -> Vec<(i32, String)> {
    let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_string();
    sequence.frames.iter().map(|frame| (frame.number, name(&frame.model))).collect()
}

fn numbers(sequence: &Sequence) -> Vec<i32> {
    sequence.frames.iter().map(|frame| frame.number).collect()
}

#[test]
fn all_frames_come_in_the_order_of_their_numbers() {
    let folder = folder(&["f9.obj", "f10.obj", "f-1.obj", "f0.obj", "f1.mtl", "g3.obj"]);
    let sequence = find_in(&folder, "f%d.obj", &args(Some("-1,0,9,10"), Missing::Error)).unwrap();
    let expected = [(-1, "f-1.obj"), (0, "f0.obj"), (9, "f9.obj"), (10, "f10.obj")];
    assert_eq!(models(&sequence), expected.map(|(n, name)| (n, name.to_string())));
    assert!(sequence.summary.ends_with("4 frames, -1 to 10"), "{}", sequence.summary);
}

#[test]
fn a_missing_frame_is_an_error_left_out_or_held() {
    let folder = folder(&["f.0001.obj", "f.0002.obj", "f.0004.obj", "f.0007.obj"]);
    let with = |frames, missing| find_in(&folder, "f.%04d.obj", &args(frames, missing));
    let error = with(None, Missing::Error).unwrap_err();
    assert_eq!(error.exit, Exit::Io);
    assert_eq!(error.facts, ["3 frames are missing: 3, 5-6; there are 4 frames, 1 to 7"]);
    assert!(error.help.unwrap().contains("--missing skip"));

    let skipped = with(None, Missing::Skip).unwrap();
    assert_eq!(numbers(&skipped), [1, 2, 4, 7]);
    assert!(skipped.warnings[0].ends_with("3 frames are missing: 3, 5-6 (left out)"), "{:?}", skipped.warnings);

    let held = with(None, Missing::Hold).unwrap();
    assert_eq!(numbers(&held), [1, 2, 3, 4, 5, 6, 7]);
    assert_eq!(models(&held)[2].1, "f.0002.obj");
    assert_eq!(models(&held)[5].1, "f.0004.obj");
    assert!(held.frames[5].path.ends_with("f.0006.obj"));

    assert_eq!(with(Some("2,4,7"), Missing::Error).unwrap().frames.len(), 3);
    assert!(with(Some("1-3"), Missing::Error).unwrap_err().facts[0].starts_with("frame 3 is missing;"));
    assert!(with(Some("0-2"), Missing::Hold).unwrap_err().facts[0].contains("none before it to hold"));
    assert!(with(Some("100-200"), Missing::Skip).unwrap_err().facts[0].starts_with("no frame of --frames is there"));
}

#[test]
fn another_padding_is_told() {
    let folder = folder(&["a.0001.obj", "a.0002.obj", "a.3.obj"]);
    let sequence = find_in(&folder, "a.%04d.obj", &args(None, Missing::Error)).unwrap();
    assert_eq!(numbers(&sequence), [1, 2]);
    let expected = "1 file with another padding left out, such as a.3.obj";
    assert!(sequence.warnings[0].ends_with(expected), "{:?}", sequence.warnings);

    let error = find_in(&folder, "a.%03d.obj", &args(None, Missing::Error)).unwrap_err();
    assert!(error.facts[0].contains("3 files have its numbers with another padding, such as a.0001.obj"), "{error:?}");
    assert!(error.help.unwrap().ends_with("a.%04d.obj'"));
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let folder = folder(&["b-02.obj", "b-002.obj", "b#1.obj"]);
    let with = |pattern, frames| find_in(&folder, pattern, &args(frames, Missing::Error)).unwrap_err();
    assert_eq!(with("b%03d.obj", None).facts, ["frame -2 is there twice: b-002.obj and b-02.obj"]);
    assert!(with("c%03d.obj", None).facts[0].contains("it matches none"));
    assert_eq!(with("b1-2#.obj", Some("1")).exit, Exit::Usage);
    assert_eq!(with("no/b#.obj", None).exit, Exit::Io);
    let plain = |name: &str, literal| {
        resolve(&folder.path().join(name), &FrameArgs { literal, ..args(None, Missing::Error) }).is_none()
    };
    assert!(plain("b#1.obj", false), "what exists stands for itself");
    assert!(plain("c#.obj", true) && plain("c.obj", false));
}

#[test]
fn what_is_not_quite_a_pattern_is_told_with_a_way_out() {
    for (text, help) in [
        ("in/a.%4d.obj", "'in/a.%04d.obj'"),
        ("in.%04d/a.obj", "--literal"),
        ("####/a.obj", "folder by folder"),
        ("a.%d.%d.obj", "--literal"),
        ("a.%099d.obj", "%04d"),
        ("a.9-1#.obj", "1001-1100"),
    ] {
        let why = Pattern::parse(Path::new(text)).unwrap().unwrap_err();
        assert!(crate::cli::numbered::way_out(&why).contains(help), "{text}: {why:?}");
    }
}
