//! Bytes that are not looked into.

use super::{Dice, word};

/// One change: bits, bytes, words, runs.
pub fn change(bytes: &mut Vec<u8>, room: usize, dice: &mut Dice) {
    if bytes.is_empty() {
        bytes.push(dice.roll() as u8);
        return;
    }
    let at = dice.below(bytes.len());
    let end = (at + 1 + dice.below(40)).min(bytes.len());
    match dice.below(9) {
        0 => bytes[at] ^= 1 << dice.below(8),
        1 => bytes[at] = dice.roll() as u8,
        2 => bytes[at] = dice.of(&[0, 1, 0x7f, 0x80, 0xff]),
        3 => drop(bytes.drain(at..end)),
        4 if dice.one_in(4) => bytes.truncate(at),
        4 | 5 => {
            let to = dice.below(bytes.len() + 1);
            let run = bytes[at..end].to_vec();
            bytes.splice(to..to, run);
        }
        6 => {
            let to = dice.below(bytes.len() - (end - at) + 1);
            bytes.copy_within(at..end, to);
        }
        _ => {
            let at = at & !3;
            if let Some(four) = bytes.get_mut(at..at + 4) {
                let old = u32::from_le_bytes([four[0], four[1], four[2], four[3]]);
                four.copy_from_slice(&word(old, dice).to_le_bytes());
            }
        }
    }
    bytes.truncate(room);
}
