use std::io;

use crate::cache::pack;
use crate::exec::Executor;

/// Packed bytes in planes: runs of bytes of one kind, such as the lowest bytes of many numbers. How often each byte occurs differs from plane to plane.
#[derive(Debug, Default)]
pub struct Planes {
    bytes: Vec<u8>,
    /// Where each plane ends.
    ends: Vec<usize>,
}

impl Planes {
    /// Add `head` bytes of no plane and behind them so many planes of one length.
    pub fn push(&mut self, bytes: &[u8], head: usize, planes: usize) {
        let start = self.bytes.len() + head.min(bytes.len());
        self.bytes.extend_from_slice(bytes);
        let len = (self.bytes.len() - start) / planes.max(1);
        self.ends.extend((1..=planes).map(|plane| start + plane * len));
    }

    /// Their zstd frames, in which planes that are long enough are blocks of their own.
    ///
    /// # Errors
    /// Where zstd cannot be had.
    pub fn pack(&self, level: i32, exec: &Executor) -> io::Result<Vec<u8>> {
        pack::frames_in_blocks(&self.bytes, &self.ends, level, exec)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_end_behind_each_head() {
        let mut planes = Planes::default();
        planes.push(&[9; 8 + 12], 8, 3);
        planes.push(&[], 0, 5);
        planes.push(&[7; 10], 0, 2);
        assert_eq!(planes.ends, [12, 16, 20, 20, 20, 20, 20, 20, 25, 30]);
        assert_eq!(planes.bytes.len(), 30);
    }
}
