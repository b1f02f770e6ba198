//! Statements into words.

/// The first word and the rest of the line.
pub(super) fn split_word(line: &[u8]) -> (&[u8], &[u8]) {
    let end = line.iter().position(|b| is_space(*b)).unwrap_or(line.len());
    line.split_at(end)
}

/// The words up to a comment.
pub(super) struct Words<'w>(pub &'w [u8]);

impl<'w> Iterator for Words<'w> {
    type Item = &'w [u8];

    fn next(&mut self) -> Option<&'w [u8]> {
        let start = self.0.iter().position(|b| !is_space(*b)).unwrap_or(self.0.len());
        self.0 = &self.0[start..];
        if self.0.first().is_none_or(|b| *b == b'#') {
            return None;
        }
        let (word, rest) = split_word(self.0);
        self.0 = rest;
        Some(word)
    }
}

/// The number that a word begins with, if that ends with the word or at a slash.
pub(super) fn parse_digits(word: &[u8]) -> Option<u64> {
    let mut number = 0u64;
    for (i, &byte) in word.iter().enumerate() {
        match byte {
            b'0'..=b'9' if i < 18 => number = number * 10 + u64::from(byte - b'0'),
            b'/' => break,
            _ => return None,
        }
    }
    Some(number)
}

fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0b' | b'\x0c')
}
