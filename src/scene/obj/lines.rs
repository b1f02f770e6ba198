//! A text into lines.

/// The lines of a text, which end in `\n`, `\r\n` or `\r`.
#[derive(Debug)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    taken: u64,
}

impl<'a> Lines<'a> {
    pub fn new(text: &'a [u8]) -> Lines<'a> {
        Lines { rest: text, taken: 0 }
    }

    /// What no line was taken from yet.
    pub fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// Number of the next line, counted from 1.
    pub fn number(&self) -> u64 {
        self.taken + 1
    }

    /// The next line without its end.
    pub fn take(&mut self) -> &'a [u8] {
        let (end, next) = line_end(self.rest);
        let line = &self.rest[..end];
        self.skip(next);
        line
    }

    /// Pass over the next line, whose length with its end is known.
    pub fn skip(&mut self, length: usize) {
        self.rest = &self.rest[length..];
        self.taken += 1;
    }

    /// A statement that goes on where its lines end in a backslash, from its first line on.
    pub fn join(&mut self, first: &[u8]) -> Vec<u8> {
        let mut joined = first.to_vec();
        while joined.last() == Some(&b'\\') {
            joined.pop();
            joined.push(b' ');
            if self.rest.is_empty() {
                break;
            }
            joined.extend_from_slice(self.take().trim_ascii());
        }
        joined
    }
}

/// Where the first line of a text ends, and where the line behind it begins.
pub(super) fn line_end(text: &[u8]) -> (usize, usize) {
    match text.iter().position(|&b| b == b'\n' || b == b'\r') {
        Some(end) if text[end..].starts_with(b"\r\n") => (end, end + 2),
        Some(end) => (end, end + 1),
        None => (text.len(), text.len()),
    }
}

/// Number of the line that a byte of a text is in, counted from 1.
pub(super) fn line_of(text: &[u8], byte: usize) -> u64 {
    let mut lines = Lines::new(text);
    while !lines.rest.is_empty() {
        let number = lines.number();
        lines.take();
        if byte < text.len() - lines.rest.len() {
            return number;
        }
    }
    lines.number()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_three_ways() {
        let mut lines = Lines::new(b"a\nb\r\nc\r\rd");
        let mut taken = Vec::new();
        while !lines.rest().is_empty() {
            taken.push((lines.number(), lines.take()));
        }
        assert_eq!(taken, [(1, &b"a"[..]), (2, b"b"), (3, b"c"), (4, b""), (5, b"d")]);
    }

    #[test]
    fn bytes_are_in_the_lines_that_end_behind_them() {
        let text = b"a\nb\r\nc\rd";
        let numbers: Vec<u64> = (0..text.len()).map(|byte| line_of(text, byte)).collect();
        assert_eq!(numbers, [1, 1, 2, 2, 2, 3, 3, 4]);
        assert_eq!((line_of(b"", 0), line_of(b"a\n", 2)), (1, 2));
    }

    #[test]
    fn lines_are_joined_until_one_ends_otherwise() {
        let mut lines = Lines::new(b" 2 \\\r\n3\nf 4");
        assert_eq!(lines.join(b"f 1 \\"), b"f 1  2  3");
        assert_eq!((lines.rest(), lines.number()), (&b"f 4"[..], 3));
        assert_eq!(Lines::new(b"").join(b"v\\"), b"v ");
    }
}
