//! A sequence of which some frames changed is built from the file that is there, and becomes what a build of all frames makes.

use crate::Place;

/// A sheet of `side` by `side` corners in quads that are bent, at a time.
fn sheet(side: u32, time: u32) -> String {
    let mut obj = String::new();
    for i in 0..side * side {
        let (x, z) = (f64::from(i % side), f64::from(i / side));
        let y = (x * 0.5 + f64::from(time) * 0.1).sin() + 0.3 * (x * z + f64::from(time)).cos();
        obj += &format!("v {x} {y:.6} {z}\n");
    }
    for c in (0..side * (side - 1)).filter(|c| c % side != side - 1) {
        obj += &format!("f {} {} {} {}\n", c + 1, c + 2, c + side + 2, c + side + 1);
    }
    obj
}

fn write(place: &Place, frame: u32, obj: String) {
    place.write(&format!("in/s.{frame:03}.obj"), obj);
}

/// Thirty frames in three segments, the third with the triangles of the first.
fn segments(place: &Place) {
    for frame in 1..=30 {
        write(place, frame, sheet(if (11..=20).contains(&frame) { 7 } else { 10 }, frame));
    }
}

/// What building it again says, once it is seen to have made the bytes that a build of all frames makes: frames read, meshes taken, and trees built.
fn again(place: &Place, args: &str) -> [u64; 3] {
    let json = place.ok(&format!("build in/s.%03d.obj -o s.bvhc --json {args}")).json();
    let built = &json["files"][0]["built"]["sequence"];
    place.ok(&format!("build in/s.%03d.obj -o clean.bvhc --force {args}"));
    assert!(place.read("s.bvhc") == place.read("clean.bvhc"), "{args}: other bytes than a build of all frames makes");
    ["read", "taken", "built"].map(|count| built[count].as_u64().unwrap())
}

#[test]
fn one_changed_frame_rebuilds_its_segment_only() {
    let place = Place::new();
    segments(&place);
    for codec in ["raw", "zstd", "compact"] {
        let args = format!("--trees first --rebuild-ratio 3 --codec {codec}");
        let same = |frame: u32| sheet(if (11..=20).contains(&frame) { 7 } else { 10 }, frame);
        place.ok(&format!("build in/s.%03d.obj -o s.bvhc {args}"));
        // The frame, what it becomes, and how many frames are read, meshes taken and trees built: its own and those with which its trees begin.
        for (frame, obj, counts) in [
            (15, sheet(7, 99), [2, 28, 1]),
            (20, sheet(7, 98), [2, 28, 1]),
            (30, sheet(10, 97), [2, 28, 1]),
            (5, sheet(10, 96), [2, 28, 1]),
            // It has a tree of its own from here on.
            (16, sheet(5, 16), [2, 28, 2]),
            // It stands as another frame.
            (25, same(3), [2, 28, 1]),
            // Faces are cut as in the frame that shows them first, so the others are read too.
            (1, sheet(10, 95), [20, 10, 1]),
            (11, sheet(7, 94), [10, 20, 1]),
        ] {
            write(&place, frame, obj);
            assert_eq!(again(&place, &args), counts, "{codec}: frame {frame}");
            write(&place, frame, same(frame));
            again(&place, &args);
        }
        let said = place.ok(&format!("build in/s.%03d.obj -o s.bvhc {args}"));
        assert!(said.out.contains("up to date"), "{}", said.out);
    }
}

#[test]
fn frames_that_come_and_go_leave_the_others() {
    let place = Place::new();
    segments(&place);
    let args = "--trees first --rebuild-ratio 3";
    place.ok(&format!("build in/s.%03d.obj -o s.bvhc {args}"));
    write(&place, 31, sheet(10, 31));
    assert_eq!(again(&place, args), [2, 29, 1], "one is added");
    std::fs::remove_file(place.path("in/s.031.obj")).unwrap();
    assert_eq!(again(&place, args), [1, 29, 1], "one is taken off");
    assert_eq!(again(&place, &format!("{args} --frames 1-25")), [1, 24, 1]);
    std::fs::remove_file(place.path("in/s.018.obj")).unwrap();
    let held = again(&place, &format!("{args} --missing hold"));
    assert_eq!(held, [8, 22, 2], "five are new, one is held, and two are those that the trees begin with");
}

