//! Files made to mislead: every hash is right, the records are not.

use std::path::{Path, PathBuf};

use crate::Place;
use crate::common::{cases_dir, vectors};

fn invalid() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("format-spec/vectors/invalid");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Nothing is measured that a rule forbids: the first broken rule is named, and no figure is printed.
#[test]
fn stats_names_the_rule_that_a_file_breaks() {
    let place = Place::new();
    for file in invalid() {
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        // Rules about records; those about provenance do not matter to figures.
        if !["E03", "E04", "E05"].iter().any(|start| name.starts_with(start)) || name.starts_with("E0320") {
            continue;
        }
        place.write("a.bvhc", std::fs::read(&file).unwrap());
        let said = place.run("stats a.bvhc");
        assert_eq!((said.code, said.out.as_str()), (1, ""), "{name}: {}", said.err);
        assert!(said.err.contains(&format!("({})", &name[..5])), "{name}: {}", said.err);
    }
}

/// What tells of a file by its header is refused where the section table says otherwise.
#[test]
fn info_and_verify_name_the_rule_too() {
    let place = Place::new();
    let broken = |rule: &str| {
        let file = invalid().into_iter().find(|f| f.to_string_lossy().contains(rule)).unwrap();
        place.write("a.bvhc", std::fs::read(file).unwrap());
    };
    for rule in ["E0302", "E0304", "E0305"] {
        broken(rule);
        let said = place.run("info a.bvhc");
        assert!(said.code == 1 && said.out.is_empty() && said.err.contains(rule), "{rule}: {}", said.err);
    }
    // A ray would show nothing of these, or would not come back.
    for rule in ["E0404", "E0412", "E0425-triangle-uncovered.square"] {
        broken(rule);
        let said = place.run("verify a.bvhc --device cpu --rays 1000");
        assert!(said.code == 1 && said.err.contains(&rule[..5]), "{rule}: {} {}", said.out, said.err);
    }
    // A box that is too large loses no ray, and the file is wrong all the same.
    broken("E0428");
    let said = place.run("verify a.bvhc --device cpu --rays 1000");
    assert!(said.code == 1 && said.err.contains("E0428") && said.err.contains("no ray"), "{} {}", said.out, said.err);
}

/// Whatever breaks a rule is neither passed on nor found right, with every hash in order: not even where no ray meets what is broken.
#[test]
fn convert_and_verify_bless_nothing_that_check_calls_invalid() {
    let place = Place::new();
    let mut count = 0;
    for file in invalid() {
        let name = file.file_name().unwrap().to_str().unwrap().to_owned();
        // Warnings make no file invalid, and what the model says is not asked without it; nor is memory limited here.
        if name.starts_with('W') || name.starts_with("E06") || name.starts_with("E0127") || !name.ends_with(".bvhc") {
            continue;
        }
        place.write("a.bvhc", std::fs::read(&file).unwrap());
        let said = place.run("convert a.bvhc -o b.bvhc");
        assert!(said.code != 0 && !place.path("b.bvhc").exists(), "{name}: {}", said.out);
        assert!(said.err.contains(&name[..5]), "{name}: {}", said.err);
        let said = place.run("verify a.bvhc --device cpu --rays 100");
        assert!(said.code != 0, "{name}: {}", said.out);
        let told = format!("{}{}", said.out, said.err);
        assert!(told.contains(&name[..5]) || told.contains("wrong"), "{name}: {told}");
        count += 1;
    }
    assert!(count > 90, "{count}");
}

/// What is wrong with provenance alone goes with it.
#[test]
fn a_broken_meta_can_be_left_out() {
    let place = Place::new();
    for rule in ["E0206", "E0207", "E0209"] {
        let file = invalid().into_iter().find(|f| f.to_string_lossy().contains(rule)).unwrap();
        place.write("a.bvhc", std::fs::read(file).unwrap());
        assert_eq!(place.run("convert a.bvhc -o b.bvhc").code, 1, "{rule}");
        place.ok("convert a.bvhc -o b.bvhc --drop-meta");
        place.ok("check b.bvhc");
    }
}

