//! A file of everyday statements, read piece by piece.
//!
//! ```text
//! file ─ pieces of equal length ─▶ each: hashed, its whole lines read as a range ─▶ one after the other: the lines between two pieces
//! ```
//!
//! The text is never in memory as a whole: a thread holds the piece that it is at. What is hashed is what is read, once, whatever becomes of the file
//! meanwhile. BLAKE3 is a tree over the file, of which each piece is a whole branch, so that the hash is made of theirs.

use super::range::{Range, Reader};
use super::ranges::{Everyday, GROUP, Gathered, has_room};
use crate::scene::options::{BOM, Format};
use crate::scene::resemblance::Resemblance;
use crate::scene::source::Source;
use blake3::hazmat::{ChainingValue, HasherExt, Mode, merge_subtrees_non_root, merge_subtrees_root};
use std::fs::File;
use std::io;
use std::sync::OnceLock;

/// What is read of a file, and its length and hash.
pub(super) struct Read {
    pub text: Everyday,
    pub len: u64,
    pub blake3: [u8; 32],
}

/// Why a file is not read in pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Other {
    /// It is no OBJ by its name, has one piece alone, cannot be read or not be cut, or there is little memory.
    File,
    /// It holds more than everyday statements, which whoever reads it otherwise need not find out again.
    Text,
}

/// Read the model of `source` in pieces of so many bytes, a power of two from 1,024 on. Nothing is done where that is not for this reader.
pub(super) fn read(piece: usize, source: &mut Source) -> Result<Read, Other> {
    let Some((file, len)) = open(piece, source) else { return Err(Other::File) };
    let whole = Whole { file: &file, len, piece, other: OnceLock::new() };
    whole.read_all(source).ok_or_else(|| whole.other.get().copied().unwrap_or(Other::Text))
}

fn open(piece: usize, source: &Source) -> Option<(File, u64)> {
    let is_obj = Format::from_extension(source.path) == Some(Format::Obj);
    let metadata = source.path.metadata().ok().filter(|file| is_obj && file.is_file())?;
    let len = metadata.len();
    if len <= piece as u64 || !has_room(len, source) {
        return None;
    }
    Some((File::open(source.path).ok()?, len))
}

/// The file, cut into pieces.
struct Whole<'a> {
    file: &'a File,
    len: u64,
    piece: usize,
    /// Set by the first piece that is not for this reader: no other one is begun then. There is a reason that holds whichever piece is first.
    other: OnceLock<Other>,
}

impl Whole<'_> {
    fn read_all(&self, source: &mut Source) -> Option<Read> {
        let count = usize::try_from(self.len.div_ceil(self.piece as u64)).ok()?;
        let (mut gathered, mut seams, mut values) = (Gathered::default(), Reader::new(), Vec::with_capacity(count));
        let mut open: Vec<u8> = Vec::new();
        for group in (0..count).collect::<Vec<_>>().chunks(GROUP) {
            let read = source.exec().map_with(group.to_vec(), Desk::new, |desk, _, number| self.read(number, desk));
            for piece in read {
                let Piece { value, head, range, tail } = piece?;
                open.extend_from_slice(&head);
                gathered.add(seams.read(&open)?)?;
                gathered.add(range)?;
                open = tail;
                values.push(value);
            }
        }
        let text = gathered.finish(source)?;
        Some(Read { text, len: self.len, blake3: root(&values) })
    }

    /// Read a piece, unless some other one showed that it is in vain.
    fn read(&self, number: usize, desk: &mut Desk) -> Option<Piece> {
        if self.other.get().is_some() {
            return None;
        }
        let read = self.read_piece(number, desk);
        read.map_err(|other| self.other.get_or_init(|| other)).ok()
    }
}

/// What one thread works with.
struct Desk {
    reader: Reader,
    text: Vec<u8>,
}

impl Desk {
    fn new() -> Desk {
        Desk { reader: Reader::new(), text: Vec::new() }
    }
}

/// What one piece says.
struct Piece {
    /// Its branch of the hash.
    value: ChainingValue,
    /// The end of the line that the piece before began.
    head: Vec<u8>,
    range: Range,
    /// The beginning of the line that the piece behind ends.
    tail: Vec<u8>,
}

impl Whole<'_> {
    fn read_piece(&self, number: usize, desk: &mut Desk) -> Result<Piece, Other> {
        let start = number as u64 * self.piece as u64;
        let rest = self.len - start;
        desk.text.resize(rest.min(self.piece as u64) as usize, 0);
        read_at(self.file, &mut desk.text, start).map_err(|_| Other::File)?;
        let mut text = &desk.text[..];
        // A NUL is an error, or padding that somebody else knows.
        if text.contains(&0) || number == 0 && Resemblance::of_wide_text(text).is_some() {
            return Err(Other::File);
        }
        let value = blake3::Hasher::new().set_input_offset(start).update(text).finalize_non_root();
        let mut head = Vec::new();
        if number == 0 {
            text = text.strip_prefix(BOM).unwrap_or(text);
        } else {
            let end = text.iter().position(|byte| *byte == b'\n').ok_or(Other::File)? + 1;
            head.extend_from_slice(&text[..end]);
            text = &text[end..];
        }
        let mut tail = Vec::new();
        if rest > self.piece as u64 {
            let end = text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
            tail.extend_from_slice(&text[end..]);
            text = &text[..end];
        }
        Ok(Piece { value, head, range: desk.reader.read(text).ok_or(Other::Text)?, tail })
    }
}

/// BLAKE3 of a file of at least two pieces: the left branch of each branch is as large as can be.
fn root(pieces: &[ChainingValue]) -> [u8; 32] {
    let (left, right) = pieces.split_at(pieces.len().next_power_of_two() / 2);
    *merge_subtrees_root(&branch(left), &branch(right), Mode::Hash).as_bytes()
}

fn branch(pieces: &[ChainingValue]) -> ChainingValue {
    if let [only] = pieces {
        return *only;
    }
    let (left, right) = pieces.split_at(pieces.len().next_power_of_two() / 2);
    merge_subtrees_non_root(&branch(left), &branch(right), Mode::Hash)
}

#[cfg(unix)]
fn read_at(file: &File, bytes: &mut [u8], start: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, start)
}

#[cfg(windows)]
fn read_at(file: &File, mut bytes: &mut [u8], mut start: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, bytes, start)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            read => (bytes, start) = (&mut bytes[read..], start + read as u64),
        }
    }
    Ok(())
}

#[cfg(not(any(unix, windows)))]
fn read_at(_: &File, _: &mut [u8], _: u64) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