#[test]
fn trees_for_all_frames_are_made_of_what_they_were_made_of() {
    let place = Place::new();
    let bent = |frame: u32| sheet(6, frame * 7);
    (1..=40).for_each(|frame| write(&place, frame, bent(frame)));
    place.ok("build in/s.%03d.obj -o s.bvhc");
    // Of 40 frames these are looked at: 1, 2, 4, 6, …
    write(&place, 3, bent(50));
    let [read, taken, built] = again(&place, "");
    assert!((25..=30).contains(&read) && taken >= 34 && built <= 3, "{read} read, {taken} taken, {built} built");
    // One that they are made of.
    write(&place, 4, bent(60));
    assert_eq!(again(&place, "")[..2], [40, 0]);
    // Another number of frames is another choice.
    write(&place, 41, bent(41));
    assert_eq!(again(&place, "")[..2], [41, 0]);
}

#[test]
fn nothing_is_taken_where_it_cannot_be_known_to_be_the_same() {
    let place = Place::new();
    (1..=6).for_each(|frame| write(&place, frame, sheet(40, frame)));
    let args = "--trees first";
    place.ok(&format!("build in/s.%03d.obj -o s.bvhc {args}"));

    // A damaged file, in the middle and at the end, is no source.
    let whole = std::fs::read(place.path("s.bvhc")).unwrap();
    for at in [whole.len() / 2, whole.len() - 200] {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x10;
        place.write("s.bvhc", damaged);
        assert_eq!(again(&place, args), [6, 0, 1]);
    }
    // Other options are another file, and another form is not.
    assert_eq!(again(&place, "--trees first --rebuild-ratio 9"), [6, 0, 1]);
    assert_eq!(again(&place, "--trees first --rebuild-ratio 9 --codec zstd"), [0, 6, 0]);
    // Nothing says whether a tree of another frame is the same.
    place.ok("build in/s.%03d.obj -o s.bvhc --refit never");
    write(&place, 3, sheet(40, 33));
    assert_eq!(again(&place, "--refit never"), [6, 0, 6]);
}

#[test]
fn what_a_frame_lost_is_told_although_it_is_not_read() {
    let place = Place::new();
    let lossy = |frame: u32| sheet(6, frame) + "f 1 2 2\n";
    (1..=6).for_each(|frame| write(&place, frame, lossy(frame)));
    place.ok("build in/s.%03d.obj -o s.bvhc --trees first");
    write(&place, 4, lossy(44));
    assert_eq!(again(&place, "--trees first"), [2, 4, 1], "the first frame has lost as much as any");
    write(&place, 5, lossy(5) + "f 3 3 4\n");
    assert_eq!(again(&place, "--trees first")[0], 2);
    // Now one frame has lost more than the first, so that the others cannot be known to have lost less.
    write(&place, 4, lossy(4));
    assert_eq!(again(&place, "--trees first")[0], 6);
}

#[test]
fn faces_are_cut_as_in_the_frame_that_shows_them_first() {
    // A quad that folds along its other diagonal in a later frame.
    let quad = |y: f64, apart: u32| {
        format!("v 0 0 0\nv 1 {y} 0\nv 1 0 1\nv 0 {y} 1\nv 9 0 {apart}\nv 9 1 0\nv 8 0 0\nf 1 2 3 4\nf 5 6 7\n")
    };
    let place = Place::new();
    (1..=5).for_each(|frame| write(&place, frame, quad(if frame == 1 { 0.2 } else { -0.2 }, frame)));
    place.ok("build in/s.%03d.obj -o s.bvhc --trees first");
    for (frame, y) in [(1, -0.3), (1, 0.3), (4, 0.5), (2, 0.1)] {
        write(&place, frame, quad(y, 20 + frame));
        again(&place, "--trees first");
    }
}
