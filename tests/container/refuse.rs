//! What a reader must refuse, and what it must let pass.

use bvhc::cache::check::{Level, Limits, check_bytes};
use bvhc::cache::{
    Cache, CacheError, Codec, ConvertOptions, ErrorKind, Head, Header, Image, OpenOptions, SectionEntry, SectionKind,
    Validation, WriteOptions, convert, keys, rules, to_bytes,
};
use bvhc::exec::Executor;
use bvhc::geom::Ray;

use crate::images::{meta, one_triangle, two_instances};

fn quick() -> OpenOptions {
    OpenOptions { validation: Validation::Quick, ..OpenOptions::default() }
}

fn file() -> Vec<u8> {
    to_bytes(&one_triangle(), &meta(), &WriteOptions::default(), &Executor::current()).unwrap()
}

/// Sign header and table anew, so that only the mutation can be found.
pub fn sign(file: &mut [u8]) {
    let header: Header = bytemuck::pod_read_unaligned(&file[..256]);
    let table = 256..file.len().min(256 + 128 * (header.section_count as usize).min(1000));
    // Hash the sections where they are said to be, if they are there.
    for at in table.clone().step_by(128) {
        let Some(bytes) = file.get(at..at + 128) else { break };
        let mut entry: SectionEntry = bytemuck::pod_read_unaligned(bytes);
        let end = entry.offset.saturating_add(entry.stored_len).min(usize::MAX as u64) as usize;
        if let Some(stored) = file.get(entry.offset as usize..end)
            && entry.stored_hash != [0xee; 32]
        {
            entry.stored_hash = *blake3::hash(stored).as_bytes();
            if entry.codec == SectionEntry::RAW {
                entry.raw_hash = entry.stored_hash;
            }
            file[at..at + 128].copy_from_slice(bytemuck::bytes_of(&entry));
        }
    }
    let entries: Vec<SectionEntry> = file[table.clone()].chunks_exact(128).map(bytemuck::pod_read_unaligned).collect();
    let content_id = keys::content_id(&entries);
    let header = Header { content_id, ..header };
    let file_id = keys::file_id(&header, &[], &file[table]);
    file[..256].copy_from_slice(bytemuck::bytes_of(&Header { file_id, ..header }));
}

fn with_header(change: impl FnOnce(&mut Header)) -> Vec<u8> {
    let mut file = file();
    let mut header: Header = bytemuck::pod_read_unaligned(&file[..256]);
    change(&mut header);
    file[..256].copy_from_slice(bytemuck::bytes_of(&header));
    sign(&mut file);
    file
}

fn with_entry(index: usize, change: impl FnOnce(&mut SectionEntry)) -> Vec<u8> {
    let mut file = file();
    let at = 256 + 128 * index;
    let mut entry: SectionEntry = bytemuck::pod_read_unaligned(&file[at..at + 128]);
    change(&mut entry);
    file[at..at + 128].copy_from_slice(bytemuck::bytes_of(&entry));
    sign(&mut file);
    file
}

fn refused(file: &[u8]) -> CacheError {
    Cache::from_bytes(file, &quick()).expect_err("it must be refused")
}

fn rule(file: &[u8]) -> &'static str {
    refused(file).rule().expect("a broken rule")
}

#[test]
fn header_rules() {
    assert_eq!(rule(&with_header(|h| h.magic[0] = 0)), "E0102");
    assert_eq!(rule(b""), "E0102");
    assert_eq!(rule(&file()[..200]), "E0101");
    assert_eq!(rule(&with_header(|h| h.header_len = 128)), "E0105");
    assert_eq!(rule(&with_header(|h| h.header_len = 320)), "E0105");
    assert_eq!(rule(&with_header(|h| h.file_len += 64)), "E0106");
    assert_eq!(rule(&with_header(|h| h.reserved[31] = 1)), "E0111");
    assert_eq!(rule(&with_header(|h| h.tree_flags = 7)), "E0126");
    assert_eq!(rule(&with_header(|h| h.tree_flags |= 8)), "E0126");
    assert_eq!(rule(&with_header(|h| h.section_entry_len = 64)), "E0109");
    assert_eq!(rule(&with_header(|h| h.section_table_off = 512)), "E0110");
    assert_eq!(rule(&with_header(|h| h.tree_flags |= 16)), "E0125");
    let mut file = file();
    file[40..44].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_eq!(rule(&file), "E0108");
}

