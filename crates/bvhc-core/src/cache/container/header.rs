use std::ops::ControlFlow;

use bytemuck::{Zeroable, bytes_of_mut};

use super::{First, Sink, hex};
use crate::cache::report::{Finding, Place};
use crate::cache::rules;
use crate::layout::{
    Header, KNOWN_REQUIRED_FEATURES, MAGIC, MAJOR, MINOR, SEQUENCE_MIN_MINOR, required_features, tree_flags,
};

/// Read the header. The walk breaks where the bytes may mean something else than they seem to.
pub fn read(file: &[u8], out: &mut impl Sink) -> ControlFlow<(), Header> {
    // Say what kind of file it is before anything else is believed.
    if !file.starts_with(&MAGIC) {
        let start = &file[..file.len().min(MAGIC.len())];
        let actual = || if start.is_empty() { "none: the file is empty".to_owned() } else { hex(start) };
        out.breach(&rules::E0102, Place::byte(0), || (hex(&MAGIC), actual()))?;
        out.skip("Everything behind the signature: this is another kind of file.");
        return ControlFlow::Break(());
    }
    let Some(bytes) = file.get(..Header::LEN) else {
        out.breach(&rules::E0101, Place::file(), || (Header::LEN.to_string(), file.len().to_string()))?;
        out.skip("Everything: the header is not complete.");
        return ControlFlow::Break(());
    };
    let mut header = Header::zeroed();
    bytes_of_mut(&mut header).copy_from_slice(bytes);
    if !check_version(&header, out)? {
        out.skip("Everything behind the version: this reader might misread it.");
        return ControlFlow::Break(());
    }

    // Hold the fields against the file and each other.
    if header.file_len != file.len() as u64 || !header.file_len.is_multiple_of(64) {
        let rest = header.file_len % 64;
        let stated = || match rest {
            0 => header.file_len.to_string(),
            rest => format!("{}, which is {rest} more than a multiple of 64", header.file_len),
        };
        out.breach(&rules::E0106, Place::byte(16), || (stated(), file.len().to_string()))?;
    }
    if let Some(i) = header.reserved.iter().position(|b| *b != 0) {
        out.breach(&rules::E0111, Place::byte(224 + i as u64), || ("zero".into(), format!("{} is not", 224 + i)))?;
    }
    tree_flags_hold(header.tree_flags, out)?;
    if header.has(tree_flags::SEQUENCE) != (header.features_required & required_features::SEQUENCE != 0) {
        let expected = "SEQUENCE (0x8) must be set exactly with the required feature 0";
        out.breach(&rules::E0126, Place::byte(56), || (expected.into(), format!("{:#x}", header.tree_flags)))?;
    }
    if header.has(tree_flags::SEQUENCE) && header.min_minor < SEQUENCE_MIN_MINOR {
        let (expected, actual) = (SEQUENCE_MIN_MINOR.to_string(), header.min_minor.to_string());
        out.breach(&rules::E0130, Place::byte(12), || (expected, actual))?;
    }
    ControlFlow::Continue(header)
}

/// Whether this version can read the file.
fn check_version(header: &Header, out: &mut impl Sink) -> ControlFlow<(), bool> {
    let version = |minor: u16| format!("{}.{minor}", header.major);
    if header.major != MAJOR {
        out.breach(&rules::E0103, Place::byte(8), || (MAJOR.to_string(), version(header.minor)))?;
        return ControlFlow::Continue(false);
    }
    let mut readable = true;
    if header.min_minor > header.minor {
        readable = false;
        out.breach(&rules::E0128, Place::byte(10), || (version(header.min_minor), version(header.minor)))?;
    } else if header.min_minor > MINOR {
        readable = false;
        out.breach(&rules::E0104, Place::byte(12), || (version(MINOR), version(header.min_minor)))?;
    }
    let unknown = header.features_required & !KNOWN_REQUIRED_FEATURES;
    if unknown != 0 {
        readable = false;
        out.breach(&rules::E0107, Place::byte(24), || {
            let bits: Vec<String> = (0..64).filter(|b| unknown >> b & 1 != 0).map(|b: u32| b.to_string()).collect();
            (format!("{KNOWN_REQUIRED_FEATURES:#x}"), format!("feature {} ({unknown:#x})", bits.join(", feature ")))
        })?;
    }
    ControlFlow::Continue(readable)
}

/// The header's tree flags as a file may have them.
///
/// # Errors
/// The first breach of the rule.
pub fn check_tree_flags(flags: u32) -> Result<(), Finding> {
    let mut first = First::default();
    _ = tree_flags_hold(flags, &mut first);
    first.result()
}

fn tree_flags_hold(flags: u32, out: &mut impl Sink) -> ControlFlow<()> {
    use tree_flags::{CANONICAL_DFS, DUP_REFS, REFITTABLE, SEQUENCE, TWO_LEVEL};
    let demands = [
        (flags & !(CANONICAL_DFS | DUP_REFS | REFITTABLE | SEQUENCE | TWO_LEVEL) == 0, "only bits 0x1f are known"),
        (flags & SEQUENCE == 0 || flags & TWO_LEVEL != 0, "TWO_LEVEL (0x10) must be set with SEQUENCE (0x8)"),
        (
            (flags & REFITTABLE != 0) != (flags & DUP_REFS != 0),
            "exactly one of REFITTABLE (0x1) and DUP_REFS (0x2) must be set",
        ),
        (flags & CANONICAL_DFS != 0, "CANONICAL_DFS (0x4) must be set"),
    ];
    for (holds, expected) in demands {
        if !holds {
            out.breach(&rules::E0126, Place::byte(56), || (expected.into(), format!("{flags:#x}")))?;
        }
    }
    ControlFlow::Continue(())
}
