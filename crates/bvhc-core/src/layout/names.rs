//! `NAMS` and `MATS`: the names of the source parts and of their materials, one for each row of `GEOM`.
//!
//! A string table in three pieces: two counts, the end of each name, the text. Names are looked up one at a time and bounds-checked
//! then, so opening a file costs nothing however many there are.

use std::borrow::Cow;

/// Most bytes that a string of META or NAMS may have.
pub const MAX_STRING_LEN: usize = 4096;

/// `name` as it may stand in a file. Of a longer one it is the start, then `~` and the first half of the whole name's BLAKE3 in hexadecimal digits, so that
/// names which differ only behind that are told apart.
pub fn clip_name(name: &str) -> Cow<'_, str> {
    if name.len() <= MAX_STRING_LEN {
        return Cow::Borrowed(name);
    }
    let hash = blake3::hash(name.as_bytes()).to_hex();
    let tail = &hash[..32];
    Cow::Owned(format!("{}~{tail}", clip(name, MAX_STRING_LEN - 1 - tail.len())))
}

/// The longest start of `text` that has at most `max` bytes and ends at a character.
pub fn clip(text: &str, max: usize) -> &str {
    let end = (0..=max.min(text.len())).rev().find(|&i| text.is_char_boundary(i));
    &text[..end.unwrap_or(0)]
}

/// A section's bytes, or `None` where every name is empty or the text would not fit 32-bit offsets.
pub fn encode_names(names: &[String]) -> Option<Vec<u8>> {
    let names: Vec<Cow<str>> = names.iter().map(|name| clip_name(name)).collect();
    let text_len: usize = names.iter().map(|name| name.len()).sum();
    let (count, text_len) = (u32::try_from(names.len()).ok()?, u32::try_from(text_len).ok()?);
    if text_len == 0 {
        return None;
    }
    let mut out = Vec::with_capacity(8 + 4 * names.len() + text_len as usize);
    out.extend(count.to_le_bytes());
    out.extend(text_len.to_le_bytes());
    let mut end = 0;
    for name in &names {
        end += name.len() as u32;
        out.extend(end.to_le_bytes());
    }
    names.iter().for_each(|name| out.extend(name.as_bytes()));
    Some(out)
}

/// The names in a section's bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Names<'a> {
    bytes: &'a [u8],
}

impl<'a> Names<'a> {
    /// From the bytes of a NAMS or MATS section. Nothing is checked here: broken bytes have fewer names, or names that are `None`.
    pub fn new(bytes: &'a [u8]) -> Names<'a> {
        Names { bytes }
    }

    /// Number of names that the section states.
    pub fn len(&self) -> usize {
        self.word(0).map_or(0, |n| n as usize)
    }

    /// Whether the section states no names.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Name `index`; `None` beyond the end and where the section's bytes are not what they should be.
    pub fn get(&self, index: usize) -> Option<&'a str> {
        if index >= self.len() {
            return None;
        }
        let end_of = |name: usize| Some(self.word(name.checked_add(2)?)? as usize);
        let start = if index == 0 { 0 } else { end_of(index - 1)? };
        let end = end_of(index)?;
        let text = self.bytes.get(8usize.checked_add(self.len().checked_mul(4)?)?..)?;
        std::str::from_utf8(text.get(start..end)?).ok()
    }

    fn word(&self, index: usize) -> Option<u32> {
        let at = index.checked_mul(4)?;
        let bytes = self.bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back_and_long_ones_end_at_a_character() {
        let long = "é".repeat(3000);
        let other = format!("{long}x");
        let names: Vec<String> = ["", "roof", &long, "", &other].map(String::from).into();
        let bytes = encode_names(&names).unwrap();
        let read = Names::new(&bytes);
        assert_eq!(
            (read.len(), read.get(0), read.get(1), read.get(3), read.get(4)),
            (5, Some(""), Some("roof"), Some(""), Some(&*clip_name(&other)))
        );
        let shown = read.get(2).unwrap();
        let (start, hash) = shown.rsplit_once('~').unwrap();
        assert!(start == "é".repeat(2031) && shown.len() <= MAX_STRING_LEN, "{} bytes", shown.len());
        assert_eq!(hash, &blake3::hash(long.as_bytes()).to_hex()[..32]);
        assert_ne!(read.get(2), read.get(4));
        let just = "é".repeat(2048);
        assert_eq!(clip_name(&just), just);
        assert_eq!(read.get(5), None);
        assert!(encode_names(&["".into()]).is_none() && encode_names(&[]).is_none());
    }

    #[test]
    fn broken_tables_give_no_name() {
        let bytes = encode_names(&["ab".into(), "c".into()]).unwrap();
        for len in 0..bytes.len() {
            let read = Names::new(&bytes[..len]);
            (0..3).for_each(|i| _ = read.get(i));
        }
        let mut decreasing = bytes.clone();
        decreasing[8] = 200;
        assert_eq!(Names::new(&decreasing).get(0), None);
        assert_eq!(Names::new(&decreasing).get(1), None);
        let mut absurd = bytes;
        absurd[..4].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(Names::new(&absurd).get(u32::MAX as usize - 1), None);
    }
}
