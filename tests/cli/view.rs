//! `view`: pictures and outlines.

use crate::frames::heli;
use crate::{Place, repository, strip};
use bvhc::Cache;
use bvhc::report::picture::Lens;
use bvhc::trace::probe::Camera;
use bvhc::trace::{Counters, try_closest_hit};

/// The colonnade in two trees, and a strip of 4,000 triangles.
fn furnished() -> Place {
    let place = Place::new();
    place.write("hall.obj", std::fs::read(repository().join("samples/colonnade.obj")).unwrap());
    place.write("roof.obj", strip(200));
    place.ok("build hall.obj -o binned.bvhc --preset draft");
    place.ok("build hall.obj -o longest.bvhc --preset draft --axes longest");
    place.ok("build roof.obj -o roof.bvhc");
    place
}

/// Width, height, and three bytes a pixel.
fn png(place: &Place, name: &str) -> (usize, usize, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(place.read(name))).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width as usize, info.height as usize, pixels)
}

fn numbers(value: &serde_json::Value) -> [f64; 3] {
    [0, 1, 2].map(|k| value[k].as_f64().unwrap())
}

#[test]
fn the_heat_of_a_picture_is_what_its_rays_count() {
    let place = furnished();
    let said = place.ok("view binned.bvhc -o heat.png --shade visits --size 60x40 --json").json();
    let picture = &said["views"][0]["picture"];
    let seen = &picture["camera"];
    let angle = seen["angle"].as_f64().unwrap();
    let camera = Camera {
        eye: numbers(&seen["eye"]),
        look_at: numbers(&seen["target"]),
        up: numbers(&seen["up"]),
        tan_half: (angle / 2.0).to_radians().tan(),
    };
    let (lens, cache) = (Lens::new(&camera, 60, 40), Cache::open(place.path("binned.bvhc")).unwrap());
    let (mut sum, mut hits) = (Counters::default(), 0);
    for i in 0..60 * 40 {
        let ray = lens.ray((i % 60) as f64 + 0.5, (i / 60) as f64 + 0.5);
        hits += u64::from(try_closest_hit(&cache.view(), &ray, &mut sum).unwrap().is_some());
    }
    let file = &picture["files"][0];
    assert_eq!((file["rays"].as_u64(), file["hits"].as_u64()), (Some(2400), Some(hits)));
    for (field, count) in [("visits", sum.inner_nodes), ("tests", sum.triangles)] {
        let mean = file[field]["mean"].as_f64().unwrap();
        assert!((mean - count as f64 / 2400.0).abs() < 1e-3 * mean, "{field}: {mean} and {count}");
    }
    // From inside a hall nearly every ray hits, and the strip with the scale stands below the picture.
    assert!(hits > 2000 && picture["scale"].as_f64().unwrap() >= file["visits"]["mean"].as_f64().unwrap());
    let (width, height, pixels) = png(&place, "heat.png");
    assert!(width == 60 && height > 60, "{width} x {height}");
    assert_eq!(said["views"][0]["output"], "heat.png");

    // The same bytes for any number of threads.
    let told = place.ok("view binned.bvhc -o again.png --shade visits --size 60x40 --jobs 1");
    assert!(told.out.starts_with(&format!("again.png  60 x {height} pixels, ")), "{}", told.out);
    assert_eq!(png(&place, "again.png").2, pixels);
}

#[test]
fn every_shade_makes_another_picture() {
    let place = furnished();
    let mut pictures = std::collections::BTreeSet::new();
    for shade in ["lit", "normal", "part", "depth", "visits", "tests", "cost"] {
        place.ok(&format!("view binned.bvhc -o {shade}.png --shade {shade} --size 48x32 --samples 2"));
        let (width, _, pixels) = png(&place, &format!("{shade}.png"));
        assert!(width == 48 && pictures.insert(pixels[..48 * 32 * 3].to_vec()), "{shade}");
    }
    // Boxes are drawn over it, and another camera sees another side.
    for (flag, name) in [("--boxes 3", "boxes"), ("--camera top", "top"), ("--camera -9,5,1,0,0,0,40", "typed")] {
        place.ok(&format!("view binned.bvhc -o {name}.png --size 48x32 --samples 2 {flag}"));
        assert!(pictures.insert(png(&place, &format!("{name}.png")).2), "{name}");
    }
}

