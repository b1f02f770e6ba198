//! `verify`: verdicts, reports, single rays, devices. Faults themselves are the matter of `tests/verify_faults.rs`.

use crate::common::faults::{Fault, plant};
use crate::{Place, Said, repository, said};
use bvhc::cache::{Cache, Image, Meta, WriteOptions, write_file};
use bvhc::exec::Executor;

/// A folder with `roof.bvhc`, made from a sample by split builds, and its model.
fn roof() -> Place {
    let place = Place::new();
    std::fs::copy(repository().join("samples/corrugated_roof.obj"), place.path("roof.obj")).unwrap();
    place.ok("build roof.obj -o roof.bvhc -q");
    place
}

/// Write `to` as `from` with a fault, hashes and all; the records that may be blamed.
fn spoil(place: &Place, from: &str, to: &str, fault: Fault) -> Vec<String> {
    let cache = Cache::open(place.path(from)).unwrap();
    let mut image = Image {
        nodes: cache.nodes().to_vec(),
        triangles: cache.triangles().to_vec(),
        geoms: cache.geoms().to_vec(),
        blases: cache.blases().to_vec(),
        tlas_nodes: cache.tlas_nodes().to_vec(),
        instances: cache.instances().to_vec(),
        names: Vec::new(),
        flags: cache.header().tree_flags,
        ..Image::default()
    };
    let planted = plant(&mut image, fault).expect("something to break");
    let unchecked = WriteOptions { check: false, ..WriteOptions::default() };
    write_file(&place.path(to), &image, &Meta::default(), &unchecked, &Executor::current()).unwrap();
    planted.records.iter().map(|r| format!("{}[{r}]", planted.section)).collect()
}

/// The text without the times, which differ from run to run.
fn timeless(said: &Said) -> String {
    let unit = |w: &str| matches!(w, "s" | "ms" | "rays/s" | "M");
    let number = |w: &str| w.parse::<f64>().is_ok() && w.contains('.');
    let line = |l: &str| l.split_whitespace().filter(|w| !unit(w) && !number(w)).collect::<Vec<_>>().join(" ");
    said.out.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_sound_file_is_right_with_and_without_its_model() {
    let place = roof();
    for args in
        ["verify roof.bvhc --rays 20k --device cpu", "verify roof.bvhc --rays 20k --device cpu --source roof.obj"]
    {
        let said = place.ok(args);
        assert!(said.out.starts_with("roof.bvhc: right"), "{}", said.out);
        assert!(said.out.contains("20,000 rays") && said.out.contains("0 mismatches"), "{}", said.out);
        assert!(said.out.contains("0 missed, 0 farther, 0 false"), "{}", said.out);
    }
    assert_eq!(place.ok("verify roof.bvhc --rays 1k -q").out, "");
    let sets = place.ok("verify roof.bvhc --rays 1k --rays-from edges,vertices -v --device cpu").out;
    assert!(sets.contains("rays of 2 sets") && sets.contains("  edges") && !sets.contains("surface"), "{sets}");
    let any = place.ok("verify roof.bvhc --rays 1k --any-hit --device cpu --json").json();
    assert_eq!(
        (any["asked"].as_str(), any["files"][0]["devices"][0]["total"]["rays"].as_u64()),
        (Some("any-hit"), Some(1000))
    );
    let brute = place.ok("verify roof.bvhc --rays 1k --reference brute --device cpu").out;
    assert!(brute.contains("judges all 1,000 rays"), "{brute}");
}

#[test]
fn a_wrong_file_is_1_with_a_ray_that_shows_it() {
    let place = roof();
    let records = spoil(&place, "roof.bvhc", "bad.bvhc", Fault::ShrunkBox);
    let said = place.run("verify bad.bvhc --source roof.obj --rays 50k --device cpu");
    assert_eq!(said.code, 1, "{}{}", said.out, said.err);
    assert!(said.out.starts_with("bad.bvhc: wrong") && said.out.contains("cpu missed a hit"), "{}", said.out);
    assert!(records.iter().any(|r| said.out.contains(&format!("to blame  {r}"))), "{records:?} in {}", said.out);

    // The command that it prints shows the same ray, wrong again, and next to the sound file, right.
    let help = said.out.lines().find_map(|l| l.strip_prefix("help: bvhc ")).expect("a command");
    let again = place.run(help);
    assert_eq!(again.code, 1, "{help}\n{}{}", again.out, again.err);
    assert!(again.out.contains("wrong: ") && again.out.contains("NODE[0]"), "{}", again.out);
    let sound = place.ok(&help.replace("bad.bvhc", "roof.bvhc"));
    assert!(sound.out.contains("right"), "{}", sound.out);

    let json = place.run("verify bad.bvhc --rays 50k --device cpu --json");
    let document = json.json();
    assert_eq!((json.code, document["exit_code"].as_u64()), (1, Some(1)));
    let first = &document["files"][0]["devices"][0]["first_mismatch"];
    assert_eq!(
        (first["class"].as_str(), first["blame"]["section"].as_str()),
        (Some("missed"), Some("NODE")),
        "{first:#}"
    );
    assert!(!document["files"][0]["right"].as_bool().unwrap());
    assert_eq!(place.run("verify bad.bvhc --rays 50k -q --device cpu").code, 1);
}

#[test]
fn several_files_are_all_judged_and_the_codes_combined() {
    let place = roof();
    spoil(&place, "roof.bvhc", "bad.bvhc", Fault::SwappedChildren);
    let said = place.run("verify bad.bvhc roof.bvhc --rays 20k --device cpu");
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.out.contains("bad.bvhc: wrong") && said.out.contains("roof.bvhc: right"), "{}", said.out);
    assert_eq!(place.run("verify roof.bvhc none.bvhc --rays 1k --device cpu").code, 10);
    assert_eq!(place.run("verify none.bvhc --rays 1k --device cpu").code, 3);
    let mut bytes = place.read("roof.bvhc");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    place.write("torn.bvhc", bytes);
    assert_eq!(place.run("verify torn.bvhc --rays 1k --device cpu").code, 1);
}

