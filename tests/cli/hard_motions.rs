//! Motion that trees cannot follow, frames that are broken, and motion that comes back: a right file or a clear error, and no tree for each frame
//! where fewer do.

use crate::animations::model;
use crate::{Place, Said};
use bvhc::random::Random;

/// Triangles, each of three corners of its own.
type Soup = Vec<[[f64; 3]; 3]>;

/// A cloud of small triangles, and the direction in which each flies.
fn cloud(count: usize) -> (Soup, Vec<[f64; 3]>) {
    let mut random = Random::new(11);
    let mut point = || [0; 3].map(|_| random.unit() * 2.0 - 1.0);
    let triangles = (0..count).map(|_| {
        let at = point();
        [0, 1, 2].map(|k| [0, 1, 2].map(|axis| at[axis] * 0.5 + if axis == k { 0.1 } else { 0.0 }))
    });
    let triangles = triangles.collect();
    (triangles, (0..count).map(|_| point()).collect())
}

fn moved(soup: &Soup, by: impl Fn(usize) -> [f64; 3]) -> Soup {
    let place = |(i, corners): (usize, &[[f64; 3]; 3])| {
        let by = by(i);
        corners.map(|c| [0, 1, 2].map(|axis| c[axis] + by[axis]))
    };
    soup.iter().enumerate().map(place).collect()
}

/// A frame. `order` says which corner of the list of all is written as which vertex; faces keep their order.
fn write(place: &Place, name: &str, frame: usize, soup: &Soup, order: impl Fn(usize) -> usize) {
    let corners: Vec<[f64; 3]> = soup.iter().flatten().copied().collect();
    let mut vertices = vec![[0.0; 3]; corners.len()];
    let mut number = vec![0; corners.len()];
    for (corner, position) in corners.iter().enumerate() {
        number[corner] = order(corner);
        vertices[number[corner]] = *position;
    }
    let mut obj: String = vertices.iter().map(|[x, y, z]| format!("v {x:.6} {y:.6} {z:.6}\n")).collect();
    obj.extend(number.chunks(3).map(|n| format!("f {} {} {}\n", n[0] + 1, n[1] + 1, n[2] + 1)));
    place.write(&format!("in/{name}.{frame:03}.obj"), obj);
}

/// Build, check and verify every frame; how many trees were built.
fn built(place: &Place, name: &str, frames: usize) -> u64 {
    let said = place.ok(&format!("build in/{name}.%03d.obj -o {name}.bvhc --trees first"));
    let words: Vec<&str> = said.out.split(" built").next().unwrap_or_default().split_whitespace().collect();
    let [.., trees, "tree" | "trees"] = words[..] else { panic!("{}", said.out) };
    let trees = trees.parse().unwrap();
    place.ok(&format!("check {name}.bvhc"));
    let right = place.ok(&format!("verify {name}.bvhc --device cpu --rays 300"));
    assert!(right.out.contains(&format!("{frames} of {frames} frames right")), "{}", right.out);
    trees
}

#[test]
fn a_mesh_that_explodes() {
    let place = Place::new();
    let (soup, flight) = cloud(200);
    for frame in 0..30 {
        let far = (frame * frame) as f64 * 0.02;
        write(&place, "explode", frame, &moved(&soup, |i| flight[i].map(|c| c * far)), |corner| corner);
    }
    let trees = built(&place, "explode", 30);
    assert!((2..=15).contains(&trees), "{trees} trees");
}

/// The faces are the same, and their vertices have other numbers in each frame. Vertices are told by the faces that use them, so one tree serves.
#[test]
fn vertices_in_another_order_in_each_frame() {
    let place = Place::new();
    let (soup, _) = cloud(60);
    let count = 3 * soup.len();
    for frame in 0..6 {
        let there = moved(&soup, |_| [frame as f64 * 0.1, 0.0, 0.0]);
        write(&place, "shuffle", frame, &there, |corner| (corner * [1, 7, 11, 13, 17, 19][frame] + frame) % count);
    }
    assert_eq!(built(&place, "shuffle", 6), 1);
    let hit = |frame: usize| {
        place.ok(&format!("convert shuffle.bvhc -o one.bvhc --frame {frame} --force"));
        place.ok(&format!("check one.bvhc --source in/shuffle.{frame:03}.obj"));
        let [x, y] = [0, 1].map(|axis| soup[5].iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
        let ray = format!("{},{y},9,0,0,-1", x + frame as f64 * 0.1);
        let said = place.ok(&format!("verify one.bvhc --device cpu --ray={ray} --json")).json();
        said["files"][0]["oracle"][0]["prim"].as_u64().expect("a hit")
    };
    assert_eq!(hit(0), hit(5));
}

#[test]
fn triangles_that_come_and_go() {
    let place = Place::new();
    let (soup, _) = cloud(120);
    for (frame, count) in [100, 100, 120, 120, 100, 0, 100].into_iter().enumerate() {
        write(&place, "count", frame, &soup[..count].to_vec(), |corner| corner);
    }
    assert_eq!(built(&place, "count", 7), 2, "one for each number of triangles");
}

#[test]
fn a_walk_is_built_for_once() {
    let place = Place::new();
    let (soup, flight) = cloud(100);
    let period = 6;
    for frame in 0..4 * period {
        let phase = (frame % period) as f64 / period as f64 * std::f64::consts::TAU;
        write(&place, "walk", frame, &moved(&soup, |i| flight[i].map(|c| c * phase.sin())), |corner| corner);
    }
    let all = built(&place, "walk", 4 * period);
    let said = place.ok(&format!("build in/walk.%03d.obj -o first.bvhc --trees first --frames 0-{}", period - 1));
    assert!(said.out.contains(&format!("{all} tree")), "{}", said.out);
    let size = |name: &str| std::fs::metadata(place.path(name)).unwrap().len();
    assert!(size("walk.bvhc") < size("first.bvhc") * 2, "what comes back is stored once");
}

#[test]
fn a_frame_with_a_corner_that_is_no_number() {
    let place = Place::new();
    let (soup, _) = cloud(20);
    for frame in 0..4 {
        write(&place, "nan", frame, &soup, |corner| corner);
    }
    let sound = String::from_utf8(place.read("in/nan.002.obj")).unwrap();
    let (first, rest) = sound.split_once('\n').unwrap();
    assert!(first.starts_with("v "));
    place.write("in/nan.002.obj", format!("v nan 0 0\n{rest}"));
    assert_eq!(built(&place, "nan", 4), 2, "19 triangles are another mesh than 20");
    let said: Said = place.ok("build in/nan.%03d.obj -o nan.bvhc --force");
    assert!(said.err.contains("nan.bvhc, frame 2: left out 1 triangle with NaN"), "{}", said.err);
    let refused = place.run("build in/nan.%03d.obj -o strict.bvhc --degenerate error");
    assert!(refused.code == 4 && refused.err.contains("nan.002.obj"), "{}", refused.err);
    assert!(!place.path("strict.bvhc").exists());
}

/// One key is a pose that holds: each frame shows the same.
#[test]
fn a_clip_of_one_key() {
    let place = Place::new();
    model(&place, "one", &["Rise", "Fall"]);
    let said = place.ok("build one.gltf -o fall.bvhc --clip Fall --fps 8 --play 0..1");
    assert!(said.out.contains("1 tree built, 0 refitted, 8 as before"), "{}", said.out);
    place.ok("check fall.bvhc");
    place.ok("verify fall.bvhc --device cpu --rays 300");
}
