//! Codec 1: independent zstd frames of 1 MiB each behind a small table (`format-spec/SPEC.md`, section 8).
//!
//! Frames do not know each other, so they are packed and unpacked on all cores and the result never depends on how many there
//! are. A frame is decoded only into the bytes that the table promised: a decompression bomb has nowhere to go.

use std::io::{self, Write};

use zstd::zstd_safe;

use super::aligned::AlignedBytes;
use crate::exec::Executor;

/// Decoded bytes a frame holds; the last one may hold fewer.
pub const BLOCK_LEN: usize = 1 << 20;
const WINDOW_LOG: u32 = 20;
/// Bytes of one kind from which on a zstd block of their own may pay: its table of how often each byte occurs takes up to about 100.
const BLOCK_OF_ONE_KIND: usize = 1 << 10;
/// A section stays raw unless packing saves at least one part in this many.
pub const WORTHWHILE: usize = 20;

/// Pack `raw`, or `None` where that gains less than 5 %.
pub fn pack(raw: &[u8], level: i32, exec: &Executor) -> io::Result<Option<Vec<u8>>> {
    let packed = frames_of(raw, level, exec)?;
    let gains = !raw.is_empty() && packed.len() <= raw.len() - raw.len() / WORTHWHILE;
    Ok(gains.then_some(packed))
}

/// The table and the frames, whether or not they are smaller.
pub fn frames_of(raw: &[u8], level: i32, exec: &Executor) -> io::Result<Vec<u8>> {
    frames_in_blocks(raw, &[], level, exec)
}

/// The same of bytes whose kind changes at these places, ascending. There a zstd block ends, and with it a table of how often each byte occurs, where that
/// takes fewer bytes.
pub fn frames_in_blocks(raw: &[u8], ends: &[usize], level: i32, exec: &Executor) -> io::Result<Vec<u8>> {
    let blocks = raw.chunks(BLOCK_LEN).collect();
    let packed = exec.map_with(
        blocks,
        || compressor(level),
        |compressor, i, block: &[u8]| {
            let whole = match compressor {
                Ok(compressor) => compressor.compress(block)?,
                Err(error) => return Err(io::Error::new(error.kind(), error.to_string())),
            };
            let pieces = pieces(block, i * BLOCK_LEN, ends);
            if pieces.len() < 2 {
                return Ok(whole);
            }
            let cut = compress_pieces(&pieces, block.len(), level)?;
            Ok(if cut.len() < whole.len() { cut } else { whole })
        },
    );
    let frames: Vec<Vec<u8>> = packed.into_iter().collect::<Result<_, _>>()?;

    // Lay the table before the frames.
    let mut out = Vec::with_capacity(8 + frames.iter().map(|f| 4 + f.len()).sum::<usize>());
    out.extend((frames.len() as u32).to_le_bytes());
    out.extend([0; 4]);
    frames.iter().for_each(|f| out.extend((f.len() as u32).to_le_bytes()));
    frames.iter().for_each(|f| out.extend(f));
    Ok(out)
}

/// The bytes of a frame that begins at `start`, cut where an end is far enough from the one before.
fn pieces<'a>(mut block: &'a [u8], start: usize, ends: &[usize]) -> Vec<&'a [u8]> {
    let mut pieces = Vec::new();
    let mut at = start;
    for &end in ends {
        let len = end.saturating_sub(at);
        if len < BLOCK_OF_ONE_KIND || len >= block.len() {
            continue;
        }
        let (piece, rest) = block.split_at(len);
        pieces.push(piece);
        (block, at) = (rest, end);
    }
    pieces.push(block);
    pieces
}

/// A frame in which each piece ends a zstd block.
fn compress_pieces(pieces: &[&[u8]], len: usize, level: i32) -> io::Result<Vec<u8>> {
    let mut encoder = zstd::stream::write::Encoder::new(Vec::new(), level)?;
    encoder.window_log(WINDOW_LOG)?;
    encoder.set_pledged_src_size(Some(len as u64))?;
    let mut before = false;
    for piece in pieces {
        if std::mem::replace(&mut before, true) {
            encoder.flush()?;
        }
        encoder.write_all(piece)?;
    }
    encoder.finish()
}

fn compressor(level: i32) -> io::Result<zstd::bulk::Compressor<'static>> {
    let mut compressor = zstd::bulk::Compressor::new(level)?;
    compressor.set_parameter(zstd_safe::CParameter::WindowLog(WINDOW_LOG))?;
    Ok(compressor)
}

