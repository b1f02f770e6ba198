//! The accuracy report over many models: `cargo run --release --example accuracy -- [--svg FILE] [--rays N] [MODEL…]`
//!
//! Without models: every sample, and where the folder of models is there (BVHC_MODELS, else `../shared/models`), every real scene. Each is read, built
//! with the default preset, and measured as `bvhc verify --accuracy` does it. Prints Markdown: a line per scene, and the arithmetics over all
//! scenes together.

use bvhc::build::{BuildOptions, Executor, Method, NoProgress, Preset};
use bvhc::cache::Image;
use bvhc::compile::compile;
use bvhc::report::accuracy::chart;
use bvhc::scene::{ReadOptions, Scene, read};
use bvhc::trace::arithmetic::{Arithmetic, BoxArithmetic, TriangleArithmetic};
use bvhc::trace::brute::Oracle;
use bvhc::trace::rays::Sampler;
use bvhc::verify::accuracy::{Measure, Report, Row, measure};
use std::error::Error;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let (mut svg, mut models, mut how) = (None, Vec::new(), Measure::default());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--svg" => svg = Some(args.next().ok_or("--svg takes a file")?),
            "--rays" => how.rays = args.next().and_then(|n| n.parse().ok()).ok_or("--rays takes a number")?,
            _ => models.push(PathBuf::from(arg)),
        }
    }
    if models.is_empty() {
        models = all_models()?;
    }
    let mut reports = Vec::new();
    println!(
        "| scene | triangles | rays judged | Möller–Trumbore | watertight f32 | f64, plain boxes | bvhc | speed |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|");
    for model in &models {
        match read(model, &ReadOptions::default()) {
            Ok(scene) => {
                let report = report_of(scene, &how)?;
                println!("{}", scene_line(model, &report));
                reports.push(report);
            }
            Err(e) => eprintln!("{}: left out: {e}", model.display()),
        }
    }
    let all = Report::of_all(&reports).ok_or("no scene could be read")?;
    println!("\n{}", table(&all));
    if let Some(path) = svg {
        std::fs::write(path, chart(&format!("{} scenes", reports.len()), &all).svg()?)?;
    }
    Ok(())
}

fn report_of(mut scene: Scene, how: &Measure) -> Result<Report, Box<dyn Error>> {
    // A cache leaves instances of empty meshes out, and numbers the others.
    let Scene { meshes, instances, .. } = &mut scene;
    instances.retain(|i| !meshes[i.mesh as usize].triangles.is_empty());
    let options = BuildOptions { method: Method::Sbvh, ..BuildOptions::preset(Preset::Best) };
    let exec = Executor::new(0)?;
    let image = Image::new(&compile(scene.clone(), &options, &exec, &NoProgress)?, &exec)?;
    Ok(measure(&image.view(), &Oracle::new(&scene, &exec), &Sampler::new(&scene), how, &exec, &NoProgress)?)
}

/// Wrong answers among fair and hard rays, of the arithmetics that matter most, and how fast ours is beside the fastest.
fn scene_line(model: &Path, report: &Report) -> String {
    let wrong = |triangles, boxes| {
        let row = report.rows.iter().find(|r| r.arithmetic == Arithmetic { triangles, boxes });
        row.map_or("-".into(), |r| format!("{} / {}", r.fair.wrong(), r.hard.wrong()))
    };
    let fastest = report.rows.iter().map(|r| r.mrays_per_second).fold(0.0, f64::max);
    format!(
        "| {} | {} | {} / {} | {} | {} | {} | {} | {:.0} % |",
        model.file_stem().unwrap_or_default().to_string_lossy(),
        report.instanced_triangles,
        report.fair_rays,
        report.hard_rays,
        wrong(TriangleArithmetic::MollerTrumbore, BoxArithmetic::Plain),
        wrong(TriangleArithmetic::Watertight, BoxArithmetic::TwoUlps),
        wrong(TriangleArithmetic::Double, BoxArithmetic::Plain),
        wrong(TriangleArithmetic::Double, BoxArithmetic::Conservative),
        100.0 * report.ours().mrays_per_second / fastest
    )
}

fn table(report: &Report) -> String {
    let mut text = format!(
        "{} triangles, {} fair and {} hard rays judged\n\n| triangles | boxes | fair: missed · farther · false | hard: missed · farther · false | ulps median · max | Mrays/s | nodes a ray |\n|---|---|--:|--:|--:|--:|--:|\n",
        report.instanced_triangles, report.fair_rays, report.hard_rays
    );
    for row in &report.rows {
        text.push_str(&table_line(row));
    }
    text
}

fn table_line(row: &Row) -> String {
    let errors = [row.fair, row.hard].map(|e| format!("{} · {} · {}", e.missed, e.farther, e.false_hits));
    format!(
        "| {} | {} | {} | {} | {:.2} · {:.3e} | {:.2} | {:.1} |\n",
        row.arithmetic.triangles.name(),
        row.arithmetic.boxes.name(),
        errors[0],
        errors[1],
        row.distance.median(),
        row.distance.max(),
        row.mrays_per_second,
        row.inner_nodes_per_ray
    )
}

/// Samples first; of a folder of frames only the first.
fn all_models() -> std::io::Result<Vec<PathBuf>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let real = std::env::var_os("BVHC_MODELS").map_or_else(|| root.join("../shared/models"), PathBuf::from);
    let mut files = Vec::new();
    collect(&root.join("samples"), &mut files)?;
    if real.is_dir() {
        collect(&real, &mut files)?;
    }
    Ok(files)
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let mut entries =
        std::fs::read_dir(folder)?.map(|e| e.map(|e| e.path())).collect::<std::io::Result<Vec<PathBuf>>>()?;
    entries.sort();
    let model = |p: &Path| p.extension().is_some_and(|e| e == "obj" || e == "gltf" || e == "glb");
    let frames = entries.iter().filter(|p| model(p)).count() > 6 && !entries.iter().any(|p| p.is_dir());
    let name = |p: &Path| p.file_name().unwrap_or_default().to_string_lossy().into_owned();
    for entry in entries {
        if entry.is_dir() && !name(&entry).ends_with("_corner") && name(&entry) != "out" {
            collect(&entry, files)?;
        } else if model(&entry) {
            files.push(entry);
            if frames {
                break;
            }
        }
    }
    Ok(())
}
