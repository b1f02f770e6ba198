//! A peer's worker that traces rays: `serve.rs` says what is spoken.

use bvhc::Ray;
use bvhc::report::tradeoff::Worker;
use bvhc::scene::Mesh;
use std::io::{Read, Result, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The triangle of a ray that hits nothing.
const NOTHING: u32 = u32::MAX;

pub struct Tracer {
    child: Child,
    input: ChildStdin,
    output: ChildStdout,
    rays: usize,
}

/// What one tree came to; not a number is what the peer does not tell.
pub struct Told {
    pub milliseconds: f64,
    pub nodes: f64,
    pub bytes: f64,
    pub seconds: f64,
    pub hits: Vec<Option<(f32, u32)>>,
}

impl Tracer {
    pub fn open(worker: &Worker, mesh: &Mesh, rays: &[Ray]) -> Result<Tracer> {
        let mut command = Command::new(&worker.program);
        command.args(&worker.arguments).arg("league").env("RAYON_NUM_THREADS", "1");
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let (input, output) = (child.stdin.take(), child.stdout.take());
        let (mut input, output) = (input.expect("a pipe was asked for"), output.expect("a pipe was asked for"));
        let corners: Vec<[[f32; 3]; 3]> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
        let numbers = |ray: &Ray| {
            let ([a, b, c], [d, e, f]) = (ray.origin, ray.direction);
            [a, b, c, ray.t_min, d, e, f, ray.t_max]
        };
        let asked: Vec<[f32; 8]> = rays.iter().map(numbers).collect();
        input.write_all(&(corners.len() as u32).to_ne_bytes())?;
        input.write_all(bytemuck::cast_slice(&corners))?;
        input.write_all(&(asked.len() as u32).to_ne_bytes())?;
        input.write_all(bytemuck::cast_slice(&asked))?;
        input.flush()?;
        Ok(Tracer { child, input, output, rays: rays.len() })
    }

    /// `None` where the peer has no such form.
    pub fn trace(&mut self, setting: u8, wide: bool) -> Result<Option<Told>> {
        self.input.write_all(&[setting, u8::from(wide)])?;
        self.input.flush()?;
        let mut milliseconds = [0.0f64; 1];
        self.output.read_exact(bytemuck::cast_slice_mut(&mut milliseconds))?;
        if milliseconds[0].is_nan() {
            return Ok(None);
        }
        let (mut figures, mut hits) = ([0.0f64; 3], vec![[0u32; 2]; self.rays]);
        self.output.read_exact(bytemuck::cast_slice_mut(&mut figures))?;
        self.output.read_exact(bytemuck::cast_slice_mut(&mut hits))?;
        let hit = |[t, triangle]: [u32; 2]| (triangle != NOTHING).then(|| (f32::from_bits(t), triangle));
        let ([milliseconds], [nodes, bytes, seconds]) = (milliseconds, figures);
        Ok(Some(Told { milliseconds, nodes, bytes, seconds, hits: hits.into_iter().map(hit).collect() }))
    }
}

impl Drop for Tracer {
    /// A worker keeps nothing.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
