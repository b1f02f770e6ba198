//! Embree behind a pipe, refitting the poses of one mesh on one thread.

use super::workers::Embree;
use std::io::{Read, Result, Write};
use std::process::{Child, Command, Stdio};

/// A worker at work on one mesh.
pub struct Refitter {
    child: Child,
}

impl Refitter {
    pub fn open(embree: &Embree, triangles: &[[u32; 3]], poses: &[Vec<[f32; 3]>]) -> Result<Refitter> {
        let mut command = Command::new(&embree.program);
        command.arg(&embree.library).args(["1", "refit"]).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut refitter = Refitter { child: command.spawn()? };
        let input = refitter.child.stdin.as_mut().expect("a pipe was asked for");
        let counts = [poses.first().map_or(0, Vec::len), triangles.len(), poses.len()].map(|count| count as u32);
        input.write_all(bytemuck::cast_slice(&counts))?;
        input.write_all(bytemuck::cast_slice(triangles))?;
        poses.iter().try_for_each(|pose| input.write_all(bytemuck::cast_slice(pose)))?;
        input.flush()?;
        Ok(refitter)
    }

    /// Milliseconds, and the box of the scene.
    pub fn refit(&mut self, pose: u8) -> Result<(f64, [[f32; 3]; 2])> {
        let input = self.child.stdin.as_mut().expect("a pipe was asked for");
        input.write_all(&[pose])?;
        input.flush()?;
        let output = self.child.stdout.as_mut().expect("a pipe was asked for");
        let (mut milliseconds, mut bounds) = ([0; 8], [[0f32; 3]; 2]);
        output.read_exact(&mut milliseconds)?;
        output.read_exact(bytemuck::cast_slice_mut(&mut bounds))?;
        Ok((f64::from_ne_bytes(milliseconds), bounds))
    }
}

impl Drop for Refitter {
    /// Closing its input ends the worker.
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        let _ = self.child.wait();
    }
}