#[test]
fn what_a_later_version_needs_is_named() {
    let check = |file: &[u8], id: &str, word: &str| {
        let error = refused(file);
        assert_eq!((error.kind(), error.rule()), (ErrorKind::Unsupported, Some(id)), "{error}");
        assert!(error.to_string().contains(word), "{error} must say {word}");
        // The library names no command: that is for the program to say.
        assert!(!error.to_string().contains("bvhc build"), "{error}");
    };
    check(&with_header(|h| h.major = 2), "E0103", "version 2.0");
    let later = bvhc::cache::MINOR + 1;
    let name = format!("1.{later}");
    check(&with_header(|h| (h.minor, h.min_minor) = (later, later)), "E0104", &name);
    check(&with_header(|h| h.min_minor = later), "E0128", &name);
    check(&with_header(|h| h.features_required = 1 << 37), "E0107", "feature 37");
    check(&with_entry(0, |e| e.kind = SectionKind(*b"QNOD")), "E0113", "QNOD");
    check(&with_entry(0, |e| e.schema = 9), "E0114", "schema 9");
    check(&with_entry(1, |e| e.codec = 7), "E0115", "codec 7");
}

#[test]
fn what_a_later_version_adds_is_skipped() {
    assert!(Cache::from_bytes(&with_header(|h| (h.minor, h.features_optional) = (9, 1 << 60)), &quick()).is_ok());
    for file in [
        with_entry(4, |e| e.kind = SectionKind(*b"XTRA")),
        with_entry(4, |e| e.schema = 2),
        with_entry(4, |e| e.ordinal = 1),
    ] {
        let cache = Cache::from_bytes(&file, &OpenOptions::default()).unwrap();
        assert!(cache.names().is_empty() && cache.meta().is_some());
    }
    let cache = Cache::from_bytes(&with_entry(5, |e| e.codec = 200), &OpenOptions::default()).unwrap();
    assert!(cache.meta().is_none() && cache.section_bytes(5).is_none());

    // A longer header, as a later minor may write it.
    let mut longer = file();
    longer.splice(256..256, [7; 64]);
    let mut header: Header = bytemuck::pod_read_unaligned(&longer[..256]);
    (header.header_len, header.section_table_off, header.file_len) = (320, 320, longer.len() as u64);
    header.minor = bvhc::cache::MINOR + 1;
    let table = 320..320 + 128 * header.section_count as usize;
    for i in 0..header.section_count as usize {
        let at = 320 + 128 * i;
        let mut entry: SectionEntry = bytemuck::pod_read_unaligned(&longer[at..at + 128]);
        entry.offset += 64;
        longer[at..at + 128].copy_from_slice(bytemuck::bytes_of(&entry));
    }
    header.file_id = keys::file_id(&header, &[7; 64], &longer[table]);
    longer[..256].copy_from_slice(bytemuck::bytes_of(&header));
    assert_eq!(Cache::from_bytes(&longer, &OpenOptions::default()).unwrap().triangles().len(), 1);
    longer[300] ^= 1;
    assert_eq!(rule(&longer), "E0203");
}

/// Provenance is for people and build systems: what is wrong with it keeps no ray from being traced, and is said.
#[test]
fn a_file_whose_meta_or_names_cannot_be_read_is_opened_and_checked() {
    let body = |index: usize, change: fn(&mut [u8])| {
        let mut file = file();
        let entry: SectionEntry = bytemuck::pod_read_unaligned(&file[256 + 128 * index..][..128]);
        change(&mut file[entry.offset as usize..][..entry.stored_len as usize]);
        sign(&mut file);
        file
    };
    let broken = [
        (body(5, |meta| meta[..8].fill(0xff)), "E0206"),
        (with_entry(5, |e| (e.codec, e.raw_len) = (SectionEntry::ZSTD, 99)), "E0205"),
        (with_entry(5, |e| e.schema = 2), "W0101"),
        (with_entry(5, |e| e.codec = 77), "W0101"),
        (body(4, |names| names[0] = 9), "E0208"),
    ];
    for (file, rule) in broken {
        for validation in [Validation::Quick, Validation::Hash, Validation::Tree] {
            let cache = Cache::from_bytes(&file, &OpenOptions { validation, ..OpenOptions::default() }).unwrap();
            let ray = Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]);
            assert!(cache.closest_hit(&ray).unwrap().is_some(), "{rule}");
            assert_eq!(cache.meta().is_none(), rule != "E0208");
            assert_eq!(cache.meta_error().is_some_and(|why| why.contains(rule)), rule != "E0208", "{rule}");
        }
        let report = check_bytes(&file, Level::Tree, None, &Limits::default(), &Executor::current());
        assert_eq!(report.counts().map(|(rule, _)| rule.id).collect::<Vec<_>>(), [rule]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bvhc");
        std::fs::write(&path, &file).unwrap();
        let head = Head::read(&path, &quick()).unwrap();
        assert_eq!((head.meta.is_none(), head.meta_error.is_some()), (rule != "E0208", rule != "E0208"));
    }
}

