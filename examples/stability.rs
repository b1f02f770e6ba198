//! Scenes that builders are known to fail on, as models: `cargo run --example stability -- SCENE TRIANGLES FILE.obj`, or without arguments what there are.
//!
//! `bvhc chart --stability` builds them by every recipe and prints how each does.

use bvhc::stability::{FAILURES, Failure};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match &args[..] {
        [] => FAILURES.iter().for_each(|failure| println!("{:9} {:20} {}", failure.id, failure.name, failure.breaks)),
        [name, triangles, file] => {
            let failure = Failure::named(name).ok_or(format!("no scene is called {name}"))?;
            std::fs::write(file, failure.obj(triangles.parse()?))?;
            println!("wrote {} to {file}", failure.name);
        }
        _ => return Err("it takes a scene, a number of triangles and a file, or nothing".into()),
    }
    Ok(())
}
