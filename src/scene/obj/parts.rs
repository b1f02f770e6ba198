//! Parts: which faces belong together, and what that is called.

use super::names::{part_name, readable};
use super::words::split_word;

/// What a part is called; see [`part_name`].
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct PartName {
    pub name: String,
    pub material: String,
}

/// What a face belongs to, as bytes. Faces next to each other that belong to the same are one part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Run<'a> {
    /// How many `o` there were: two objects of one name are two.
    objects: u64,
    object: &'a [u8],
    group: &'a [u8],
    material: &'a [u8],
}

/// The parts so far.
#[derive(Debug, Default)]
pub(super) struct Parts<'a> {
    /// What the statements so far say of the next face, and what held for the latest.
    next: Run<'a>,
    latest: Option<Run<'a>>,
    names: Vec<PartName>,
}

impl<'a> Parts<'a> {
    /// Take in a statement that names what the faces after it belong to. False for any other statement.
    pub fn name(&mut self, line: &'a [u8]) -> bool {
        let (keyword, name) = split_word(line);
        let name = name.trim_ascii();
        match keyword {
            b"o" => {
                self.next.objects += 1;
                self.next.object = name;
            }
            b"g" => self.next.group = name,
            b"usemtl" => self.next.material = name,
            _ => return false,
        }
        true
    }

    /// Whether the next face belongs to the same part as the latest.
    pub fn go_on(&self) -> bool {
        self.latest == Some(self.next)
    }

    /// Begin a part: tell `tobj` its number, which is all that it shall know. The memory that it takes.
    pub fn begin(&mut self, out: &mut Vec<u8>) -> u64 {
        self.latest = Some(self.next);
        let Run { object, group, material, .. } = self.next;
        let part = PartName { name: part_name(object, group), material: readable(material, "%") };
        let bytes = part.name.len() + part.material.len() + size_of::<PartName>() + 512; // and tobj's model
        out.extend_from_slice(format!("g {}\n", self.names.len()).as_bytes());
        self.names.push(part);
        bytes as u64
    }

    /// The parts' names, by their numbers.
    pub fn into_names(self) -> Vec<PartName> {
        self.names
    }
}