#[test]
fn junit_is_well_formed_and_counts_what_failed() {
    let place = roof();
    spoil(&place, "roof.bvhc", "bad <&\"'> file.bvhc", Fault::ShrunkBox);
    let mut command = place.command();
    command.args(["verify", "roof.bvhc", "bad <&\"'> file.bvhc", "none.bvhc", "--rays", "70k", "--device", "cpu"]);
    let said = said(command.args(["--junit", "report.xml"]).output().unwrap());
    assert_eq!(said.code, 10, "{}{}", said.out, said.err);
    let xml = String::from_utf8(place.read("report.xml")).unwrap();
    let elements = parse(&xml);
    let count = |name: &str| elements.iter().filter(|(n, _)| n == name).count();
    let sets = bvhc::verify::SETS.len();
    assert_eq!((count("testsuites"), count("testsuite"), count("testcase")), (1, 3, 2 * sets + 1), "{xml}");
    assert_eq!(count("error"), 1);
    assert!(count("failure") > 0 && count("failure") <= sets);
    let attribute = |at: usize, name: &str| elements[at].1.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str());
    assert_eq!(attribute(0, "tests"), Some(format!("{}", 2 * sets + 1).as_str()));
    assert_eq!(attribute(0, "failures"), Some(count("failure").to_string().as_str()));
    assert!(
        elements.iter().any(|(n, a)| n == "testsuite" && a.contains(&("name".into(), "bad <&\"'> file.bvhc".into()))),
        "{xml}"
    );
    assert!(xml.contains("to blame NODE["), "{xml}");
    assert_eq!(place.run("verify roof.bvhc --rays 1k --junit no/such/folder.xml").code, 3);
}

/// The elements of an XML text in order, with their attributes; panics where it is not well-formed.
fn parse(xml: &str) -> Vec<(String, Vec<(String, String)>)> {
    let mut rest = xml.strip_prefix("<?xml version=\"1.0\" encoding=\"UTF-8\"?>").expect("a declaration");
    let (mut open, mut found) = (Vec::new(), Vec::new());
    while let Some(start) = rest.find('<') {
        text(&rest[..start]);
        let end = rest.find('>').expect("an end of the tag");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name), "tags nest");
            continue;
        }
        let (body, empty) = tag.strip_suffix('/').map_or((tag, false), |b| (b, true));
        let (name, mut attributes) = body.split_once(' ').unwrap_or((body, ""));
        let mut pairs = Vec::new();
        while let Some((key, value)) = attributes.trim_start().split_once("=\"") {
            let (value, tail) = value.split_once('"').expect("a closing quote");
            assert!(!value.contains('<') && pairs.iter().all(|(k, _)| k != key));
            pairs.push((key.to_string(), text(value)));
            attributes = tail;
        }
        assert!(attributes.trim().is_empty(), "{attributes}");
        found.push((name.to_string(), pairs));
        if !empty {
            open.push(name.to_string());
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty());
    found
}

/// Text without its escapes, all of which are known.
fn text(escaped: &str) -> String {
    let known = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#10;", "\n"), ("&amp;", "&")];
    let mut bare = escaped.to_string();
    known.iter().for_each(|(entity, _)| bare = bare.replace(entity, ""));
    assert!(!bare.contains('&') && bare.chars().all(|c| !c.is_control() || c == '\n'), "{escaped}");
    known.iter().fold(escaped.to_string(), |text, (entity, plain)| text.replace(entity, plain))
}

