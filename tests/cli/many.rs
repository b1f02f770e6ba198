//! `bvhc build` of many models: side by side, reported in order, each output old or new whatever happens.

use crate::{Place, strip};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const MODES: [&str; 3] = ["each", "batch", "none"];

/// So many models from `m000.obj` on, more than are written before they take their places together.
fn models(place: &Place, count: usize) -> Vec<String> {
    let names: Vec<String> = (0..count).map(|i| format!("m{i:03}")).collect();
    for (i, name) in names.iter().enumerate() {
        place.write(&format!("{name}.obj"), strip(3 + i % 7));
    }
    names
}

fn outputs(place: &Place, names: &[String]) -> Vec<Option<Vec<u8>>> {
    names.iter().map(|name| std::fs::read(place.path(&format!("out/{name}.bvhc"))).ok()).collect()
}

#[test]
fn many_models_are_reported_in_order_and_one_failure_stops_none() {
    let place = Place::new();
    let names = models(&place, 140);
    // One is too large to be built on one thread, one is broken, and some have something to tell.
    place.write("m070.obj", format!("# {}\n{}", "large ".repeat(400_000), strip(3)));
    place.write("m100.obj", "v 0 0 0\nf 1 2 9\n");
    for i in [5, 69, 71, 130] {
        place.write(&format!("m{i:03}.obj"), format!("{}f 1 1 2\n", strip(3)));
    }
    let alone = {
        let said = place.run("build m*.obj -o out/ --jobs 1");
        (said.code, outputs(&place, &names))
    };
    assert!(alone.0 != 0 && alone.1.iter().filter(|file| file.is_none()).count() == 1);
    for mode in MODES {
        std::fs::remove_dir_all(place.path("out")).unwrap();
        let said = place.run(&format!("build m*.obj -o out/ --jobs 2 --sync {mode}"));
        assert_eq!(said.code, alone.0, "{mode}: {}", said.err);
        assert!(outputs(&place, &names) == alone.1, "{mode}: other bytes");
        let built: Vec<&str> = said.out.lines().map(|line| &line[4..8]).collect();
        let expected: Vec<&String> = names.iter().filter(|name| *name != "m100").collect();
        assert_eq!(built, expected, "{mode}");
        let told: Vec<&str> =
            said.err.lines().filter(|line| !line.starts_with(' ') && !line.starts_with("help")).collect();
        let begins = [
            "warning: m005.obj",
            "warning: m069.obj",
            "warning: m071.obj",
            "error: cannot build out/m100.bvhc",
            "warning: m130.obj",
            "139 built, 1 failed",
        ];
        assert_eq!(told.len(), begins.len(), "{}", said.err);
        assert!(told.iter().zip(begins).all(|(line, begin)| line.starts_with(begin)), "{mode}: {}", said.err);
        // Again, all but one are up to date, and a document has them in order, too.
        let again = place.run(&format!("build m*.obj -o out/ --jobs 2 --sync {mode} --json")).json();
        let results = again["files"].as_array().unwrap();
        let states: Vec<&str> = results.iter().map(|result| result["status"].as_str().unwrap()).collect();
        assert!((0..140).all(|i| states[i] == if i == 100 { "failed" } else { "up-to-date" }), "{states:?}");
        assert!((0..140).all(|i| results[i]["input"] == format!("m{i:03}.obj")));
    }
}

#[test]
fn threads_share_the_memory_that_builds_may_use() {
    let place = Place::new();
    models(&place, 6);
    place.write("m003.obj", strip(200));
    place.write("m004.obj", strip(2000));
    // A half is not enough for 400 triangles, nor is the whole for 4,000.
    for jobs in [1, 2] {
        let said = place.run(&format!("build m*.obj -o out/ --force --jobs {jobs} --max-memory 256K"));
        assert_eq!(said.out.lines().count(), 5, "{}", said.err);
        assert!(said.err.starts_with("error: cannot build out/m004.bvhc\n"), "{}", said.err);
        assert!(said.err.contains("the limit is 256 KiB") && !said.err.contains("m003"), "{}", said.err);
    }
}

/// Two states of several outputs, and a command that takes all from one to the other.
struct States {
    place: Place,
    names: Vec<String>,
    states: [Vec<Option<Vec<u8>>>; 2],
}

