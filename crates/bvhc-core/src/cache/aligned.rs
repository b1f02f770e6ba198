use std::collections::TryReserveError;

use bytemuck::Zeroable;

#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct Line([u8; 64]);

crate::pod::plain! {
    Line = [[u8; 64]];
}

/// Owned bytes that start at a 64-byte boundary, as the sections of a mapped file do.
#[derive(Clone, Default)]
pub struct AlignedBytes {
    lines: Vec<Line>,
    len: usize,
}

impl AlignedBytes {
    /// `len` zero bytes; an error where the machine has not got them.
    pub fn zeroed(len: usize) -> Result<AlignedBytes, TryReserveError> {
        let count = len.div_ceil(64);
        let mut lines = Vec::new();
        lines.try_reserve_exact(count)?;
        lines.resize(count, Line::zeroed());
        Ok(AlignedBytes { lines, len })
    }

    pub fn as_slice(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.lines)[..self.len]
    }

    /// The bytes as records; none where they are no whole number of these.
    #[cfg(feature = "zstd")]
    pub fn records_mut<T: bytemuck::Pod>(&mut self) -> &mut [T] {
        bytemuck::try_cast_slice_mut(self.as_mut_slice()).unwrap_or_default()
    }

    pub fn as_mut_slice(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[..self.len]
    }
}
