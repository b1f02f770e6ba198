//! Arrays as NumPy stores them: a ZIP file of NPY files, deflated.

use flate2::read::DeflateDecoder;
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// Baked poses of one model.
pub struct Baked {
    /// The model, its animations and the times that were baked.
    pub meta: Value,
    arrays: BTreeMap<String, Vec<u8>>,
}

impl Baked {
    pub fn read(path: &Path) -> Baked {
        let file = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let arrays: BTreeMap<String, Vec<u8>> = entries(&file).collect();
        let meta = serde_json::from_slice(content(&arrays["meta.npy"], "|u1")).expect("JSON");
        Baked { meta, arrays }
    }

    /// The points of all arrays whose names begin so, in the order of the number that follows.
    pub fn points(&self, prefix: &str) -> Vec<[f64; 3]> {
        let array = |part: usize| self.arrays.get(&format!("{prefix}{part}.npy"));
        let numbers = (0..).map_while(array).flat_map(|array| content(array, "<f4").chunks_exact(4));
        let numbers: Vec<f64> = numbers.map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap()))).collect();
        numbers.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect()
    }
}

/// What follows an NPY header, whose type must be this one.
fn content<'a>(array: &'a [u8], kind: &str) -> &'a [u8] {
    let length = usize::from(u16::from_le_bytes([array[8], array[9]]));
    let header = std::str::from_utf8(&array[10..10 + length]).expect("ASCII");
    assert!(header.contains(&format!("'descr': '{kind}'")) && header.contains("'fortran_order': False"), "{header}");
    &array[10 + length..]
}

/// The files of a ZIP file, by its central directory: local headers need not state sizes.
fn entries(file: &[u8]) -> impl Iterator<Item = (String, Vec<u8>)> + '_ {
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([file[at], file[at + 1]]));
    let u32_at = move |at: usize| u16_at(at) | u16_at(at + 2) << 16;
    let end = file.windows(4).rposition(|w| w == b"PK\x05\x06").expect("the end of a ZIP file");
    let mut at = u32_at(end + 16);
    (0..u16_at(end + 10)).map(move |_| {
        assert_eq!((&file[at..at + 4], u16_at(at + 10)), (&b"PK\x01\x02"[..], 8), "a deflated file");
        let (packed, name_length, local) = (u32_at(at + 20), u16_at(at + 28), u32_at(at + 42));
        let name = String::from_utf8(file[at + 46..at + 46 + name_length].to_vec()).expect("UTF-8");
        at += 46 + name_length + u16_at(at + 30) + u16_at(at + 32);
        let data = local + 30 + u16_at(local + 26) + u16_at(local + 28);
        let mut bytes = Vec::new();
        DeflateDecoder::new(&file[data..data + packed]).read_to_end(&mut bytes).expect("deflated data");
        (name, bytes)
    })
}