#[test]
fn two_trees_of_a_model_are_compared() {
    let place = furnished();
    let said = place.ok("view --compare longest.bvhc binned.bvhc -o both.png --size 60x40 --json").json();
    let difference = &said["views"][0]["picture"]["difference"];
    assert_eq!(difference["other_hits"], 0, "both trees show the same scene");
    assert!(difference["ratio"].as_f64().unwrap() < 1.0, "three axes cost less than one: {difference}");
    let pixels: u64 = ["fewer", "equal", "more"].iter().map(|field| difference[field].as_u64().unwrap()).sum();
    assert_eq!(pixels, 2400);
    assert_eq!(said["views"][0]["picture"]["shade"], "cost");
    assert_eq!(png(&place, "both.png").0, 3 * 60 + 2 * 6);

    let same = place.ok("view --compare binned.bvhc binned.bvhc --size 20x20 --json").json();
    assert_eq!(same["views"][0]["picture"]["difference"]["equal"], 400);
    assert_eq!(same["views"][0]["picture"]["difference"]["ratio"], 1.0);
    let other = place.ok("view --compare binned.bvhc roof.bvhc -o other.png --size 20x20").out;
    assert!(other.contains("another surface"), "{other}");
}

#[test]
fn an_outline_has_the_nodes_and_their_shares() {
    let place = furnished();
    let nodes = place.ok("view binned.bvhc --tree --depth 3 --json").json()["views"][0]["tree"]["nodes"].clone();
    let nodes = nodes.as_array().unwrap();
    let at = |depth: u64| nodes.iter().filter(move |n| n["depth"] == depth);
    let refs = |depth: u64| at(depth).map(|n| n["references"].as_u64().unwrap()).sum::<u64>();
    assert_eq!((at(1).count(), refs(0), refs(1), refs(2)), (2, refs(0), refs(0), refs(0)));
    let cost = |depth: u64| at(depth).map(|n| n["sah_share"].as_f64().unwrap()).sum::<f64>();
    assert!(cost(0) == 1.0 && cost(1) < 1.0 && cost(2) < cost(1));

    // One of them alone, and a picture of it.
    let child = at(1).next().unwrap();
    let (number, below) = (child["node"].as_u64().unwrap(), child["references"].as_u64().unwrap());
    let alone = place.ok(&format!("view binned.bvhc --tree --depth 0 --root {number} --json")).json();
    assert_eq!(alone["views"][0]["tree"]["nodes"][0]["references"], below);
    let text = place.ok("view binned.bvhc --tree --depth 1").out;
    assert!(text.lines().nth(1).unwrap().starts_with("0 ") && text.contains(&format!("├ {number} ")), "{text}");
    let hits = |root: &str| {
        let said = place.ok(&format!("view binned.bvhc --size 40x40 --camera front --json {root}")).json();
        said["views"][0]["picture"]["files"][0]["hits"].as_u64().unwrap()
    };
    assert!(hits(&format!("--root {number}")) > 0 && hits("") > 0);
}

#[test]
fn a_terminal_is_shown_what_it_can_show() {
    let place = furnished();
    let show = |variables: &[(&str, &str)], color: &str| {
        let mut command = place.command();
        command.env_remove("COLORTERM").envs(variables.iter().copied());
        let out = command.args(["view", "binned.bvhc", "--terminal", "-q", "--shade", "visits", "--size", "40x20"]);
        String::from_utf8(out.args(["--color", color]).output().unwrap().stdout).unwrap()
    };
    let plain = show(&[], "never");
    assert!(plain.is_ascii() && plain.lines().count() == 11 && plain.lines().all(|line| line.len() <= 90), "{plain}");
    assert!(plain.lines().last().unwrap().ends_with("inner nodes visited by the ray"), "{plain}");
    assert!(show(&[("TERM", "xterm-256color")], "always").contains("\x1b[38;5;"));
    assert!(show(&[("COLORTERM", "truecolor")], "always").contains("\x1b[38;2;"));
}