#[test]
fn a_table_of_65536_entries_takes_no_comparison_of_each_with_each() {
    let count = 65_536u32;
    let table = |count: u32, last: u32| {
        let mut entries: Vec<SectionEntry> = Vec::new();
        let offset = 256 + 128 * u64::from(count);
        let empty = *blake3::hash(b"").as_bytes();
        for ordinal in (0..count - 1).chain([last]) {
            let kind = SectionKind(*b"XTRA");
            let zero = bytemuck::Zeroable::zeroed();
            let (raw_hash, stored_hash, align_log2) = (empty, empty, 6);
            entries.push(SectionEntry { kind, ordinal, offset, raw_hash, stored_hash, align_log2, ..zero });
        }
        let mut header: Header = bytemuck::pod_read_unaligned(&file()[..256]);
        (header.section_count, header.file_len, header.content_id) = (count, offset, keys::content_id(&entries));
        header.file_id = keys::file_id(&header, &[], bytemuck::cast_slice(&entries));
        [bytemuck::bytes_of(&header), bytemuck::cast_slice(&entries)].concat()
    };
    assert_eq!(rule(&table(count, 0)), "E0121");
    assert_eq!(rule(&table(count, count - 1)), "E0125");
    for last in [0, count - 1] {
        let report = check_bytes(&table(count, last), Level::Tree, None, &Limits::default(), &Executor::current());
        assert_eq!(report.count(&rules::E0121) > 0, last == 0);
    }

    // Sixteen times the entries take sixteen times as long, but 256 times where each is compared with each.
    let spent = |count: u32| {
        let table = table(count, count - 1);
        let once = || {
            let start = std::time::Instant::now();
            assert_eq!(rule(&table), "E0125");
            start.elapsed()
        };
        // The best of five, since other tests run beside this one.
        (0..5).map(|_| once()).min().unwrap_or_default()
    };
    // On a machine that does other things one of several tries is enough: none would be quick if each were compared with each.
    let tries: Vec<_> = (0..8).map(|_| (spent(count / 16), spent(count))).collect();
    assert!(tries.iter().any(|(few, many)| *many < 64 * *few), "for {} and for {count} entries: {tries:?}", count / 16);
}

#[test]
fn section_rules() {
    assert_eq!(rule(&with_entry(0, |e| e.reserved[0] = 1)), "E0112");
    assert_eq!(rule(&with_entry(0, |e| e.align_log2 = 5)), "E0116");
    assert_eq!(rule(&with_entry(1, |e| e.offset += 1)), "E0116");
    assert_eq!(rule(&with_entry(5, |e| e.stored_len = u64::MAX)), "E0117");
    assert_eq!(rule(&with_entry(1, |e| e.offset -= 64)), "E0118");
    assert_eq!(rule(&with_entry(5, |e| e.stored_len = 1)), "E0120");
    assert_eq!(rule(&with_entry(5, |e| (e.kind, e.flags) = (SectionKind::NAMS, 2))), "E0121");
    assert_eq!(rule(&with_entry(1, |e| e.elem_size = 16)), "E0123");
    assert_eq!(rule(&with_entry(1, |e| (e.elem_size, e.elem_count) = (16, 3))), "E0122");
    assert_eq!(rule(&with_entry(1, |e| e.elem_count = u64::MAX)), "E0123");
    assert_eq!(rule(&with_entry(1, |e| e.stored_hash = [0xee; 32])), "E0123");
    assert_eq!(rule(&with_entry(1, |e| e.flags = 7)), "E0124");
    assert_eq!(rule(&with_entry(1, |e| e.flags |= 8)), "E0124");
    assert_eq!(rule(&with_entry(0, |e| (e.kind, e.flags) = (SectionKind(*b"XTRA"), 0))), "E0125");
    // A layout that this version does not know, in a section that says of itself that it may be skipped: nothing could be traced.
    let skipped = with_entry(0, |e| (e.schema, e.flags) = (9, 0));
    assert_eq!(rule(&skipped), "E0125");
    let report = check_bytes(&skipped, Level::Tree, None, &Limits::default(), &Executor::current());
    assert_eq!(report.counts().map(|(rule, _)| rule.id).collect::<Vec<_>>(), ["E0125", "W0101"]);
    let mut padded = file();
    let last = padded.len() - 1;
    padded[last] = 1;
    assert_eq!(rule(&padded), "E0119");
}

