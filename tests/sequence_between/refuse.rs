//! What has nothing between its frames, and records that are not what they should be.

use super::common::vectors::sequences as vectors;
use super::open;
use bvhc::cache::check::{Level, Limits, check_bytes};
use bvhc::cache::{CacheError, ErrorKind, OpenOptions, SectionKind, Sequence, Unlike, Validation};
use bvhc::exec::Executor;
use bvhc::geom::Ray;
use bvhc::random::Random;
use bvhc::trace::closest_hit;

#[test]
fn frames_that_do_not_show_the_same_have_nothing_between() {
    let bytes = vectors::rebuilt().file();
    let sequence = open(&bytes, Validation::Tree);
    let refusal = |first, second| match sequence.between(first, second) {
        Err(error) => error,
        Ok(between) => panic!("{between:?}"),
    };
    let error = refusal(0, 1);
    let counts = Unlike::Instances { counts: [2, 3] };
    assert!(matches!(&error, CacheError::Unlike { frames: [0, 1], what } if *what == counts), "{error:?}");
    assert_eq!(
        error.to_string(),
        "cannot interpolate frames 0 and 1, counted from 0: the one has 2 instances, the other 3, and each needs its like"
    );
    let error = refusal(2, 0);
    let other = Unlike::Topology { instance: 0, topologies: [2, 0] };
    assert!(matches!(&error, CacheError::Unlike { frames: [2, 0], what } if *what == other), "{error:?}");
    assert_eq!(
        error.to_string(),
        "cannot interpolate frames 2 and 0, counted from 0: instance 0 shows topology 2 in the one and 0 in the other, \
         and only poses of one topology can be interpolated"
    );
    assert_eq!(error.kind(), ErrorKind::Frames);
    assert!(matches!(refusal(0, 3), CacheError::NoFrame { frame: 3, frames: 3 }));
    assert!(sequence.between(1, 1).is_ok());

    // An empty frame has its like in an empty one.
    let bytes = vectors::empty_frame().file();
    let sequence = open(&bytes, Validation::Tree);
    assert!(matches!(sequence.between(0, 1), Err(CacheError::Unlike { .. })));
    let nothing = sequence.between(0, 0).unwrap();
    assert_eq!(nothing.closest_hit(&Ray::new([0.5, 0.5, -9.0], [0.0, 0.0, 1.0]), 0.5), Ok(None));
}

/// Whatever stands in the records, opening and tracing end, at every level.
#[test]
fn damaged_records_between_frames_end_in_an_error_or_a_bounded_walk() {
    let sound = vectors::refitted().file();
    let mut random = Random::new(13);
    let mut opened = 0;
    for round in 0..1500u32 {
        let values = [0, 1, 2, 3, 255, 256, u32::MAX, 0x7f80_0000, 0x7fc0_0000, 0xff7f_ffff, random.bits() as u32];
        let value = values[random.below(11) as usize];
        let word = random.bits() as usize;
        let edit = |words: &mut Vec<u32>| {
            let at = word % words.len();
            words[at] = value;
        };
        let (kind, ordinal) = [
            (SectionKind::NODE, 0),
            (SectionKind::NODE, 1),
            (SectionKind::VPOS, 1),
            (SectionKind::TRIX, 0),
            (SectionKind::TNOD, 0),
            (SectionKind::INST, 0),
            (SectionKind::INST, 1),
            (SectionKind::TOPO, 0),
        ][round as usize % 8];
        let bytes = vectors::with_section_of(&sound, kind, ordinal, edit);
        for validation in [Validation::Quick, Validation::Hash, Validation::Tree] {
            let options = OpenOptions { validation, max_memory: 1 << 20, ..OpenOptions::default() };
            let Ok(sequence) = Sequence::from_slice(&bytes, &options) else { continue };
            for (first, second) in [(0, 1), (1, 0)] {
                let Ok(between) = sequence.between(first, second) else { continue };
                opened += 1;
                for ray in 0..6 {
                    let ray = Ray::new([0.3 * ray as f32, 0.7, -4.0], [0.01 * ray as f32, 0.02, 1.0]);
                    for fraction in [0.0, 0.37, 1.0] {
                        let hit = between.closest_hit(&ray, fraction);
                        let any = between.any_hit(&ray, fraction);
                        assert!(validation < Validation::Tree || hit.is_ok() && any.is_ok(), "{kind} {hit:?}");
                        if let Ok(Some(hit)) = hit {
                            _ = between.normal(&hit, fraction);
                        }
                    }
                }
            }
        }
    }
    assert!(opened > 1000, "{opened}");
}

/// Numbers of instances that stand there twice cannot be matched, and shapes that differ are found where records are checked.
#[test]
fn what_cannot_be_matched_is_told_by_its_rule() {
    let mut sequence = vectors::rebuilt();
    sequence.placements[0].1[1].id = sequence.placements[0].1[0].id;
    let bytes = sequence.file();
    let error = open(&bytes, Validation::Hash).between(0, 0).unwrap_err();
    assert_eq!(error.rule(), Some("E0504"), "{error}");
    assert!(error.to_string().contains("frames 0 and 0"), "{error}");

    // Two leaves beside each other exchange a triangle: each frame by itself is sound.
    let mut sequence = vectors::large();
    let corners: Vec<[u32; 3]> = sequence.triangles.iter().map(|triangle| triangle.corners).collect();
    let (nodes, vertices) = &mut sequence.blocks[1];
    let leaves = |pair: &usize| nodes[*pair].count > 1 && nodes[pair + 1].count > 0;
    let pair = (2..nodes.len()).step_by(2).find(leaves).unwrap();
    nodes[pair].count -= 1;
    nodes[pair + 1].count += 1;
    nodes[pair + 1].first -= 1;
    bvhc::tree::refit(nodes, |slot| corners[slot].map(|v| vertices[v as usize])).unwrap();
    sequence.restate_sah();
    let bytes = sequence.file();
    let report = check_bytes(&bytes, Level::Tree, None, &Limits::default(), &Executor::sequential());
    assert!(!report.is_valid() && report.findings.iter().all(|f| f.rule.id == "E0705"), "{:?}", report.findings);
    assert!(open(&bytes, Validation::Hash).between(0, 1).is_ok());
    let sequence = open(&bytes, Validation::Tree);
    assert!(sequence.frame(1).is_ok() && sequence.between(0, 2).is_ok());
    let error = sequence.between(0, 1).unwrap_err();
    assert_eq!(error.rule(), Some("E0705"), "{error}");
}

/// At a frame's own time the other frame has no say, whatever stands in it.
#[test]
fn at_its_own_time_a_frame_does_not_depend_on_the_other() {
    let sound = vectors::refitted().file();
    let nowhere = |words: &mut Vec<u32>| words.fill(f32::NAN.to_bits());
    let bytes = vectors::with_section_of(&sound, SectionKind::VPOS, 1, nowhere);
    let sequence = open(&bytes, Validation::Hash);
    let (between, frame) = (sequence.between(0, 1).unwrap(), sequence.frame(0).unwrap());
    let mut hits = 0;
    for i in 0..100 {
        let ray = Ray::new([0.021 * i as f32, 0.017 * i as f32, -4.0], [0.001, 0.002, 1.0]);
        let got = between.closest_hit(&ray, 0.0).unwrap();
        assert_eq!(got, closest_hit(&frame.view(), &ray).unwrap());
        hits += usize::from(got.is_some());
        assert_eq!(between.any_hit(&ray, 0.5), Ok(false));
    }
    assert!(hits > 50, "{hits}");
}