#[test]
fn frames_of_a_sequence_are_shown_one_by_one() {
    let place = heli();
    place.ok("build in/heli.%04d.obj --missing skip -o heli.bvhc --preset draft");
    let hits = |frame: i32| {
        let said = place.ok(&format!("view heli.bvhc --frame {frame} --size 64x40 --camera 2,3,9,2,0,0,60 --json"));
        said.json()["views"][0]["picture"]["files"][0]["hits"].as_u64().unwrap()
    };
    assert!(0 < hits(1) && hits(1) < hits(4), "a strip of four is longer than one of one");
    let said = place.run("view heli.bvhc -o x.png");
    assert!(said.code == 2 && said.err.contains("--frame N"), "{}", said.err);
    assert_eq!(place.run("view heli.bvhc --frame 9 -o x.png").code, 2);
}

#[test]
fn what_cannot_be_shown_is_refused_and_nothing_is_overwritten() {
    let place = furnished();
    let before = place.read("hall.obj");
    for (args, told) in [
        ("view binned.bvhc", "with -o PICTURE.png"),
        ("view binned.bvhc roof.bvhc -o x.png", "--compare A B"),
        ("view --compare binned.bvhc -o x.png", "--compare takes two files"),
        ("view binned.bvhc -o hall.obj", "writes over nothing else"),
        ("view binned.bvhc -o page.html", "--html PAGE.html"),
        ("view binned.bvhc --html page.png", "-o PICTURE.png"),
        ("chart binned.bvhc -o page.svg", "--svg FILE.svg"),
        ("view binned.bvhc --root 1 -o x.png", "second of each tree is unused"),
        ("view binned.bvhc --tree --root 99999999", "bvhc view FILE --tree"),
        ("view binned.bvhc -o x.png --camera nowhere", "seven numbers"),
        ("view binned.bvhc -o x.png --size 99999x2", "no size of a picture"),
        ("view binned.bvhc -o x.png --scale 0", "a number above 0"),
        ("view binned.bvhc --tree --shade lit", "leave out --shade"),
    ] {
        let said = place.run(args);
        assert!(said.code == 2 && said.err.contains(told), "bvhc {args}: {} {}", said.code, said.err);
    }
    assert_eq!(place.run("view missing.bvhc -o x.png").code, 3);
    assert!(place.read("hall.obj") == before && !place.names().contains(&"x.png".to_string()));
}

#[test]
fn a_page_carries_the_trees_of_its_files() {
    let place = furnished();
    let page = |name: &str| String::from_utf8(place.read(name)).unwrap();
    let head = |name: &str| -> serde_json::Value {
        let page = page(name);
        let from = page.split_once("id=\"head\">").unwrap().1;
        serde_json::from_str(from.split_once("</script>").unwrap().0).unwrap()
    };
    let said = place.ok("view binned.bvhc --html one.html --json").json();
    assert!(said["views"][0]["output"] == "one.html" && said["views"][0]["picture"].is_null());
    let scenes = head("one.html")["scenes"].clone();
    assert_eq!((scenes[0]["name"].as_str(), scenes[0]["counts"]["trees"].as_u64()), (Some("binned.bvhc"), Some(1)));
    let text = page("one.html");
    assert!(!text.contains("http:") && !text.contains("https:") && !text.contains("src="), "a page asks no network");
    // The same bytes for any number of threads, and a node alone is less.
    place.ok("view binned.bvhc --html again.html --jobs 1");
    assert_eq!(page("again.html"), text);
    place.ok("view binned.bvhc --html part.html --root 2");
    let triangles = |name: &str| head(name)["scenes"][0]["counts"]["triangles"].as_u64().unwrap();
    assert!(triangles("part.html") < triangles("one.html"));

    place.ok("view --compare longest.bvhc binned.bvhc --html two.html");
    assert_eq!(
        (head("two.html")["together"].as_str(), head("two.html")["scenes"].as_array().unwrap().len()),
        (Some("compare"), 2)
    );

    // Two files of one name are told apart by their folders.
    place.write("old/binned.bvhc", place.read("longest.bvhc"));
    place.write("new/binned.bvhc", place.read("binned.bvhc"));
    place.ok("view --compare old/binned.bvhc new/binned.bvhc --html two.html");
    let scenes = head("two.html")["scenes"].clone();
    assert_eq!([&scenes[0]["name"], &scenes[1]["name"]], ["old/binned.bvhc", "new/binned.bvhc"]);

    // A model is never written over.
    let refused = place.run("view binned.bvhc --html hall.obj");
    assert!(refused.code == 2 && refused.err.contains("cannot replace"), "{}", refused.err);
}