/// Unpack a section of `raw_len` bytes. Memory is claimed only once every frame has stated its share of them.
///
/// # Errors
/// What keeps the bytes from being unpacked: the actual value of E0205.
pub fn unpack(stored: &[u8], raw_len: usize, exec: &Executor) -> Result<AlignedBytes, String> {
    let frames = frames(stored, raw_len)?;
    for (i, frame) in frames.iter().enumerate() {
        let block_len = BLOCK_LEN.min(raw_len - i * BLOCK_LEN);
        check_frame(frame, block_len).map_err(|why| format!("zstd frame {i} {why}"))?;
    }
    let mut raw = AlignedBytes::zeroed(raw_len)
        .map_err(|_| format!("{raw_len} decoded bytes are more than this machine can hold"))?;
    let blocks = raw.as_mut_slice().chunks_mut(BLOCK_LEN).zip(frames).collect();
    let decoded = exec.map_with(blocks, zstd::bulk::Decompressor::new, |decompressor, i, (block, frame)| {
        let decompressor = decompressor.as_mut().map_err(|e| format!("zstd does not start: {e}"))?;
        match decompressor.decompress_to_buffer(frame, block) {
            Ok(len) if len == block.len() => Ok(()),
            Ok(len) => Err(format!("zstd frame {i} must decode to {} bytes and gives {len}", block.len())),
            Err(e) => Err(format!("zstd frame {i} cannot be decoded: {e}")),
        }
    });
    decoded.into_iter().collect::<Result<(), String>>()?;
    Ok(raw)
}

/// Cut the stored bytes into frames; everything is bounded by the bytes at hand before it is allocated.
fn frames(stored: &[u8], raw_len: usize) -> Result<Vec<&[u8]>, String> {
    let word = |at: usize| stored.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let count = raw_len.div_ceil(BLOCK_LEN);
    match (word(0), word(4)) {
        (Some(stated), Some(0)) if stated as usize == count => {}
        (Some(stated), Some(0)) => {
            return Err(format!("{raw_len} bytes make {count} zstd frames and the table states {stated}"));
        }
        _ => return Err("the table of zstd frames is cut short or its second word is not zero".into()),
    }
    let table_end = count.checked_mul(4).and_then(|n| n.checked_add(8)).filter(|&end| end <= stored.len());
    let Some(mut at) = table_end else {
        return Err(format!("the table of {count} zstd frames reaches beyond {} stored bytes", stored.len()));
    };
    let mut frames = Vec::with_capacity(count);
    for i in 0..count {
        let len = word(8 + 4 * i).unwrap_or(0) as usize;
        let frame = at.checked_add(len).and_then(|end| stored.get(at..end));
        let Some(frame) = frame else {
            return Err(format!("zstd frame {i} reaches beyond {} stored bytes", stored.len()));
        };
        frames.push(frame);
        at += len;
    }
    if at != stored.len() {
        return Err(format!("the zstd frames must end at byte {} of the section and end at {at}", stored.len()));
    }
    Ok(frames)
}

