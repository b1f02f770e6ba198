//! Compressed sections: the table of frames follows what happens to the frames, so that changes reach the decoder.

use super::{Bytes, Dice, word};

const BLOCK: usize = 1 << 20;

/// A section as the target reads it: kind, decoded length, table and frames.
pub fn pack(kind: u8, raw: &[u8], level: i32) -> Vec<u8> {
    let frames: Vec<Vec<u8>> =
        raw.chunks(BLOCK).map(|block| zstd::bulk::compress(block, level).unwrap_or_default()).collect();
    join(kind, raw.len() as u32, &frames)
}

fn join(kind: u8, raw_len: u32, frames: &[Vec<u8>]) -> Vec<u8> {
    let mut out = vec![kind];
    out.extend(raw_len.to_le_bytes());
    out.extend((frames.len() as u32).to_le_bytes());
    out.extend([0; 4]);
    frames.iter().for_each(|f| out.extend((f.len() as u32).to_le_bytes()));
    frames.iter().for_each(|f| out.extend(f));
    out
}

fn cut(input: &[u8]) -> Option<(u8, u32, Vec<Vec<u8>>)> {
    let number = |at: usize| input.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let (raw_len, count) = (number(1)?, number(5)? as usize);
    let mut at = 13 + 4 * count.min(64);
    let mut frames = Vec::new();
    for i in 0..count.min(64) {
        let len = number(13 + 4 * i)? as usize;
        frames.push(input.get(at..at.checked_add(len)?)?.to_vec());
        at += len;
    }
    Some((input[0], raw_len, frames))
}

pub fn change(input: &mut Vec<u8>, dice: &mut Dice, raw: &mut Bytes) {
    let Some((mut kind, mut raw_len, mut frames)) = cut(input).filter(|_| !dice.one_in(8)) else {
        return raw.change(input);
    };
    match dice.below(10) {
        0 => kind = dice.roll() as u8 % 3,
        1 => raw_len = word(raw_len, dice),
        2 => {
            // Other content, packed anew: zeros, a ramp, noise; by streams, whose frames state less.
            let len = dice.of(&[0, 1, 100, 5000, BLOCK - 1, BLOCK, BLOCK + 1]);
            let step = dice.below(3);
            let content: Vec<u8> =
                (0..len).map(|i| if i < 512 { (dice.roll() as u8).wrapping_mul(step as u8) } else { 7 }).collect();
            let level = dice.of(&[-5, 1, 3, 19]);
            *input = pack(kind, &content, level);
            return;
        }
        3 if !frames.is_empty() => drop(frames.remove(dice.below(frames.len()))),
        4 if !frames.is_empty() && frames.len() < 8 => {
            let frame = frames[dice.below(frames.len())].clone();
            frames.insert(dice.below(frames.len() + 1), frame);
        }
        5 if !frames.is_empty() => {
            // Behind a frame: another, one to be skipped, anything.
            let i = dice.below(frames.len());
            let more = match dice.below(3) {
                0 => frames[dice.below(frames.len())].clone(),
                1 => vec![0x50, 0x2a, 0x4d, 0x18, 0, 0, 0, 0],
                _ => vec![dice.roll() as u8; 1 + dice.below(9)],
            };
            frames[i].extend(more);
        }
        6 | 7 if !frames.is_empty() => {
            // The frame's own header.
            let frame = &mut frames[0];
            let at = 4 + dice.below(10);
            if let Some(byte) = frame.get_mut(at) {
                *byte = if dice.one_in(2) { *byte ^ 1 << dice.below(8) } else { dice.roll() as u8 };
            }
        }
        _ if !frames.is_empty() => {
            let i = dice.below(frames.len());
            raw.change(&mut frames[i]);
        }
        _ => return raw.change(input),
    }
    *input = join(kind, raw_len, &frames);
    input.truncate(raw.room);
}