#[test]
fn a_page_of_a_sequence_has_its_frames() {
    let place = heli();
    place.ok("build in/heli.%04d.obj --missing skip -o heli.bvhc --preset draft");
    let frames = |command: &str| {
        place.ok(&format!("view heli.bvhc --html heli.html {command}"));
        String::from_utf8(place.read("heli.html")).unwrap().matches("id=\"data-").count()
    };
    assert_eq!((frames(""), frames("--frame 2")), (3, 1));
}

/// A page of a still file has no frame to choose, as no picture of it has.
#[test]
fn a_frame_of_a_still_file_is_refused_for_pages_too() {
    let place = Place::new();
    place.write("a.obj", crate::strip(4));
    place.ok("build a.obj -o a.bvhc");
    for output in ["--html a.html", "-o a.png"] {
        let said = place.run(&format!("view a.bvhc --frame 2 {output}"));
        assert!(said.code != 0 && said.err.contains("still file"), "{output}: {} {}", said.code, said.err);
    }
}

/// Ask a server for something, and hand back the status and the body.
fn ask(address: &str, head: &str) -> (u16, String) {
    use std::io::{Read, Write};
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    stream.write_all(format!("{head}\r\nConnection: close\r\n\r\n").as_bytes()).unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let status = text.split(' ').nth(1).and_then(|code| code.parse().ok()).unwrap();
    (status, text.split_once("\r\n\r\n").map_or_else(String::new, |(_, body)| body.to_string()))
}

#[test]
fn a_page_is_served_to_this_machine_and_to_nobody_else() {
    use std::io::{BufRead, BufReader};
    let place = furnished();
    place.ok("view binned.bvhc --html page.html");
    let mut command = place.command();
    command.args(["view", "binned.bvhc", "--serve", "--no-browser"]);
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::null());
    let mut server = command.spawn().unwrap();
    let mut url = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut url).unwrap();
    let (address, path) = url.trim().strip_prefix("http://").unwrap().split_once('/').unwrap();
    assert!(address.starts_with("127.0.0.1:") && path.len() == 33, "{url}");
    let port = address.rsplit(':').next().unwrap();

    let (status, body) = ask(address, &format!("GET /{path} HTTP/1.1\r\nHost: {address}"));
    assert!(status == 200 && body.as_bytes() == place.read("page.html"), "{status}");
    assert_eq!(ask(address, &format!("GET /{path} HTTP/1.1\r\nHost: localhost:{port}")).0, 200);
    for (head, code) in [
        (format!("GET / HTTP/1.1\r\nHost: {address}"), 404),
        (format!("GET /{path} HTTP/1.1\r\nHost: elsewhere.example:{port}"), 403),
        (format!("POST /{path} HTTP/1.1\r\nHost: {address}\r\nContent-Length: 0"), 405),
    ] {
        let (status, body) = ask(address, &head);
        assert!(status == code && body.is_empty(), "{head}: {status}");
    }
    server.kill().unwrap();
    server.wait().unwrap();

    for (args, told) in [
        ("view binned.bvhc roof.bvhc --serve", "cannot serve 2 files"),
        ("view binned.bvhc --serve --shade cost", "whoever reads the page"),
        ("view binned.bvhc -o x.png --no-browser", "leave out --no-browser"),
    ] {
        let said = place.run(args);
        assert!(said.code == 2 && said.err.contains(told), "bvhc {args}: {} {}", said.code, said.err);
    }
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let said = place.run(&format!("view binned.bvhc --serve {} --no-browser", taken.local_addr().unwrap().port()));
    assert!(said.code == 3 && said.err.contains("leave out the port"), "{}", said.err);
}