/// Hold a frame's own header against what the section promises (RFC 8878, section 3.1.1).
fn check_frame(frame: &[u8], block_len: usize) -> Result<(), String> {
    if frame.get(..4) != Some(&[0x28, 0xb5, 0x2f, 0xfd]) {
        return Err("does not begin with the magic number of zstd".into());
    }
    let Some(&descriptor) = frame.get(4) else { return Err("is cut short".into()) };
    if descriptor & 3 != 0 {
        return Err("uses a dictionary".into());
    }
    // A single-segment frame has no window but its content; the others state theirs in a byte of 5 and 3 bits.
    if descriptor & 0x20 == 0 {
        let window = *frame.get(5).ok_or("is cut short")?;
        let base = 1u64 << (10 + u32::from(window >> 3));
        let size = base + base / 8 * u64::from(window & 7);
        if size > BLOCK_LEN as u64 {
            return Err(format!("uses a window of {size} bytes and may use {BLOCK_LEN}"));
        }
    }
    match zstd_safe::get_frame_content_size(frame) {
        Ok(Some(size)) if size == block_len as u64 => {}
        Ok(Some(size)) => return Err(format!("must hold {block_len} bytes and states {size}")),
        _ => return Err("does not state its content size".into()),
    }
    match zstd_safe::find_frame_compressed_size(frame) {
        Ok(len) if len == frame.len() => Ok(()),
        Ok(len) => Err(format!("ends at byte {len} and is followed by {} more", frame.len() - len)),
        Err(_) => Err("is cut short or damaged".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(len: usize) -> Vec<u8> {
        (0..len).map(|i| (i / 7 % 251) as u8).collect()
    }

    fn unpacked(stored: &[u8], len: usize) -> Result<Vec<u8>, String> {
        unpack(stored, len, &Executor::sequential()).map(|raw| raw.as_slice().to_vec())
    }

    #[test]
    fn round_trips_at_block_boundaries_and_any_level() {
        for len in [1000, BLOCK_LEN - 1, BLOCK_LEN, BLOCK_LEN + 1, 3 * BLOCK_LEN + 17] {
            for level in [1, 3, 19] {
                let raw = text(len);
                let packed = pack(&raw, level, &Executor::sequential()).unwrap().expect("it compresses");
                assert_eq!(unpacked(&packed, len).unwrap(), raw, "{len} at level {level}");
            }
        }
    }

    #[test]
    fn bytes_of_several_kinds_take_less_in_blocks_and_come_back() {
        // Two kinds of noise, each of which a table of its own describes better than one of both.
        let mut random = crate::random::Random::new(7);
        let mut noise = |mask: u8, high: u8| (0..5000).map(|_| random.bits() as u8 & mask | high).collect::<Vec<u8>>();
        let raw = [noise(7, 0), noise(7, 0x30), noise(15, 0x80), noise(255, 0)].concat();
        let ends = [5000, 10_000, 15_000, 20_000];
        let whole = frames_of(&raw, 9, &Executor::sequential()).unwrap();
        let cut = frames_in_blocks(&raw, &ends, 9, &Executor::sequential()).unwrap();
        assert!(cut.len() + 500 < whole.len(), "{} and {}", cut.len(), whole.len());
        assert_eq!(unpacked(&cut, raw.len()).unwrap(), raw);
        // Of one kind after all: a table for all of them is enough.
        let same = noise(7, 0);
        assert_eq!(
            frames_in_blocks(&same, &[2500, 5000], 9, &Executor::sequential()).unwrap(),
            frames_of(&same, 9, &Executor::sequential()).unwrap()
        );
        // Too short for tables of their own.
        let short = [100, 1000, 19_900, 20_000];
        assert!(pieces(&raw, 0, &short).len() == 2 && pieces(&raw[..1000], 0, &ends).len() == 1);
        // Frames beyond the first one count from their own start.
        let long = raw.repeat(60);
        let many: Vec<usize> = (1..=240).map(|i| 5000 * i).collect();
        for ends in [&many[..], &[BLOCK_LEN], &[]] {
            let packed = frames_in_blocks(&long, ends, 3, &Executor::sequential()).unwrap();
            assert!(unpacked(&packed, long.len()).unwrap() == long);
        }
    }

    #[test]
    fn noise_stays_raw() {
        let mut state = 1u64;
        let noise: Vec<u8> = std::iter::repeat_with(|| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 56) as u8
        })
        .take(100_000)
        .collect();
        assert!(
            pack(&noise, 3, &Executor::sequential()).unwrap().is_none()
                && pack(&[], 3, &Executor::sequential()).unwrap().is_none()
        );
    }

    #[test]
    fn wrong_promises_are_refused() {
        let raw = text(BLOCK_LEN + 5000);
        let packed = pack(&raw, 3, &Executor::sequential()).unwrap().unwrap();
        let refused = |bytes: &[u8], len| assert!(unpacked(bytes, len).is_err());
        refused(&packed, raw.len() - 1); // the last frame states another size
        refused(&packed, raw.len() + BLOCK_LEN);
        refused(&packed, 0);
        refused(&[&packed[..], &[0]].concat(), raw.len());
        for len in (0..packed.len()).step_by(97) {
            refused(&packed[..len], raw.len());
        }

        // Two frames in the place of one, a skippable frame behind one, and a frame of unknown size.
        let table = |frame: &[u8]| [&1u32.to_le_bytes(), &[0; 4], &(frame.len() as u32).to_le_bytes(), frame].concat();
        let one = zstd::bulk::compress(&raw[..600], 3).unwrap();
        assert_eq!(unpacked(&table(&one), 600).unwrap(), raw[..600]);
        refused(&table(&[&one[..], &one].concat()), 1200);
        refused(&table(&[&one[..], &[0x50, 0x2a, 0x4d, 0x18, 0, 0, 0, 0]].concat()), 600);
        let mut streamed = zstd::stream::Encoder::new(Vec::new(), 3).unwrap();
        streamed.include_contentsize(false).unwrap();
        streamed.write_all(&raw[..600]).unwrap();
        refused(&table(&streamed.finish().unwrap()), 600);
    }

    #[test]
    fn random_damage_never_panics() {
        let raw = text(20_000);
        let packed = pack(&raw, 3, &Executor::sequential()).unwrap().unwrap();
        for i in 0..packed.len() {
            for bit in 0..8 {
                let mut damaged = packed.clone();
                damaged[i] ^= 1 << bit;
                _ = unpacked(&damaged, raw.len());
            }
        }
    }
}
