//! The checker checked: each rule finds the file that breaks it and nothing else, and no damage goes unnoticed.

#[path = "../common/mod.rs"]
mod common;
mod damage;

use std::collections::BTreeMap;

use bvhc::cache::check::{Level, Limits, Source, check_bytes};
use bvhc::cache::{
    Between, Cache, CacheError, OpenOptions, SectionEntry, SectionKind, Sequence, Validation, View, rules, tree_flags,
};
use bvhc::exec::Executor;
use bvhc::geom::{Aabb, Ray};
use bvhc::trace::{NoObserver, try_any_hit, try_closest_hit};
use common::vectors::{bytes as vectors_bytes, invalid, scenes, sequences, valid};

fn lines(report: &bvhc::cache::check::Report) -> String {
    report.findings.iter().map(|f| format!("\n  {f}")).collect()
}

#[test]
fn every_valid_vector_is_clean() {
    for v in valid::all() {
        let report = check_bytes(&v.bytes, Level::Source, None, &Limits::default(), &Executor::current());
        assert!(report.is_valid(), "{}:{}", v.name, lines(&report));
        let ancillary = v.name == "unknown-ancillary-section";
        assert_eq!(report.is_clean(), !ancillary, "{}:{}", v.name, lines(&report));
        assert!(report.not_checked.is_empty(), "{}: {:?}", v.name, report.not_checked);
    }
}