/// Sections that no ray needs, changed by somebody who can hash: `build` makes the file again and says which rule told.
#[test]
fn build_calls_no_forged_file_up_to_date() {
    use bvhc::cache::SectionKind;
    let place = Place::new();
    place.write("a.obj", format!("o strip\nusemtl oak\n{}", crate::strip(20)));
    place.ok("build a.obj -o a.bvhc --vertices");
    let whole = place.read("a.bvhc");
    assert!(place.ok("build a.obj -o a.bvhc --vertices").out.contains("up to date"));

    let forged = |kind: SectionKind, change: &dyn Fn(&mut [u8])| {
        let mut bytes = whole.clone();
        change(vectors::bytes::stored(&mut bytes, kind));
        vectors::bytes::refix(bytes)
    };
    let last = |section: &mut [u8]| *section.last_mut().unwrap() = 0xff;
    let other = |section: &mut [u8]| section[0] ^= 1;
    let (header, mut sections) = vectors::bytes::take_apart(&whole);
    let mut side = sections[0].0;
    (side.kind, side.flags, side.elem_size) = (SectionKind::SIDE, SectionKind::SIDE.rule().unwrap().flags, 4);
    (side.elem_count, side.raw_len) = (1, 4);
    sections.insert(sections.len() - 1, (side, vec![2, 0, 0, 0]));
    for (rule, bytes) in [
        ("E0208", forged(SectionKind::NAMS, &last)),
        ("E0320", forged(SectionKind::NAMS, &|names| *names.last_mut().unwrap() ^= 1)),
        ("E0210", forged(SectionKind::MATS, &last)),
        ("E0323", forged(SectionKind::VERT, &other)),
        ("E0324", vectors::bytes::put_together(header, sections)),
        ("E04", forged(SectionKind::TRIS, &|tris| tris[0..4].copy_from_slice(&1e9f32.to_le_bytes()))),
    ] {
        place.write("a.bvhc", &bytes);
        let said = place.ok("build a.obj -o a.bvhc --vertices --dry-run");
        assert!(said.out.contains("would build") && said.out.contains(rule), "{rule}: {}", said.out);
        place.ok("build a.obj -o a.bvhc --vertices");
        assert_eq!(place.read("a.bvhc"), whole, "{rule}");
    }
}

/// A list of tens of thousands is cut, and its length told.
#[test]
fn info_cuts_long_lists() {
    use bvhc::cache::{Cache, Dependency, Meta, OpenOptions, WriteOptions, to_bytes};
    let place = Place::new();
    place.write("a.obj", crate::strip(20));
    place.ok("build a.obj -o a.bvhc --method binned");
    let cache = Cache::from_bytes(&place.read("a.bvhc"), &OpenOptions::default()).unwrap();
    let view = cache.view();
    let image = bvhc::cache::Image {
        nodes: view.nodes.to_vec(),
        triangles: view.triangles.to_vec(),
        geoms: view.geoms.to_vec(),
        blases: view.blases.to_vec(),
        names: (0..view.geoms.len()).map(|i| cache.names().get(i).unwrap_or_default().to_owned()).collect(),
        flags: cache.header().tree_flags,
        ..bvhc::cache::Image::default()
    };
    let input = |i: u32| Dependency { role: i.min(1), name: format!("part{i}.bin"), ..Dependency::default() };
    let meta = Meta { dependencies: (0..9000).map(input).collect(), ..cache.meta().unwrap().clone() };
    let exec = bvhc::exec::Executor::sequential();
    place.write("a.bvhc", to_bytes(&image, &meta, &WriteOptions::default(), &exec).unwrap());
    let said = place.ok("info a.bvhc").out;
    assert!(said.lines().count() < 100, "{} lines", said.lines().count());
    assert!(said.contains("… and 8,960 more; --json shows them"), "{said}");
    assert_eq!(place.ok("info a.bvhc --json").json()["files"][0]["meta"]["inputs"].as_array().unwrap().len(), 9000);
}

/// Files that were found to mislead: shared children to 64 levels, cycles, boxes of no number, half a kilobyte for every gigabyte.
#[test]
fn forged_files_are_refused_at_once_and_in_little_memory() {
    let Some(folder) = cases_dir().map(|cases| cases.join("forged")) else { return };
    let place = Place::new();
    let names = [
        "ladder",
        "lad16",
        "lad20",
        "leafhuge",
        "leafoverlap",
        "cycle",
        "nanbox",
        "infbox",
        "bomb2",
        "hole_small",
        "hole_big",
    ];
    for name in names {
        let file = folder.join(name).with_extension("bvhc");
        for command in ["stats", "check", "verify --device cpu --rays 1000"] {
            // Addresses rather than memory in use: threads would reserve some of their own.
            let limited = format!("ulimit -v 1000000; exec \"$0\" {command} '{}' --jobs 1", file.display());
            let done = std::process::Command::new("sh")
                .args(["-c", &limited])
                .arg(crate::program())
                .current_dir(place.root())
                .output()
                .unwrap();
            let said = format!("{}{}", String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
            assert_eq!(done.status.code(), Some(1), "{command} {name}: {said}");
            let wrong = said.contains("wrong (against its own triangles");
            assert!(said.contains("E0") || wrong, "{command} {name} names no rule: {said}");
        }
    }
}
