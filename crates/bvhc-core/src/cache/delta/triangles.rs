//! `TRIX` in 24 planes: of each of the six words of a record its four bytes, lowest first, less what was expected.
//!
//! A corner is expected to be the next vertex that no triangle had before, which is right for half of them where vertices are numbered by their first use;
//! `prim` and `geom` to be those of the record before.

use std::io;

use super::planes::Planes;
use super::residuals::{fold, unfold};
use crate::exec::Executor;
use crate::layout::IndexedTriangleRecord;

const WORDS: usize = size_of::<IndexedTriangleRecord>() / 4;

/// What the next record is expected to be.
#[derive(Default)]
struct Expected {
    vertex: u32,
    prim: u32,
    geom: u32,
}

impl Expected {
    fn of(&self, word: usize) -> u32 {
        match word {
            0..3 => self.vertex,
            3 => self.prim,
            4 => self.geom,
            _ => 0,
        }
    }

    fn take(&mut self, word: usize, value: u32) {
        match word {
            0..3 if value == self.vertex => self.vertex = self.vertex.wrapping_add(1),
            3 => self.prim = value,
            4 => self.geom = value,
            _ => {}
        }
    }
}

/// The stored bytes of whole records, whether or not they are fewer.
///
/// # Errors
/// Where zstd cannot be had.
pub fn pack(records: &[u8], level: i32, exec: &Executor) -> io::Result<Vec<u8>> {
    let mut planes = Planes::default();
    planes.push(&encode(records), 0, 4 * WORDS);
    planes.pack(level, exec)
}

/// The planes of whole records; bytes behind the last one stay away.
fn encode(records: &[u8]) -> Vec<u8> {
    let count = records.len() / (4 * WORDS);
    let mut out = vec![0; 4 * WORDS * count];
    let mut expected = Expected::default();
    for (i, record) in records.chunks_exact(4 * WORDS).enumerate() {
        for (word, bytes) in record.as_chunks::<4>().0.iter().enumerate() {
            let value = u32::from_le_bytes(*bytes);
            let folded = fold(value.wrapping_sub(expected.of(word)) as i32).to_le_bytes();
            expected.take(word, value);
            for (byte, folded) in folded.into_iter().enumerate() {
                out[(4 * word + byte) * count + i] = folded;
            }
        }
    }
    out
}

/// The records of the planes, which are as long.
pub fn decode(planes: &[u8], out: &mut [u8]) {
    let count = planes.len() / (4 * WORDS);
    let mut expected = Expected::default();
    for (i, record) in out.chunks_exact_mut(4 * WORDS).enumerate().take(count) {
        for (word, bytes) in record.as_chunks_mut::<4>().0.iter_mut().enumerate() {
            let byte = |k: usize| planes[(4 * word + k) * count + i]; // 24 planes of `count` bytes
            let folded = u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]);
            let value = expected.of(word).wrapping_add(unfold(folded) as u32);
            expected.take(word, value);
            *bytes = value.to_le_bytes();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_come_back_and_first_uses_are_zeros() {
        let strip = |i: u32| IndexedTriangleRecord { corners: [i, i + 1, i + 2], prim: 7 * i, geom: i / 90, flags: 0 };
        let mut records: Vec<_> = (0..200).map(strip).collect();
        records[50].corners = [u32::MAX, 0, 1 << 31];
        let bytes: &[u8] = bytemuck::cast_slice(&records);
        let planes = encode(bytes);
        let mut out = vec![0; bytes.len()];
        decode(&planes, &mut out);
        assert_eq!(out, bytes);
        let third_corner = &planes[8 * 200..9 * 200];
        assert!(third_corner.iter().filter(|byte| **byte == 0).count() > 190, "{third_corner:?}");
        assert!(encode(&[]).is_empty());
    }
}
