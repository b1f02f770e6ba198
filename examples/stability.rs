//! How every recipe does on the scenes that builders are known to fail on: `cargo run --release --example stability -- [--sizes 1000,8000] [--rays N] [--all]
//! [SCENE…]`, or `--write FILE.obj SCENE` for one of them as a model.
//!
//! Counts alone, so the table is the same on every machine. `cost` is 1.2 · inner nodes + triangles a ray, the mean of three sets of rays; `growth`
//! is what the larger of two sizes has or costs over the smaller, of the cheapest recipe. A recipe is *poor* where its cost is more than 1.5 times
//! that of the cheapest. `--all` prints a row for each recipe.

#[path = "../samples/generator/failures/mod.rs"]
mod failures;
#[path = "../samples/generator/failures/judge.rs"]
mod judge;

use bvhc::build::Executor;
use failures::{FAILURES, Failure};
use judge::{Judge, Row, recipes};
use std::error::Error;

/// More than this times the cheapest cost is poor.
const POOR: f64 = 1.5;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut sizes, mut rays, mut all, mut write, mut wanted) = (vec![500, 4000], 1300, false, None, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut value = || args.next().ok_or(format!("{arg}: a value goes with it"));
        match arg.as_str() {
            "--sizes" => sizes = value()?.split(',').map(str::parse).collect::<Result<_, _>>()?,
            "--rays" => rays = value()?.parse()?,
            "--write" => write = Some(value()?),
            "--all" => all = true,
            _ => wanted.push(arg),
        }
    }
    let named = |f: &&Failure| wanted.is_empty() || wanted.iter().any(|name| [f.id, f.name].contains(&name.as_str()));
    let chosen: Vec<&Failure> = FAILURES.iter().filter(named).collect();
    if chosen.is_empty() {
        let names: Vec<&str> = FAILURES.iter().map(|f| f.name).collect();
        return Err(format!("there is no such scene; there are {}", names.join(", ")).into());
    }
    if let Some(path) = write {
        std::fs::write(&path, chosen[0].obj(sizes[0]))?;
        println!("wrote {} to {path}", chosen[0].name);
        return Ok(());
    }

    let exec = Executor::new(0)?;
    println!(
        "| scene | triangles | wrong hits | depth | largest leaf | references a triangle | cheapest | cost | nodes' growth | cost's growth | `auto` over | verdict |"
    );
    println!("|---|--:|--:|--:|--:|--:|---|--:|--:|--:|--:|---|");
    let (mut poor, mut every, mut broken) = (Vec::new(), Vec::new(), 0);
    for failure in chosen {
        let tables: Vec<Vec<Row>> = sizes.iter().map(|size| judged(failure, *size, rays, &exec)).collect();
        let (Some(small), Some(large)) = (tables.first(), tables.last()) else { continue };
        println!("{}", line(failure, small, large));
        broken += large.iter().chain(small).filter(|row| row.broken().is_some()).count();
        let least = cheapest(large).cost;
        for row in large {
            let over = ratio(row.cost, least);
            every.push(format!(
                "| {} | {} | {} | {} | {} | {:.3} | {:.2} | {over:.2} |",
                failure.name, row.recipe, row.wrong, row.depth, row.largest_leaf, row.references, row.cost
            ));
            if over > POOR {
                poor.push(format!("| {} | {} | {over:.2} | {} |", failure.name, row.recipe, failure.breaks));
            }
        }
    }
    println!("\n| poor | recipe | cost over the cheapest | what the scene is known to break |\n|---|---|--:|---|");
    poor.iter().for_each(|line| println!("{line}"));
    if all {
        println!(
            "\n| scene | recipe | wrong | depth | largest leaf | references | cost | over |\n|---|---|--:|--:|--:|--:|--:|--:|"
        );
        every.iter().for_each(|line| println!("{line}"));
    }
    println!("\n{} scenes, {} recipes, {broken} broken promises", every.len() / recipes().len(), recipes().len());
    if broken == 0 { Ok(()) } else { Err("a promise is broken".into()) }
}

fn judged(failure: &Failure, size: usize, rays: usize, exec: &Executor) -> Vec<Row> {
    let scene = failure.scene(size);
    let mut judge = Judge::new(&scene, rays, exec);
    recipes().iter().map(|(name, options)| judge.row(name, options, exec)).collect()
}

fn cheapest(rows: &[Row]) -> &Row {
    rows.iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).expect("there are recipes")
}

fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 1.0 }
}

fn line(failure: &Failure, small: &[Row], large: &[Row]) -> String {
    let most = |of: fn(&Row) -> f64| large.iter().map(of).fold(0.0, f64::max);
    let best = cheapest(large);
    let before = small.iter().find(|row| row.recipe == best.recipe).expect("the same recipes");
    let auto = large.iter().find(|row| row.recipe == "auto").expect("it is among them");
    let broken: Vec<String> =
        large.iter().chain(small).filter_map(|r| Some(format!("{}: {}", r.recipe, r.broken()?))).collect();
    format!(
        "| {} {} | {} | {} | {} | {} | {:.2} | {} | {:.2} | {:.2} | {:.2} | {:+.1} % | {} |",
        failure.id,
        failure.name,
        best.triangles,
        large.iter().map(|row| row.wrong).sum::<u64>(),
        most(|row| f64::from(row.depth)),
        most(|row| f64::from(row.largest_leaf)),
        most(|row| row.references),
        best.recipe,
        best.cost,
        ratio(best.nodes as f64, before.nodes as f64),
        ratio(best.cost, before.cost),
        100.0 * (ratio(auto.cost, best.cost) - 1.0),
        if broken.is_empty() { "kept".to_string() } else { broken.join("; ") },
    )
}
