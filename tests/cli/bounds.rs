//! What `stats` and `check` work at bad scenes and forged files: no more than at a regular scene of that size.

use crate::Place;
use crate::common::cases_dir;
use crate::program;
use std::process::Command;

/// Commands, and the triangles of the scenes that they get: so many that the work on them hides what starting the program takes, and the clock's
/// steps of some milliseconds.
const COMMANDS: [(&str, u32); 2] = [("stats", 50_000), ("check", 400_000)];

/// Numbers without a pattern between 0 and 1.
fn at(i: u32, k: u32) -> f64 {
    let mut z = (u64::from(i) << 32 | u64::from(k)).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    ((z ^ (z >> 31)) >> 40) as f64 / (1u64 << 24) as f64
}

/// Hills of about so many triangles, on a grid.
fn hills(count: u32) -> String {
    let cells = (f64::from(count) / 2.0).sqrt() as u32;
    let mut text = String::new();
    for (i, j) in (0..=cells).flat_map(|i| (0..=cells).map(move |j| (f64::from(i), f64::from(j)))) {
        text += &format!("v {i} {:.6} {j}\n", 8.0 * (0.06 * i).sin() * (0.05 * j).cos());
    }
    for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
        let a = 1 + i * (cells + 1) + j;
        text += &format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + cells + 2, a + cells + 2, a + cells + 1);
    }
    text
}

/// An OBJ of so many triangles that share no vertex.
fn soup(count: u32, corners: impl Fn(u32) -> [[f64; 3]; 3]) -> String {
    let mut text = String::new();
    for i in 0..count {
        corners(i).iter().for_each(|[x, y, z]| text += &format!("v {x:.6} {y:.6} {z:.6}\n"));
        text += "f -3 -2 -1\n";
    }
    text
}

/// Milliseconds that a processor works for a command, which is less than passes while other programs run beside it: the least of several
/// runs, as bash measures it.
fn work(place: &Place, command: &str, code: i32) -> u32 {
    let run = || {
        let script = r#"TIMEFORMAT=%3U; time "$0" "$@" >/dev/null 2>&1"#;
        let mut bash = Command::new("bash");
        bash.args(["-c", script]).arg(program()).args(command.split(' ')).args(["-j", "1"]);
        let out = bash.current_dir(place.root()).env("LC_ALL", "C").output().unwrap();
        assert_eq!(out.status.code(), Some(code), "{command}");
        let seconds: f64 = String::from_utf8(out.stderr).unwrap().trim().parse().unwrap();
        (seconds * 1000.0).round() as u32
    };
    (0..3).map(|_| run()).min().unwrap()
}

/// Scenes in which each ray meets much of everything: identical, thin, spanning triangles, and hills.
fn bad_scenes(place: &Place, count: u32) {
    place.write("regular.obj", hills(count));
    place.write("identical.obj", soup(count, |_| [[0.0; 3], [1.0, 0.25, 0.0], [0.0, 1.0, 0.5]]));
    place.write(
        "slivers.obj",
        soup(count, |i| {
            let [a, b] = [0, 3].map(|k| [at(i, k), at(i, k + 1), at(i, k + 2)]);
            [a, b, [a[0] + 1e-3, a[1], a[2] + 1e-4]]
        }),
    );
    place.write(
        "spanning.obj",
        soup(count, |i| [[0.0, at(i, 0), at(i, 1)], [1.0, at(i, 2), at(i, 3)], [at(i, 4), at(i, 5), f64::from(i % 2)]]),
    );
    for name in ["regular", "identical", "slivers", "spanning"] {
        place.ok(&format!("build {name}.obj -o {name}.bvhc --method binned --no-check"));
    }
}