#[test]
fn a_ray_is_replayed_with_its_log() {
    let place = roof();
    let ray = "0.25,-3,40,0,-0,-1";
    let said = place.run(&format!("verify roof.bvhc --ray {ray} --device cpu"));
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
    let steps = ["roof.bvhc: ray 0.25,-3,40,0,-0,-1\n", "NODE[0] [", "\ncpu ", "\noracle "];
    for step in steps {
        assert!(said.out.contains(step), "{step} in {}", said.out);
    }
    let document = place.ok(&format!("verify roof.bvhc --json --device cpu --ray {ray}")).json();
    assert_eq!(document["ray"], ray);
    assert_eq!(document["files"][0]["steps"][0]["step"], "root");
    for wrong in ["1,2,3", "1,2,3,4,5,6,7", "a,b,c,d,e,f"] {
        assert_eq!(place.run(&format!("verify roof.bvhc --ray {wrong}")).code, 2, "{wrong}");
    }
    assert_eq!(place.run("verify roof.bvhc --ray 0,0,0,0,0,1 --rays 10").code, 2);
}

#[test]
fn the_same_seed_gives_the_same_verdict_with_any_number_of_threads() {
    let place = roof();
    spoil(&place, "roof.bvhc", "bad.bvhc", Fault::SwappedBoxes);
    let run = |rest: &str| timeless(&place.run(&format!("verify bad.bvhc --rays 30k --device cpu {rest}")));
    let first = run("--jobs 1");
    assert_eq!(first, run("--jobs 2"));
    assert_eq!(first, run("--jobs 5 --no-mmap"));
    assert_ne!(first, run("--seed 2"));
}

#[test]
fn without_opencl_the_cpu_traces_and_says_so_unless_a_device_is_required() {
    let place = roof();
    let run = |args: &str| {
        let mut command = place.command();
        command.env("OCL_ICD_VENDORS", "/nonexistent").env("OCL_ICD_FILENAMES", "");
        said(command.args(args.split_whitespace()).output().unwrap())
    };
    let alone = run("verify roof.bvhc --rays 1k");
    assert_eq!(alone.code, 0, "{}", alone.err);
    assert!(
        alone.err.contains("there is no OpenCL device") && alone.out.contains("cpu "),
        "{}{}",
        alone.out,
        alone.err
    );
    for args in ["--require-device", "--require-device --device cpu", "--device opencl", "--device opencl:0"] {
        let said = run(&format!("verify roof.bvhc --rays 1k {args}"));
        assert_eq!(said.code, 5, "{args}: {}{}", said.out, said.err);
        assert!(said.err.contains("help: "), "{args}: {}", said.err);
    }
    let all = run("verify roof.bvhc --rays 1k --device all");
    assert!(all.code == 0 && all.err.contains("there is no OpenCL device"), "{}", all.err);
    // A report is there even where nothing could be done.
    assert_eq!(run("verify roof.bvhc --require-device --junit report.xml").code, 5);
    let report = String::from_utf8(place.read("report.xml")).unwrap();
    assert!(report.contains("errors=\"1\"") && report.contains("type=\"unsupported\""), "{report}");
    let list = run("verify --list-devices");
    assert_eq!((list.code, list.out.lines().count()), (0, 1), "{}", list.out);
    let json = run("verify --list-devices --json").json();
    assert_eq!((json["schema"].as_str(), json["devices"].as_array().map(Vec::len)), (Some("bvhc.devices.v1"), Some(0)));
}

#[test]
fn opencl_devices_are_listed_and_traced_on() {
    let place = roof();
    let listed = place.ok("verify --list-devices --json").json();
    let devices = listed["devices"].as_array().unwrap();
    if devices.is_empty() {
        println!("skipped: there is no OpenCL device");
        return;
    }
    assert!(place.ok("verify --list-devices").out.contains("opencl:0  "));
    let said = place.ok("verify roof.bvhc --source roof.obj --rays 20k --device all --require-device");
    assert_eq!(said.out.matches("20,000 rays  ").count(), 1 + devices.len(), "{}", said.out);
    assert!(place.ok("verify roof.bvhc --rays 1k").out.contains("opencl:"));
    // No compiler of kernels is done in so short a time: the device is given up, and the report says so.
    let lost = place.run("verify roof.bvhc --rays 1k --device opencl:0 --device-timeout 1ms --junit lost.xml");
    assert!(lost.code == 5 && lost.err.contains("has not come back"), "{}{}", lost.code, lost.err);
    assert!(String::from_utf8(place.read("lost.xml")).unwrap().contains("type=\"unsupported\""));
    let none = place.run("verify roof.bvhc --rays 1k --device opencl:99");
    assert_eq!(none.code, 5, "{}", none.err);
    assert!(none.err.contains("opencl:0: "), "{}", none.err);
}

#[test]
fn what_makes_no_sense_is_a_usage_error() {
    let place = Place::new();
    for args in [
        "verify",
        "verify a --device gpu",
        "verify a --rays many",
        "verify a --rays 0",
        "verify a --rays-from nowhere",
        "verify a --allow-outside",
    ] {
        assert_eq!(place.run(args).code, 2, "bvhc {args}");
    }
    assert!(place.run("verify a --rays-from nowhere").err.contains("surface"), "the choices are listed");
}
