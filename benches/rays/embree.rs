//! Embree behind a pipe, tracing rays through its own scenes of one mesh on one thread.

use super::workers::Embree;
use bvhc::Ray;
use bvhc::scene::Mesh;
use bvhc::trace::probe::{ProbeRays, SETS};
use std::io::{Read, Result, Write};
use std::process::{Child, Command, Stdio};

/// The scenes' build qualities, in the order of the numbers that ask for them.
pub const QUALITIES: [&str; 2] = ["medium", "high"];

/// A worker with its scenes built and all rays at hand.
pub struct Tracer {
    child: Child,
}

impl Tracer {
    pub fn open(embree: &Embree, mesh: &Mesh, rays: &ProbeRays) -> Result<Tracer> {
        let mut command = Command::new(&embree.program);
        command.arg(&embree.library).args(["1", "trace"]).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut tracer = Tracer { child: command.spawn()? };
        let input = tracer.child.stdin.as_mut().expect("a pipe was asked for");
        let counts = [mesh.positions.len() as u32, mesh.triangles.len() as u32];
        input.write_all(bytemuck::cast_slice(&counts))?;
        input.write_all(bytemuck::cast_slice(&mesh.triangles))?;
        input.write_all(bytemuck::cast_slice(&mesh.positions))?;
        for set in 0..SETS.len() {
            let rays: Vec<[f32; 8]> = rays.rays(set).iter().map(numbers).collect();
            input.write_all(&(rays.len() as u32).to_ne_bytes())?;
            input.write_all(bytemuck::cast_slice(&rays))?;
        }
        input.flush()?;
        Ok(tracer)
    }

    /// Seconds for each 1,024 rays of a set, so many times, and how many of all hit something.
    pub fn trace(&mut self, set: usize, quality: usize, chunks: usize) -> Result<(Vec<f64>, usize)> {
        let input = self.child.stdin.as_mut().expect("a pipe was asked for");
        input.write_all(&[set as u8, quality as u8])?;
        input.flush()?;
        let output = self.child.stdout.as_mut().expect("a pipe was asked for");
        let (mut seconds, mut hits) = (vec![0.0; chunks], [0; 8]);
        output.read_exact(bytemuck::cast_slice_mut(&mut seconds))?;
        output.read_exact(&mut hits)?;
        Ok((seconds, u64::from_ne_bytes(hits) as usize))
    }
}

fn numbers(ray: &Ray) -> [f32; 8] {
    let ([a, b, c], [d, e, f]) = (ray.origin, ray.direction);
    [a, b, c, ray.t_min, d, e, f, ray.t_max]
}

impl Drop for Tracer {
    /// Closing its input ends the worker.
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        let _ = self.child.wait();
    }
}
