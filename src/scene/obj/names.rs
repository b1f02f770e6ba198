//! Names of parts, so written that no two of them are one and that the file's bytes can be got back.

/// What a part is called after its object and its group, both as bytes of the file without the spaces around them.
///
/// | file | name |
/// |---|---|
/// | `o Lamp` | `Lamp` |
/// | `g off` | `/off` |
/// | `o Lamp`, `g off` | `Lamp/off` |
/// | `o a/b`, `g 5%` | `a%2Fb/5%25` |
///
/// So the first `/` ends the object, and each side is the name with `%` and two hexadecimal digits for what cannot stand
/// there: `%` itself, bytes that are not UTF-8, and in the object's name `/`. Faces before any `o` and `g` have no name.
pub(super) fn part_name(object: &[u8], group: &[u8]) -> String {
    let mut name = readable(object, "%/");
    if !group.is_empty() {
        name.push('/');
        name.push_str(&readable(group, "%"));
    }
    name
}

/// Bytes as text: those of `escaped` and those that are not UTF-8 as `%` and two hexadecimal digits.
pub(super) fn readable(bytes: &[u8], escaped: &str) -> String {
    let mut text = String::with_capacity(bytes.len());
    let hex = |text: &mut String, byte: u8| *text += &format!("%{byte:02X}");
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            match u8::try_from(c) {
                Ok(byte) if escaped.contains(c) => hex(&mut text, byte),
                _ => text.push(c),
            }
        }
        chunk.invalid().iter().for_each(|byte| hex(&mut text, *byte));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use percent_encoding::percent_decode;
    use std::collections::BTreeMap;

    #[test]
    fn names_are_told_apart_and_read_back() {
        let words: [&[u8]; 10] =
            [b"", b"a", b"/", b"a/b", b"%", b"%2F", b"caf\xc3\xa9", b"caf\xe9", b"caf%E9", b"a b\\ \t#"];
        let mut seen = BTreeMap::new();
        for object in words {
            for group in words {
                let name = part_name(object, group);
                let (first, second) = name.split_once('/').unwrap_or((&name, ""));
                let back = [first, second].map(|side| percent_decode(side.as_bytes()).collect::<Vec<u8>>());
                assert_eq!(back, [object, group], "{name}");
                assert_eq!(seen.insert(name, (object, group)), None);
            }
        }
        assert_eq!(part_name(b"Lamp", b""), "Lamp");
        assert_eq!(part_name(b"caf\xc3\xa9", b"off 2"), "café/off 2");
        assert_eq!(readable(b"wood/oak", "%"), "wood/oak");
    }
}