impl States {
    const METHODS: [&'static str; 2] = ["binned", "bonsai"];

    fn new(count: usize) -> States {
        let place = Place::new();
        let names: Vec<String> = (0..count).map(|i| format!("m{i:03}")).collect();
        names.iter().for_each(|name| _ = place.write(&format!("{name}.obj"), strip(300)));
        let states = States::METHODS.map(|method| {
            place.ok(&format!("build m*.obj -o out/ -q --force --method {method}"));
            outputs(&place, &names)
        });
        assert!(states[0] != states[1]);
        States { place, names, states }
    }

    fn start(&self, to: usize, mode: &str) -> std::process::Child {
        let method = States::METHODS[to];
        let mut command = self.place.command();
        command.args([
            "build", "m*.obj", "-o", "out/", "-q", "--force", "--jobs", "2", "--method", method, "--sync", mode,
        ]);
        command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    /// How many outputs are in either state. Each must be in one.
    fn count(&self) -> [usize; 2] {
        let now = outputs(&self.place, &self.names);
        let count = |state: usize| (0..now.len()).filter(|&i| now[i] == self.states[state][i]).count();
        let counts = [count(0), count(1)];
        assert_eq!(counts[0] + counts[1], now.len(), "an output is neither the old nor the new file");
        counts
    }

    fn strays(&self) -> usize {
        std::fs::read_dir(self.place.path("out")).unwrap().count() - self.names.len()
    }
}

/// Kill so many runs in each mode, at moments spread over one.
fn kill_runs(times: u32) {
    let states = States::new(12);
    let (mut strays, mut divided, mut to) = (0, 0, 0);
    for mode in MODES {
        let start = Instant::now();
        assert!(states.start(to, mode).wait().unwrap().success());
        let whole = start.elapsed();
        assert_eq!((states.count()[to], states.strays()), (12, 0), "a whole run leaves nothing but outputs");
        for i in 0..times {
            to = 1 - to;
            let mut child = states.start(to, mode);
            std::thread::sleep(whole * (i * 7919 % times) / times);
            child.kill().unwrap();
            child.wait().unwrap();
            divided += usize::from(!states.count().contains(&12));
            strays += states.strays();
        }
        assert!(states.start(to, mode).wait().unwrap().success());
        assert_eq!((states.count()[to], states.strays()), (12, 0), "the next run cleans up");
    }
    println!("{times} kills in each mode: {divided} left some old and some new files, {strays} temporary ones");
}

#[test]
fn killed_runs_leave_each_output_old_or_new() {
    kill_runs(5);
}

#[test]
#[ignore = "long: 600 processes"]
fn long_200_killed_runs_leave_each_output_old_or_new() {
    kill_runs(200);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_each_output_old_or_new_and_nothing_else() {
    let states = States::new(100);
    let mut listened = 0;
    for (i, mode) in MODES.iter().cycle().take(9).enumerate() {
        let before = states.count();
        let mut child = states.start(i % 2, mode);
        std::thread::sleep(Duration::from_millis(60 + 40 * i as u64));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        match child.wait().unwrap().code() {
            Some(130) => listened += 1,
            Some(0) => {}
            // On a busy machine it may not have come to listen, and then it had done nothing either.
            None => assert_eq!(states.count(), before, "{mode}"),
            code => panic!("{mode}: {code:?}"),
        }
        states.count();
        assert_eq!(states.strays(), 0, "{mode}");
    }
    assert!(listened > 0, "no run was interrupted");
}

/// What is in its place has its depfile, whole, or a build system would never look at its inputs again.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_no_output_without_its_depfile() {
    let place = Place::new();
    let names = models(&place, 100);
    let (mut seen, mut listened) = (0, 0);
    for i in 0..6 {
        for folder in ["out", "d"] {
            _ = std::fs::remove_dir_all(place.path(folder));
        }
        let mut command = place.command();
        command.args(["build", "m*.obj", "-o", "out/", "--depfile-dir", "d", "-q", "--jobs", "2", "--sync", "none"]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // Once there is something; then a little later in each run.
        let start = Instant::now();
        while !place.path("out/m000.bvhc").exists() && start.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(5 * i));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        listened += usize::from(child.wait().unwrap().code() == Some(130));
        for name in names.iter().filter(|name| place.path(&format!("out/{name}.bvhc")).exists()) {
            let rule = String::from_utf8(place.read(&format!("d/{name}.bvhc.d"))).unwrap();
            assert!(rule.contains(&format!("{name}.obj")) && rule.ends_with('\n'), "{name}: {rule:?}");
            seen += 1;
        }
    }
    assert!(seen > 0 && listened > 0, "{seen} outputs, {listened} interruptions");
}
