//! `META`, `NAMS` and `MATS`: what traversal does not need, but people and build systems do.

use crate::cache::container::{Container, hex};
use crate::cache::meta::Meta;
use crate::cache::report::{Place, Report};
use crate::cache::rules::{self, Rule, Severity};
use crate::layout::{GeomRecord, Header, MAX_STRING_LEN, SectionEntry, SectionKind};

/// META in its one encoding, and the build key that follows from it.
pub fn check_meta(bytes: &[u8], header: &Header, out: &mut Report) -> Option<Meta> {
    match Meta::decode(bytes) {
        Ok(meta) => {
            let key = meta.build_key();
            if key != header.build_key {
                out.add(&rules::E0207, Place::byte(128), || (hex(&key), hex(&header.build_key)));
            }
            for (i, input) in meta.dependencies.iter().enumerate().filter(|(_, input)| input.is_absolute()) {
                let at = Place::section(SectionKind::META);
                out.add(&rules::E0209, at, || (i.to_string(), format!("{:?}", input.name)));
            }
            Some(meta)
        }
        // A build without the feature `meta` finds nothing wrong with it.
        Err(unread) if unread.rule.severity() == Severity::Warning => {
            out.skip(format!("META: {}.", unread.detail()));
            None
        }
        Err(breach) => {
            out.add_finding(breach);
            None
        }
    }
}

/// The names of the parts, with or without their section.
pub fn check_names_of(
    container: &Container,
    found: Option<(&[u8], &SectionEntry)>,
    geoms: &[GeomRecord],
    out: &mut Report,
) {
    match found {
        Some((bytes, entry)) => check_names(bytes, entry.elem_count, geoms, out),
        None if container.entries.iter().all(|e| e.kind != SectionKind::NAMS) => check_nameless(geoms, out),
        None => {} // it is there and cannot be read, which has been said
    }
}

/// Without the section no part has a name.
fn check_nameless(geoms: &[GeomRecord], out: &mut Report) {
    for (i, geom) in geoms.iter().enumerate().filter(|(_, geom)| geom.name_hash != [0; 32]) {
        let place = Place::record(SectionKind::GEOM, i as u64);
        out.add(&rules::E0320, place, || (format!("{} without NAMS", hex(&[0; 32])), hex(&geom.name_hash)));
    }
}

/// One name for each part, and each has the hash that its part states.
///
/// `stated`: the section's `elem_count`.
fn check_names(bytes: &[u8], stated: u64, geoms: &[GeomRecord], out: &mut Report) {
    check_strings((SectionKind::NAMS, &rules::E0208), bytes, stated, geoms.len(), out, |i, name, out| {
        let hash = if name.is_empty() { [0; 32] } else { *blake3::hash(name).as_bytes() };
        if let Some(geom) = geoms.get(i).filter(|geom| geom.name_hash != hash) {
            let place = Place::record(SectionKind::GEOM, i as u64);
            out.add(&rules::E0320, place, || (hex(&hash), hex(&geom.name_hash)));
        }
    });
}

/// One material's name for each part.
pub fn check_materials(bytes: &[u8], stated: u64, parts: usize, out: &mut Report) {
    check_strings((SectionKind::MATS, &rules::E0210), bytes, stated, parts, out, |_, _, _| ());
}

/// One name for each part: the table adds up, and the text is UTF-8. `each` sees every name before the first that is broken.
fn check_strings(
    (kind, rule): (SectionKind, &'static Rule),
    bytes: &[u8],
    stated: u64,
    count: usize,
    out: &mut Report,
    mut each: impl FnMut(usize, &[u8], &mut Report),
) {
    let at = Place::section(kind);
    let word = |i: usize| Some(u32::from_le_bytes(bytes.get(i.checked_mul(4)?..)?.get(..4)?.try_into().ok()?));
    let mut refuse = |expected: String, actual: String| out.add(rule, at, || (expected, actual));
    let (Some(names), Some(text_len)) = (word(0), word(1)) else {
        return refuse("the section must have 8 bytes at least".into(), format!("it has {}", bytes.len()));
    };
    if names as usize != count || stated != count as u64 {
        return refuse(format!("there must be {count} names"), format!("the section has {names}, its entry {stated}"));
    }
    let text_start = 8 + 4 * count; // there are that many records in memory
    let text = bytes.get(text_start..).unwrap_or_default();
    if bytes.len() < text_start || text.len() != text_len as usize {
        return refuse(
            format!("{} bytes of text must follow the table", text_len),
            format!("there are {}", text.len()),
        );
    }
    if text.is_empty() {
        return refuse(format!("some part must have a name where there is {kind}"), "none has".into());
    }

    // Cut the text into names.
    let mut start = 0usize;
    for i in 0..count {
        let end = word(2 + i).unwrap_or(0) as usize;
        let name = if end >= start { text.get(start..end) } else { None };
        let Some(name) = name.filter(|n| n.len() <= MAX_STRING_LEN && std::str::from_utf8(n).is_ok()) else {
            let expected =
                format!("name {i} must be up to {MAX_STRING_LEN} bytes of UTF-8 within {} bytes", text.len());
            out.add(rule, at, || (expected, format!("it is bytes {start} to {end}")));
            return;
        };
        each(i, name, out);
        start = end;
    }
    if start != text.len() {
        out.add(rule, at, || (format!("the last name must end at {}", text.len()), format!("it ends at {start}")));
    }
}
