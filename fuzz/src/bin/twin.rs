//! The targets on a stable toolchain: the same cases, limits and changes of inputs, without the coverage that guides libFuzzer. What is new
//! is told by what a case came upon.
//!
//! ```text
//! twin run CASES [TARGET…]     a fixed number of cases of each target
//! twin planted CASES [TARGET…] each planted fault must be found within so many cases
//! twin seeds FOLDER TARGET     write the seeds as files
//! ```

use bvhc_fuzz::mutate::{self, Bytes, Dice, bytes};
use bvhc_fuzz::planted::Plan;
use bvhc_fuzz::targets::{MAX_LEN, TARGETS, Target};
use bvhc_fuzz::{guard, seeds};
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = args.iter().map(String::as_str).collect();
    match words[..] {
        ["run", cases, ref names @ ..] => each(names, |target| run(target, number(cases))),
        ["planted", cases, ref names @ ..] => each(names, |target| planted(target, number(cases))),
        ["seeds", folder, name] => each(&[name], |target| write_seeds(target, folder)),
        _ => {
            eprintln!("usage: twin run CASES [TARGET…] | planted CASES [TARGET…] | seeds FOLDER TARGET");
            ExitCode::from(2)
        }
    }
}

fn number(text: &str) -> u64 {
    text.parse().unwrap_or_else(|_| panic!("{text} is no number of cases"))
}

/// Every target by name, or all; the run fails where one does.
fn each(names: &[&str], work: impl Fn(&Target) -> bool) -> ExitCode {
    for name in names {
        assert!(TARGETS.iter().any(|t| t.name == *name), "there is no target {name}");
    }
    let wanted = |t: &&Target| names.is_empty() || names.contains(&t.name);
    let failed = TARGETS.iter().filter(wanted).filter(|t| !work(t)).count();
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn write_seeds(target: &Target, folder: &str) -> bool {
    let seeds = seeds::all(target.name);
    for seed in &seeds {
        let name = &blake3::hash(seed).to_hex()[..16];
        std::fs::write(format!("{folder}/{name}"), seed).expect("a folder to write to");
    }
    println!("{}: {} seeds", target.name, seeds.len());
    true
}

/// Inputs that came upon something new, and what that was.
struct Pool {
    inputs: Vec<Vec<u8>>,
    seen: BTreeSet<String>,
}

impl Pool {
    /// Texts count once, whatever numbers stand in them.
    fn is_new(&mut self, texts: &[String]) -> bool {
        let plain = |text: &String| {
            let is_rule = text.len() < 8;
            text.chars().filter(|c| is_rule || !c.is_ascii_digit()).take(200).collect::<String>()
        };
        texts.iter().filter(|text| self.seen.insert(plain(text))).count() > 0
    }
}

fn next_input(target: &Target, pool: &Pool, dice: &mut Dice) -> Vec<u8> {
    let mut input = pool.inputs[dice.below(pool.inputs.len())].clone();
    let mut noise = Dice::new(dice.roll());
    let mut any = |bytes: &mut Vec<u8>, room: usize| bytes::change(bytes, room, &mut noise);
    let mut raw = Bytes { room: MAX_LEN, any: &mut any };
    for _ in 0..1 + dice.below(3) {
        (target.change)(&mut input, dice, &mut raw);
    }
    input.truncate(MAX_LEN);
    input
}

fn run(target: &Target, cases: u64) -> bool {
    let mut pool = Pool { inputs: seeds::all(target.name), seen: BTreeSet::new() };
    let seeds = pool.inputs.len();
    let began = Instant::now();
    let watched = watch(target.name);
    let mut dice = Dice::new(1);
    for case in 0..cases {
        let input = match pool.inputs.get(case as usize) {
            Some(seed) if (case as usize) < seeds => seed.clone(),
            _ => next_input(target, &pool, &mut dice),
        };
        *watched.lock().expect("the watch") = Some((Instant::now(), input.clone()));
        let done = catch_unwind(AssertUnwindSafe(|| guard::hold(target, &input, &Plan::NONE)));
        if done.is_err() {
            println!("{}: case {case} failed; {}", target.name, keep(target.name, &input));
            return false;
        }
        // Once more for what it came upon, of a few: the guard tells no more than that all is well.
        if case < seeds as u64 || case.is_multiple_of(8) {
            let seen = (target.run)(&input);
            if pool.is_new(&seen) && case >= seeds as u64 && pool.inputs.len() < 4096 {
                pool.inputs.push(input);
            }
        }
    }
    *watched.lock().expect("the watch") = None;
    let rate = cases as f64 / began.elapsed().as_secs_f64();
    println!(
        "{}: {cases} cases from {seeds} seeds, {} different outcomes, {rate:.0} cases/s; no panic, hang or excess of memory",
        target.name,
        pool.seen.len()
    );
    true
}

/// When a case began, and its input.
type Running = (Instant, Vec<u8>);

/// A thread that ends the program where a case does not end.
fn watch(name: &'static str) -> Arc<Mutex<Option<Running>>> {
    let current: Arc<Mutex<Option<Running>>> = Arc::default();
    let seen = Arc::clone(&current);
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_secs(1));
            if let Some((since, input)) = &*seen.lock().expect("the watch")
                && since.elapsed() > Duration::from_secs(30)
            {
                println!("{name}: a case does not end; {}", keep(name, input));
                std::process::exit(1);
            }
        }
    });
    current
}

/// Write a failing input where it can be run again.
fn keep(name: &str, input: &[u8]) -> String {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("artifacts").join(name);
    let file = folder.join(format!("twin-{}", &blake3::hash(input).to_hex()[..16]));
    match std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(&file, input)) {
        Ok(()) => format!("the input is {}", file.display()),
        Err(error) => format!("the input could not be written: {error}"),
    }
}

fn planted(target: &Target, cases: u64) -> bool {
    let mut all = true;
    for fault in target.faults {
        let plan = Plan::of(target, Some(fault));
        let mut pool = Pool { inputs: seeds::sound(target.name), seen: BTreeSet::new() };
        let mut dice = Dice::new(2);
        let quiet = pool.inputs.iter().all(|seed| {
            let seen = (target.run)(seed);
            !seen.iter().any(|text| text.contains(fault))
        });
        assert!(quiet && !pool.inputs.is_empty(), "a seed of {} comes upon {fault} by itself", target.name);
        // From here on, panics are what is looked for.
        std::panic::set_hook(Box::new(|_| ()));
        let found = (0..cases).find(|_| {
            let input = next_input(target, &pool, &mut dice);
            let failed = catch_unwind(AssertUnwindSafe(|| guard::hold(target, &input, &plan))).is_err();
            if !failed && pool.inputs.len() < 4096 {
                let seen = (target.run)(&input);
                if pool.is_new(&seen) {
                    pool.inputs.push(input);
                }
            }
            failed
        });
        let _ = std::panic::take_hook();
        match found {
            Some(case) => println!("{}: the fault at '{fault}' is found by case {case}", target.name),
            None => println!("{}: the fault at '{fault}' is NOT found in {cases} cases", target.name),
        }
        all &= found.is_some();
    }
    all
}

const _: () = assert!(mutate::MAX_LEN == MAX_LEN);