#[test]
fn every_flipped_bit_is_found() {
    for image in [one_triangle(), two_instances()] {
        for codec in [Codec::Raw, Codec::Zstd { level: 3 }] {
            let file =
                to_bytes(&image, &meta(), &WriteOptions { codec, ..WriteOptions::default() }, &Executor::current())
                    .unwrap();
            for bit in 0..file.len() * 8 {
                let mut damaged = file.clone();
                damaged[bit / 8] ^= 1 << (bit % 8);
                assert!(Cache::from_bytes(&damaged, &OpenOptions::default()).is_err(), "bit {bit}");
                _ = Cache::from_bytes(&damaged, &quick());
            }
            for len in 0..file.len() {
                assert!(Cache::from_bytes(&file[..len], &quick()).is_err(), "length {len}");
            }
            assert!(Cache::from_bytes(&[&file[..], &[0; 64]].concat(), &quick()).is_err());
        }
    }
}

/// Many triangles, and nodes enough that their leaves could hold them.
pub fn many_triangles() -> Image {
    let mut image = one_triangle();
    image.triangles.resize(100_000, image.triangles[0]);
    image.nodes.resize(1000, bytemuck::Zeroable::zeroed());
    (image.blases[0].ref_count, image.blases[0].node_count) = (100_000, 1000);
    image
}

#[test]
fn memory_is_claimed_only_within_the_limit() {
    let options = WriteOptions { codec: Codec::Zstd { level: 3 }, check: false };
    let file = to_bytes(&many_triangles(), &meta(), &options, &Executor::current()).unwrap();
    assert!(Cache::from_bytes(&file, &quick()).is_ok());
    let small = OpenOptions { max_memory: 1 << 20, ..quick() };
    assert_eq!(Cache::from_bytes(&file, &small).unwrap_err().kind(), ErrorKind::Limit);

    // An entry that claims 2⁶⁰ bytes is refused by the default limit, before anything is allocated.
    let mut bomb = file;
    let at = 256 + 128;
    let mut entry: SectionEntry = bytemuck::pod_read_unaligned(&bomb[at..at + 128]);
    (entry.raw_len, entry.elem_count) = (48 << 54, 1 << 54);
    bomb[at..at + 128].copy_from_slice(bytemuck::bytes_of(&entry));
    sign(&mut bomb);
    assert_eq!(refused(&bomb).kind(), ErrorKind::Limit);
    // One that claims 4 GB is within it, and is not what the header says.
    (entry.raw_len, entry.elem_count) = (48 * 80_000_000, 80_000_000);
    bomb[at..at + 128].copy_from_slice(bytemuck::bytes_of(&entry));
    sign(&mut bomb);
    assert_eq!(rule(&bomb), "E0302");
    // With a header that says the same, it is not what the row of BLAS says.
    let mut header: Header = bytemuck::pod_read_unaligned(&bomb[..256]);
    header.ref_count = 80_000_000;
    bomb[..256].copy_from_slice(bytemuck::bytes_of(&header));
    sign(&mut bomb);
    assert_eq!(rule(&bomb), "E0311");
}

#[test]
fn paths_that_are_no_files_are_errors_of_input_and_output() {
    let folder = tempfile::tempdir().unwrap();
    for path in [folder.path().to_owned(), folder.path().join("none"), "/dev/null".into()] {
        assert_eq!(Cache::open(&path).unwrap_err().kind(), ErrorKind::Io, "{}", path.display());
    }
    let empty = folder.path().join("empty");
    std::fs::write(&empty, "").unwrap();
    assert_eq!(Cache::open(&empty).unwrap_err().kind(), ErrorKind::Invalid);
}

#[test]
fn convert_keeps_what_may_be_copied_and_refuses_to_lose_content() {
    let folder = tempfile::tempdir().unwrap();
    let [from, to] = ["from", "to"].map(|n| folder.path().join(n));
    let convert = |file: Vec<u8>| {
        std::fs::write(&from, file).unwrap();
        convert(&from, &to, &OpenOptions::default(), &ConvertOptions::default(), &Executor::current())
    };
    let kinds = || Cache::open(&to).unwrap().sections().iter().map(|s| s.kind).collect::<Vec<_>>();
    let extra = SectionKind(*b"XTRA");

    assert_eq!(convert(with_entry(5, |e| e.kind = extra)).unwrap().dropped, []);
    assert!(kinds().contains(&extra));
    assert_eq!(convert(with_entry(5, |e| (e.kind, e.codec) = (extra, 9))).unwrap().dropped, []);
    assert!(kinds().contains(&extra));
    assert_eq!(convert(with_entry(5, |e| (e.kind, e.flags) = (extra, 0))).unwrap().dropped, [extra]);
    assert!(!kinds().contains(&extra));
    let error = convert(with_entry(5, |e| (e.kind, e.flags) = (extra, 4))).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unsupported);
    assert!(error.to_string().contains("XTRA"));
}