/// `verify` takes fewer rays where each is long, and says so.
#[test]
fn verify_left_to_choose_takes_rays_by_what_each_costs() {
    let place = Place::new();
    bad_scenes(&place, 6_000);
    for (name, is_lowered) in [("regular", false), ("identical", true)] {
        let said = place.ok(&format!("verify {name}.bvhc --device cpu --rays-from uniform"));
        assert_eq!(said.out.contains("fewer rays than elsewhere"), is_lowered, "{}", said.out);
        let rays = place.ok(&format!("verify {name}.bvhc --device cpu --rays 40 --rays-from uniform"));
        assert!(!rays.out.contains("fewer rays") && rays.out.contains("judges all 40 rays"), "{}", rays.out);
    }
}

/// Both figures are of one run.
#[test]
#[ignore = "long: builds four scenes for each of two commands and measures each command several times"]
fn long_bad_scenes_and_forged_files_take_at_most_twice_the_work_of_a_regular_one() {
    let place = Place::new();
    let mut slow = Vec::new();
    for (command, count) in COMMANDS {
        bad_scenes(&place, count);
        let regular = work(&place, &format!("{command} regular.bvhc"), 0);
        println!("{command} of a regular scene of {count} triangles: {regular} ms");
        let mut hold = |name: &str, took: u32| {
            println!("{command} of {name}: {took} ms, {:.2} times", f64::from(took) / f64::from(regular));
            if took > 2 * regular {
                slow.push(format!("{command} of {name} takes {took} ms, of a regular scene {regular} ms"));
            }
        };
        for name in ["identical", "slivers", "spanning"] {
            hold(name, work(&place, &format!("{command} {name}.bvhc"), 0));
        }
        for file in cases_dir().into_iter().flat_map(|dir| std::fs::read_dir(dir.join("forged")).unwrap()) {
            let file = file.unwrap().path();
            place.write("forged.bvhc", std::fs::read(&file).unwrap());
            let name = file.file_name().unwrap().to_str().unwrap();
            hold(name, work(&place, &format!("{command} forged.bvhc"), 1));
        }
    }
    assert!(slow.is_empty(), "{}", slow.join("\n"));
}

/// By default, triangles that are long or lie across each other are split, and each copy takes a proof that the leaves cover its triangle. What is fair beside
/// them is a scene of that size whose triangles are split as well: the columns of a sample.
#[test]
#[ignore = "long: builds three scenes by the search and measures two commands several times"]
fn long_bad_scenes_built_by_default_take_at_most_twice_the_work_of_a_scene_that_is_split_as_well() {
    const COPIES: usize = 8; // one file takes a few of the clock's steps
    let place = Place::new();
    bad_scenes(&place, 50_000);
    place.write("columns.obj", std::fs::read(crate::repository().join("samples/colonnade.obj")).unwrap());
    let mut slow = Vec::new();
    let names = ["columns", "identical", "slivers", "spanning"];
    let files = names.map(|name| {
        place.ok(&format!("build {name}.obj -o {name}.bvhc --force --no-check"));
        let info = place.ok(&format!("info {name}.bvhc --json"));
        let is_split = info.out.contains("DUP_REFS");
        assert_eq!(is_split, name != "identical", "{name}: {}", info.out);
        let bytes = place.read(&format!("{name}.bvhc"));
        let copies: Vec<String> = (0..COPIES).map(|i| format!("{name}{i}.bvhc")).collect();
        copies.iter().for_each(|file| _ = place.write(file, &bytes));
        copies.join(" ")
    });
    for command in ["stats", "check"] {
        let took = files.each_ref().map(|files| work(&place, &format!("{command} {files}"), 0));
        for (name, took_it) in names.iter().zip(took).skip(1) {
            println!(
                "{command} of {name}: {took_it} ms, {:.2} times the columns",
                f64::from(took_it) / f64::from(took[0])
            );
            if took_it > 2 * took[0] {
                slow.push(format!("{command} of {name} takes {took_it} ms, of the columns {} ms", took[0]));
            }
        }
    }
    assert!(slow.is_empty(), "{}", slow.join("\n"));
}