#[test]
fn every_rule_finds_the_file_that_breaks_it_and_nothing_else() {
    let mut wrong = Vec::new();
    for v in invalid::all() {
        let report = v.check();
        let found: Vec<&str> = report.counts().map(|(r, _)| r.id).collect();
        if found != [v.rule.id] {
            wrong.push(format!("{} {} {}: found {found:?}{}", v.rule.id, v.rule.name, v.case, lines(&report)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What a section says is compared with the model only where the section itself is sound.
#[test]
fn damaged_origins_break_the_rule_of_their_section_alone() {
    let mut mesh = scenes::sheet(2, 0.0);
    let part = &mut mesh.parts[0];
    (part.baked_node, part.mirrored, part.material) = (Some(2), true, "oak".into());
    let tree = scenes::tree(&mesh, 1);
    let sound = vectors_bytes::file(&scenes::one_level(mesh.clone(), tree));
    let (meshes, inputs) = ([mesh], scenes::inputs());
    let found = |file: &[u8]| {
        let source = Source { meshes: &meshes, instances: None, inputs: &inputs, report: None };
        let report = check_bytes(file, Level::Source, Some(&source), &Limits::default(), &Executor::current());
        report.counts().map(|(rule, _)| rule.id).collect::<Vec<&str>>()
    };
    assert_eq!(found(&sound), [""; 0]);
    for (kind, rule, byte, value) in [(SectionKind::MATS, "E0210", 8, 200), (SectionKind::SIDE, "E0324", 0, 2)] {
        let mut damaged = sound.clone();
        vectors_bytes::stored(&mut damaged, kind)[byte] = value;
        assert_eq!(found(&damaged), ["E0201"], "{kind}");
        assert_eq!(found(&vectors_bytes::refix(damaged)), [rule], "{kind}");
    }
    let (header, mut sections) = vectors_bytes::take_apart(&sound);
    sections.iter_mut().filter(|(e, _)| e.kind == SectionKind::SIDE).for_each(|(_, data)| data.extend([0; 4]));
    assert_eq!(found(&vectors_bytes::put_together(header, sections)), ["E0324"]);
}

#[test]
fn no_rule_is_without_its_file() {
    let mut made: BTreeMap<&str, u32> = BTreeMap::new();
    for v in invalid::all().into_iter().filter(|v| v.case.is_empty()) {
        *made.entry(v.rule.id).or_default() += 1;
    }
    for rule in rules::all() {
        assert_eq!(made.get(rule.id), Some(&1), "{} {}", rule.id, rule.name);
    }
}

/// A small generator of numbers, so that the tests damage the same bytes everywhere.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.roll() % n.max(1) as u64) as usize
    }
}

#[test]
fn each_of_20_000_bit_flips_is_detected() {
    let vectors = valid::all();
    let mut dice = Dice(1);
    for i in 0..20_000 {
        let v = &vectors[i % vectors.len()];
        let mut bytes = v.bytes.clone();
        let (at, bit) = (dice.below(bytes.len()), dice.below(8));
        bytes[at] ^= 1 << bit;
        let report = check_bytes(&bytes, Level::Hash, None, &Limits::default(), &Executor::current());
        assert!(!report.is_valid(), "{}: bit {bit} of byte {at} flips unseen", v.name);
    }
}

#[test]
fn every_truncation_and_any_appended_byte_is_detected() {
    for v in valid::all() {
        // Each length of the small files; of the larger ones every length up to the sections, then every 61st.
        let lengths = (0..v.bytes.len()).filter(|l| v.bytes.len() < 6000 || *l < 1300 || l % 61 == 0);
        for len in lengths {
            let report = check_bytes(&v.bytes[..len], Level::Quick, None, &Limits::default(), &Executor::current());
            assert!(!report.is_valid(), "{} cut to {len} bytes passes", v.name);
        }
        for byte in [0, 1, 255] {
            let longer = [&v.bytes[..], &[byte]].concat();
            let report = check_bytes(&longer, Level::Quick, None, &Limits::default(), &Executor::current());
            assert_eq!(report.count(&rules::E0106), 1, "{} with a byte {byte} behind it passes", v.name);
        }
    }
}

#[test]
fn unaligned_bytes_are_checked_like_aligned_ones() {
    let v = valid::two_level_file();
    for shift in 0..9 {
        let mut shifted = vec![0; shift];
        shifted.extend(&v);
        let report = check_bytes(&shifted[shift..], Level::Tree, None, &Limits::default(), &Executor::current());
        assert!(report.is_clean(), "shifted by {shift}:{}", lines(&report));
    }
}

/// Sixty-five pairs, both nodes of each pointing at the next pair: in bounds, acyclic, 64 deep, and 2⁶⁴ visits to follow.
#[test]
fn a_ladder_of_shared_pairs_is_refused_without_climbing_it() {
    let bytes = invalid::ladder();
    assert!(bytes.len() < 8192);
    let report = check_bytes(&bytes, Level::Tree, None, &Limits::default(), &Executor::current());
    assert!(report.count(&rules::E0404) > 0, "{}", lines(&report));
}

#[test]
fn findings_are_capped_but_all_are_counted() {
    let mut bytes = valid::plane_file();
    for kind in [bvhc::cache::SectionKind::TRIS] {
        for (i, byte) in vectors_bytes::stored(&mut bytes, kind).iter_mut().enumerate() {
            // The part of every triangle.
            if i % 48 == 28 {
                *byte = 9;
            }
        }
    }
    let bytes = vectors_bytes::refix(bytes);
    let report =
        check_bytes(&bytes, Level::Tree, None, &Limits { max_issues: 3, ..Limits::default() }, &Executor::current());
    let stored = report.findings.iter().filter(|f| f.rule == &rules::E0416).count();
    assert_eq!((stored, report.count(&rules::E0416), report.truncated()), (3, 8, 5));
    // Each finding says where in the file the record stands.
    let first = report.findings.iter().find(|f| f.rule == &rules::E0416).unwrap();
    let at = first.place.offset.unwrap() as usize;
    assert_eq!(bytes[at + 28], 9, "{first}");
}

/// What header and table do not prove is compared with nothing: differences from the model would only repeat the damage.
#[test]
fn a_source_is_compared_with_what_could_be_read_alone() {
    let accel = scenes::two_level_accel();
    let inputs = scenes::inputs();
    let source = Source { meshes: &accel.meshes, instances: Some(&accel.instances), inputs: &inputs, report: None };
    let told = |bytes: &[u8]| {
        let limits = Limits { max_issues: 1, ..Limits::default() };
        let report = check_bytes(bytes, Level::Source, Some(&source), &limits, &Executor::current());
        let ids: Vec<&str> = report.counts().map(|(rule, _)| rule.id).collect();
        (ids, report.not_checked)
    };
    let whole = valid::two_level_file();
    assert_eq!(told(&whole), (vec![], vec![]));

    // Without its flag the file seems to have no instances.
    let flagless = vectors_bytes::with_header(whole.clone(), |h| h.tree_flags &= !tree_flags::TWO_LEVEL);
    let (ids, left_out) = told(&flagless);
    assert!(ids.contains(&"E0125") && !ids.iter().any(|id| id.starts_with("E06")), "{ids:?}");
    assert!(left_out.iter().any(|why| why.starts_with("The source: ")), "{left_out:?}");

    // Rows out of order belong to no tree, and none of their triangles is looked for in the other tree's mesh.
    let mut mixed = whole;
    let rows = vectors_bytes::stored(&mut mixed, SectionKind::GEOM);
    let (first, last) = (rows[..64].to_vec(), rows[rows.len() - 64..].to_vec());
    let len = rows.len();
    rows[..64].copy_from_slice(&last);
    rows[len - 64..].copy_from_slice(&first);
    let (ids, left_out) = told(&vectors_bytes::refix(mixed));
    assert!(ids.contains(&"E0314") && !ids.iter().any(|id| id.starts_with("E06")), "{ids:?}");
    assert!(left_out.iter().any(|why| why.contains("GEOM")), "{left_out:?}");
}

/// What a frame shows does not follow from the file's length, so it is held against the limit before it is put together.
#[test]
fn a_frame_that_outgrows_the_limit_is_refused() {
    let bytes = sequences::crowd(200).file();
    let report = check_bytes(&bytes, Level::Tree, None, &Limits::default(), &Executor::current());
    assert!(report.is_clean(), "{}", lines(&report));
    assert!(bytes.len() < 80_000, "{}", bytes.len());
    let frame = |max_memory: u64| {
        let sequence = Sequence::from_slice(&bytes, &OpenOptions { max_memory, ..OpenOptions::default() }).unwrap();
        sequence.frame(0).map(|frame| frame.view().triangles.len())
    };
    assert!(matches!(frame(2 << 20), Err(CacheError::Limit { .. })));
    assert_eq!(frame(4 << 20).unwrap(), 200 * 255);
}

/// Agreement with a model is not asked of a sequence, and that is said.
#[test]
fn a_sequence_says_that_it_is_not_compared_with_a_model() {
    let bytes = sequences::refitted().file();
    let (meshes, inputs) = ([sequences::grid(2)], scenes::inputs());
    let source = Source { meshes: &meshes, instances: None, inputs: &inputs, report: None };
    let told = |level: Level| {
        let report = check_bytes(&bytes, level, Some(&source), &Limits::default(), &Executor::current());
        assert!(report.is_clean(), "{}", lines(&report));
        report.not_checked.len()
    };
    assert_eq!((told(Level::Tree), told(Level::Source)), (0, 1));
}

/// A sequence has several sections of a kind: which one is damaged is told.
#[test]
fn a_finding_names_the_section_s_number() {
    let mut bytes = sequences::refitted().file();
    let entries = vectors_bytes::entries(&bytes);
    let entry = entries.iter().find(|e| (e.kind, e.ordinal) == (SectionKind::VPOS, 1)).unwrap();
    bytes[entry.offset as usize + 3] ^= 1;
    let report = check_bytes(&bytes, Level::Hash, None, &Limits::default(), &Executor::current());
    let finding = report.findings.iter().find(|f| f.rule == &rules::E0201).unwrap();
    assert!(finding.to_string().contains(" VPOS 1 @"), "{finding}");

    // And which record of which section breaks a rule.
    let mut bent = sequences::refitted();
    bent.blocks[1].0[3].max[0] = f32::INFINITY;
    let report = check_bytes(&bent.file(), Level::Tree, None, &Limits::default(), &Executor::current());
    assert!(
        report.findings.iter().any(|f| f.to_string().contains(" NODE 1[3] (tree 1, record 3) @")),
        "{}",
        lines(&report)
    );
}

/// A section in a codec that is not known is one that this version cannot read, not one that is not there.
#[test]
fn an_unknown_codec_of_any_section_of_a_sequence_is_unsupported() {
    for kind in [SectionKind::FRAM, SectionKind::TOPO, SectionKind::POSE, SectionKind::GEOM, SectionKind::TRIX] {
        let codec = if kind == SectionKind::TRIX { 7 } else { SectionEntry::DELTA };
        let file = vectors_bytes::with_entry(sequences::refitted().file(), kind, |e| e.codec = codec);
        let report = check_bytes(&file, Level::Tree, None, &Limits::default(), &Executor::current());
        assert!(report.is_unsupported() && report.count(&rules::E0115) == 1, "{kind}: {}", lines(&report));
    }
}

/// Which of two zeros a union of boxes has is left to the machine.
#[test]
fn zeros_of_the_scene_s_bounds_have_no_sign() {
    let bytes = vectors_bytes::with_header(sequences::empty_frame().file(), |h| {
        assert_eq!(h.scene_min[2].to_bits(), 0);
        h.scene_min[2] = -0.0;
    });
    let report = check_bytes(&bytes, Level::Tree, None, &Limits::default(), &Executor::current());
    assert!(report.is_clean(), "{}", lines(&report));
}

/// The rows of BLAS are asked before sections are decoded and again with the records: one breach is counted once.
#[test]
fn contradictions_of_rows_are_counted_once() {
    let (header, mut sections) = vectors_bytes::take_apart(&valid::plane_file());
    // Provenance alone is packed, so that the records can be read whatever their rows say.
    let meta = sections.iter_mut().find(|(entry, _)| entry.kind == SectionKind::META).unwrap();
    let packed = bvhc::cache::parts::pack(&meta.1, 1, &Executor::current()).unwrap().expect("it gains");
    (meta.0.codec, meta.0.raw_len, meta.1) = (SectionEntry::ZSTD, meta.1.len() as u64, packed);
    let rows = sections.iter_mut().find(|(entry, _)| entry.kind == SectionKind::BLAS).unwrap();
    rows.1[32..40].copy_from_slice(&2u64.to_le_bytes());
    let bytes = vectors_bytes::put_together(header, sections);
    for level in [Level::Hash, Level::Tree] {
        let report = check_bytes(&bytes, level, None, &Limits::default(), &Executor::current());
        assert_eq!(report.count(&rules::E0310), 1, "{level:?}:{}", lines(&report));
    }
}

/// The report is the same for one thread and for several.
#[test]
fn reports_do_not_depend_on_threads() {
    let mut bytes = valid::packed();
    let mut dice = Dice(7);
    bytes = vectors_bytes::unpack(&bytes);
    let tris = vectors_bytes::stored(&mut bytes, bvhc::cache::SectionKind::TRIS);
    for _ in 0..500 {
        let at = dice.below(tris.len());
        tris[at] ^= 0x11;
    }
    let bytes = vectors_bytes::refix(bytes);
    let run = |threads: usize| {
        let exec = Executor::new(threads).unwrap();
        check_bytes(&bytes, Level::Tree, None, &Limits::default(), &exec).findings
    };
    let one = run(1);
    assert!(one.len() > 50);
    assert_eq!(one, run(3));
}
