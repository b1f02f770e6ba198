//! Where the time of a build goes, and what a second thread saves of it.
//!
//! On a busy machine a second thread saves little by the clock. So each build is also done on one thread that cuts the work up as for
//! several and notes how long it spends in what they would share: the rest is what no second thread makes quicker.

use bvhc::build::{self, BuildOptions, Executor, Progress};
use bvhc::compile;
use bvhc::scene::Mesh;
use bvhc::stability::heap::peak_of;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Milliseconds.
#[derive(Clone, Copy, Default)]
struct Times {
    wall: f64,
    /// Run by processors, summed over the threads.
    cpu: f64,
    /// In what several threads would share.
    divided: f64,
}

/// A stretch of a build, or several of the same name.
struct Phase {
    name: &'static str,
    /// By the clock, in the quickest of several builds.
    least: f64,
    /// Sums over the builds.
    sum: Times,
}

/// What all clocks said at the start of each phase.
struct Stopwatch<'a> {
    exec: &'a Executor,
    start: Instant,
    marks: Mutex<Vec<(&'static str, Times)>>,
}

impl Progress for Stopwatch<'_> {
    fn phase(&self, name: &'static str) {
        let divided = self.exec.divided().as_secs_f64() * 1e3;
        let mark = (name, Times { wall: self.start.elapsed().as_secs_f64() * 1e3, cpu: cpu_ms(), divided });
        self.marks.lock().expect("no panic while it was held").push(mark);
    }
}

/// The phases of one build in the order in which each is entered first.
fn of_build(mesh: &Mesh, options: &BuildOptions, exec: &Executor) -> Vec<(&'static str, Times)> {
    let watch = Stopwatch { exec, start: Instant::now(), marks: Mutex::default() };
    let tree = compile::build_tree(mesh, options, exec, &watch).expect("a tree");
    watch.phase("end");
    drop(tree);
    let marks = watch.marks.into_inner().expect("no panic while it was held");
    let mut phases: Vec<(&'static str, Times)> = Vec::new();
    for pair in marks.windows(2) {
        let ((name, from), (_, to)) = (pair[0], pair[1]);
        let at = phases.iter().position(|phase| phase.0 == name).unwrap_or_else(|| {
            phases.push((name, Times::default()));
            phases.len() - 1
        });
        let times = &mut phases[at].1;
        times.wall += to.wall - from.wall;
        times.cpu += to.cpu - from.cpu;
        times.divided += to.divided - from.divided;
    }
    phases
}

/// A table of the phases of `repeat` builds on one thread and of as many on `jobs`, which take turns.
pub fn print(label: &str, mesh: &Mesh, options: &BuildOptions, jobs: usize, repeat: usize) {
    // Let the threads of the table before end: their times must not vanish while others are taken.
    std::thread::sleep(Duration::from_millis(50));
    let execs = [Executor::sequential(), Executor::new(jobs).expect("threads"), Executor::metered()];
    let mut phases: [Vec<Phase>; 3] = Default::default();
    for _ in 0..repeat {
        for (exec, phases) in execs.iter().zip(&mut phases) {
            for (i, (name, times)) in of_build(mesh, options, exec).into_iter().enumerate() {
                if phases.len() == i {
                    phases.push(Phase { name, least: f64::INFINITY, sum: Times::default() });
                }
                let phase = &mut phases[i];
                phase.least = phase.least.min(times.wall);
                phase.sum = add(phase.sum, times);
            }
        }
    }
    for phases in &mut phases {
        let sum = phases.iter().fold(Times::default(), |sum, phase| add(sum, phase.sum));
        phases.push(Phase { name: "sum", least: phases.iter().map(|phase| phase.least).sum(), sum });
    }

    println!(
        "| {label} | 1 thread ms | {jobs} threads ms | speed-up | cpu ms 1 / {jobs} threads | shared | speed-up alone |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|");
    let [one, many, metered] = &phases;
    for ((one, many), metered) in one.iter().zip(many).zip(metered) {
        let cpu = |phase: &Phase| phase.sum.cpu / repeat as f64;
        let shared = metered.sum.divided / metered.sum.wall;
        // The system counts in steps of a few milliseconds.
        let alone = match cpu(one).min(cpu(many)) {
            0.0..5.0 => String::new(),
            _ => format!("{:.2}", cpu(one) / cpu(many) / (1.0 - shared + shared / jobs as f64)),
        };
        println!(
            "| {} | {:.1} | {:.1} | {:.2} | {:.1} / {:.1} | {:.0} % | {alone} |",
            one.name,
            one.least,
            many.least,
            one.least / many.least,
            cpu(one),
            cpu(many),
            shared * 100.0,
        );
    }
    let (_, peak) = peak_of(|| compile::build_tree(mesh, options, &execs[1], &build::NoProgress).expect("a tree"));
    println!(
        "\nHeld at once on {jobs} threads: {:.0} bytes per triangle.\n",
        peak as f64 / mesh.triangles.len() as f64
    );
}

fn add(a: Times, b: Times) -> Times {
    Times { wall: a.wall + b.wall, cpu: a.cpu + b.cpu, divided: a.divided + b.divided }
}

/// Milliseconds that this process's threads have run; NaN where the system does not tell.
pub fn cpu_ms() -> f64 {
    let Ok(tasks) = std::fs::read_dir("/proc/self/task") else { return f64::NAN };
    let of = |task: std::fs::DirEntry| -> Option<f64> {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse().ok()
    };
    tasks.flatten().filter_map(of).sum::<f64>() / 1e6
}
