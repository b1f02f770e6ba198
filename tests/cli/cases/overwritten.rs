//! What is written over, and what is not.

use crate::{Place, Said, strip};

/// A command that is refused with exit code 2, and the file that it would have replaced.
fn spares(place: &Place, command: &str, file: &str) -> Said {
    let before = place.read(file);
    let said = place.run(command);
    assert_eq!(said.code, 2, "{command}: {}{}", said.out, said.err);
    assert!(said.err.contains("cannot replace") && said.err.contains(file), "{command}: {}", said.err);
    assert_eq!(place.read(file), before, "{command}");
    said
}

#[test]
fn no_command_writes_over_a_model() {
    let place = Place::new();
    place.write("a.obj", strip(3));
    place.write("b.obj", strip(4));
    place.write("B.GLB", "glTF");
    place.write("Makefile", "all: a.o\n\tcc a.c\n");
    place.write("pom.xml", "<?xml version=\"1.0\"?>\n<project></project>\n");
    place.write("logo.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"/>\n");
    place.write("index.html", "<!doctype html>\n<title>mine</title>\n");
    place.write("photo.png", "\u{89}PNG");
    place.write("bvhc.1", ".TH OTHER 1\n");
    place.ok("build a.obj -o a.bvhc");
    for (command, file) in [
        ("build a.obj -o b.obj", "b.obj"),
        ("build a.obj -o B.GLB", "B.GLB"),
        // The shell made two models of a pattern.
        ("build -o a.obj b.obj", "a.obj"),
        ("build b.obj -o c.bvhc --depfile a.obj", "a.obj"),
        ("convert a.bvhc -o b.obj", "b.obj"),
        ("verify a.bvhc --device cpu --rays 100 --junit b.obj", "b.obj"),
        ("verify a.bvhc --accuracy --svg b.obj", "b.obj"),
        ("build b.obj -o c.bvhc --depfile Makefile", "Makefile"),
        ("verify a.bvhc --device cpu --rays 100 --junit pom.xml", "pom.xml"),
        ("verify a.bvhc --accuracy --svg logo.svg", "logo.svg"),
        ("view a.bvhc -o photo.png", "photo.png"),
        ("view a.bvhc --html index.html", "index.html"),
        ("man -o .", "bvhc.1"),
    ] {
        spares(&place, command, file);
    }
    let itself = place.run("build a.obj -o a.obj");
    assert!(itself.code == 2 && place.read("a.obj") == strip(3).as_bytes(), "{}", itself.err);
    // What a command made before is written over.
    for _ in 0..2 {
        place.ok("verify a.bvhc --device cpu --rays 100 --junit a.xml");
        place.ok("verify a.bvhc --accuracy --rays 100 --svg a.svg");
        place.ok("view a.bvhc -o a.png --size 16x16");
        place.ok("view a.bvhc --html a.html");
        place.ok("build a.obj -o d.bvhc --depfile d.d");
        place.ok("man -o pages");
    }
    assert!(place.read("a.xml").starts_with(b"<?xml"));
}

#[test]
fn a_file_that_was_damaged_cut_or_emptied_is_built_again() {
    let place = Place::new();
    place.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    place.ok("build a.obj -o a.bvhc");
    let good = place.read("a.bvhc");
    let sections = place.ok("info a.bvhc --json").json()["files"][0]["sections"].clone();
    let offsets = sections.as_array().unwrap().iter().map(|s| s["offset"].as_u64().unwrap() as usize);
    // A byte of each section, of the header, of what lies between sections; a file cut and one emptied.
    let damaged = offsets.chain([60, 200, good.len() - 1]).map(|at| {
        let mut bytes = good.clone();
        bytes[at] ^= 1;
        bytes
    });
    for bytes in damaged.chain([good[..good.len() - 64].to_vec(), Vec::new(), [&good[..], &[0]].concat()]) {
        place.write("a.bvhc", &bytes);
        assert!(!place.ok("build a.obj -o a.bvhc").out.contains("up to date"), "{} bytes", bytes.len());
        assert_eq!(place.read("a.bvhc"), good);
    }
    assert!(place.ok("build a.obj -o a.bvhc").out.contains("up to date"));
}
