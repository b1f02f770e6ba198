//! Several files by one argument: numbered files, patterns and folders, in every command that takes files.

use crate::{Place, strip};

/// Four numbered caches of strips of 3 to 6 quads, with a hole in the numbers, in `in`; and their models in `models`.
fn numbered() -> Place {
    let place = Place::new();
    for (number, quads) in [(8, 3), (9, 4), (10, 5), (12, 6)] {
        place.write(&format!("models/f.{number:04}.obj"), strip(quads));
    }
    place.ok("build models -o in/");
    place
}

fn first_words(text: &str) -> Vec<&str> {
    text.lines().filter_map(|line| line.split([' ', ':']).next()).collect()
}

const ALL: [&str; 4] = ["in/f.0008.bvhc", "in/f.0009.bvhc", "in/f.0010.bvhc", "in/f.0012.bvhc"];

#[test]
fn every_command_takes_numbered_files_patterns_and_folders() {
    let place = numbered();
    for named in ["in/f.####.bvhc", "in/f.%04d.bvhc", "in/*.bvhc", "in"] {
        assert_eq!(first_words(&place.ok(&format!("check {named}")).out), ALL, "{named}");
        for command in ["info", "stats"] {
            let told = place.ok(&format!("{command} {named} --json")).json();
            let paths: Vec<&str> =
                told["files"].as_array().unwrap().iter().map(|f| f["path"].as_str().unwrap()).collect();
            assert_eq!(paths, ALL, "{command} {named}");
        }
        let told = place.ok(&format!("verify {named} --device cpu --rays 500 --json")).json();
        assert_eq!(told["files"].as_array().map(Vec::len), Some(4), "{named}");
    }
    // A list in the name chooses, and what it names is there.
    assert_eq!(first_words(&place.ok("check in/f.8-10x2####.bvhc").out), [ALL[0], ALL[2]]);
    let missing = place.run("check in/f.8-12####.bvhc");
    assert_eq!(missing.code, 3);
    assert!(missing.err.contains("names a frame without a file: 11; there are 8-10, 12"), "{}", missing.err);
    let none = place.run("stats in/g.####.bvhc");
    assert!(none.code == 3 && none.err.contains("as a pattern of frames it matches none"), "{}", none.err);

    // Files with another padding are not taken, and that is told.
    place.write("in/f.7.bvhc", place.read(ALL[0]));
    let told = place.ok("check in/f.####.bvhc");
    assert_eq!(first_words(&told.out), ALL);
    assert!(told.err.contains("1 file with another padding left out, such as f.7.bvhc"), "{}", told.err);

    let charted = place.ok("chart models/f.####.obj -o page.html --budget 1ms --accuracy-rays 0 --json").json();
    assert_eq!(charted["models"].as_array().map(Vec::len), Some(4));
    assert_eq!(charted["models"][0]["triangles"], 6);
}

#[test]
fn convert_puts_many_files_into_a_folder() {
    let place = numbered();
    let said = place.ok("convert in/f.####.bvhc -o small/deep/ --codec zstd --json").json();
    let outputs: Vec<&str> = said["files"].as_array().unwrap().iter().map(|f| f["output"].as_str().unwrap()).collect();
    assert_eq!(outputs, ALL.map(|path| path.replace("in/", "small/deep/")));
    assert_eq!((said["exit_code"].as_u64(), said["files"][0]["frame"].is_null()), (Some(0), true));
    assert_eq!(first_words(&place.ok("check small/deep").out).len(), 4);
    place.ok("convert small/deep -o back/");
    assert!(ALL.iter().all(|path| place.read(path) == place.read(&path.replace("in/", "back/"))), "there and back");

    // A file that fails does not stop the others.
    place.write("in/f.0009.bvhc", "no cache");
    let mixed = place.run("convert in -o again/ --json");
    assert_eq!((mixed.code, mixed.json()["exit_code"].as_u64()), (10, Some(10)), "{}", mixed.err);
    assert_eq!(mixed.json()["files"][1]["error"]["exit_code"], 1);
    assert_eq!(place.names(), ["again", "back", "in", "models", "small"]);
    assert_eq!(std::fs::read_dir(place.path("again")).unwrap().count(), 3);
}

#[test]
fn outputs_of_many_files_lose_nothing() {
    let place = numbered();
    place.write("other/f.0008.bvhc", place.read(ALL[0]));
    let before: Vec<Vec<u8>> = ALL.iter().map(|path| place.read(path)).collect();
    for (args, told) in [
        ("convert in -o one.bvhc", "4 inputs need a folder to go to, and one.bvhc is not one"),
        ("convert in -o in/ --codec zstd", "and its output in/f.0008.bvhc are one file"),
        ("convert in other/f.0008.bvhc -o new/", "would both become new/f.0008.bvhc"),
        ("convert in/f.0008.bvhc in/f.0008.bvhc -o new/", "in/f.0008.bvhc is named twice"),
        ("convert other/f.0008.bvhc in/f.0009.bvhc -o in/", "in/f.0009.bvhc and its output"),
        ("convert in/f.0008.bvhc -o new.%04d.bvhc", "has a place for a frame's number"),
        ("view in -o one.png", "4 inputs need a folder to go to, and one.png is not one"),
        ("view in --html one.html", "4 inputs need a folder to go to, and one.html is not one"),
    ] {
        let said = place.run(args);
        assert!(said.code == 2 && said.err.contains(told), "bvhc {args}: {} {}", said.code, said.err);
    }
    assert!(ALL.iter().zip(&before).all(|(path, before)| place.read(path) == *before));
    assert_eq!(place.names(), ["in", "models", "other"], "nothing is made");
}

#[test]
fn pictures_and_pages_of_many_files_go_into_a_folder() {
    let place = numbered();
    let said = place.ok("view in -o pictures/ --size 16x16 --json").json();
    let views = said["views"].as_array().unwrap();
    assert_eq!(views.len(), 4);
    for (view, path) in views.iter().zip(ALL) {
        let picture = path.replace("in/", "pictures/").replace(".bvhc", ".png");
        assert_eq!((&view["output"], &view["picture"]["files"][0]["path"]), (&picture.as_str().into(), &path.into()));
        assert!(place.read(&picture).starts_with(b"\x89PNG"));
    }
    place.ok("view in/f.####.bvhc --html pages/");
    assert_eq!(std::fs::read_dir(place.path("pages")).unwrap().count(), 4);
    // Text of several files is told apart.
    let trees = place.ok("view in --tree --depth 0").out;
    assert_eq!(trees.lines().filter(|line| line.starts_with("in/f.")).count(), 4, "{trees}");
    place.ok("view --compare in/f.8-9####.bvhc -o both.png --size 16x16");
}

#[test]
fn a_model_to_compare_with_may_be_a_pattern_or_a_folder_of_one() {
    let place = numbered();
    place.write("single/f.obj", strip(3));
    for source in ["models/f.8-8####.obj", "models/*0008.obj", "single"] {
        place.ok(&format!("check in/f.0008.bvhc --source {source}"));
        place.ok(&format!("verify in/f.0008.bvhc --device cpu --rays 500 --source {source}"));
    }
    for command in ["check", "verify --device cpu --rays 500"] {
        let said = place.run(&format!("{command} in/f.0008.bvhc --source models"));
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(
            said.err.contains("one file is needed, and 4 match: models/f.0008.obj, models/f.0009.obj, …"),
            "{}",
            said.err
        );
    }
}
