//! The reader stops at the first broken rule, the checker collects them all: both go one walk, and must come to the same.

use bvhc::cache::check::{Finding, Level, Limits, Report, check_bytes};
use bvhc::cache::{
    Cache, CacheError, Codec, OpenOptions, SectionKind, Validation, WriteOptions, section_flags, to_bytes,
};
use bvhc::exec::Executor;
use bvhc::geom::Ray;
use proptest::prelude::*;

use crate::images::{meta, one_triangle, two_instances};
use crate::refuse::sign;

/// Rules about provenance and numbers for people: the reader lets such files be traced.
const NOT_FOR_TRAVERSAL: [&str; 6] = ["E0206", "E0207", "E0208", "E0210", "E0320", "E0204"];

fn compare(file: &[u8]) -> Result<(), TestCaseError> {
    for (validation, level) in
        [(Validation::Quick, Level::Quick), (Validation::Hash, Level::Hash), (Validation::Tree, Level::Tree)]
    {
        let opened = Cache::from_bytes(file, &OpenOptions { validation, ..OpenOptions::default() });
        let report: Report = check_bytes(file, level, None, &Limits::default(), &Executor::current());
        // Nor does it need a section that may be ignored: one that was written so that it cannot be decoded is left alone.
        let ignored = |f: &&Finding| {
            let optional = |kind: SectionKind| kind.rule().is_none_or(|r| r.flags & section_flags::CRITICAL == 0);
            ["E0202", "E0205"].contains(&f.rule.id) && f.place.section.is_some_and(optional)
        };
        let needed = report.findings.iter().filter(|f| !ignored(f)).map(|f| f.rule.id);
        let broken: Vec<&str> = needed.filter(|id| id.starts_with('E')).collect();
        match &opened {
            // Whatever the reader refuses, the checker finds at its depth: the reader decodes META and packed sections at every level.
            Err(error) => {
                let deeper = check_bytes(file, Level::Tree, None, &Limits::default(), &Executor::current());
                prop_assert!(!deeper.is_valid(), "{level:?}: {error}");
                // And says the same of it.
                if let CacheError::Invalid { breach, .. } | CacheError::Unsupported { breach, .. } = error {
                    let same = |f: &Finding| {
                        let values = |f: &Finding| (f.rule.id, f.place.section, f.expected.clone(), f.actual.clone());
                        values(f) == values(breach)
                    };
                    prop_assert!(deeper.findings.iter().any(same), "{error}\n{:#?}", deeper.findings);
                }
            }
            // What the checker finds beyond, traversal does not need.
            Ok(_) => prop_assert!(
                broken.iter().all(|id| NOT_FOR_TRAVERSAL.contains(id)),
                "{level:?}: the reader opens a file with {broken:?}"
            ),
        }
        // Whatever was opened can be traced: an answer or an error, but an end.
        if let Ok(cache) = opened {
            for ray in [Ray::new([0.2, 0.2, -1.0], [0.0, 0.0, 1.0]), Ray::new([9.0, 9.0, 9.0], [-1.0, -1.0, -1.0])] {
                _ = cache.closest_hit(&ray);
                _ = cache.any_hit(&ray);
            }
            (0..cache.names().len().min(10)).for_each(|i| _ = cache.names().get(i));
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(3000) })]

    #[test]
    fn reader_and_checker_agree_on_damaged_files(
        two_level in any::<bool>(),
        zstd in any::<bool>(),
        signed in prop::bool::weighted(0.8),
        hits in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>(), any::<bool>()), 1..4),
    ) {
        let image = if two_level { two_instances() } else { one_triangle() };
        let codec = if zstd { Codec::Zstd { level: 1 } } else { Codec::Raw };
        let mut file = to_bytes(&image, &meta(), &WriteOptions { codec, ..WriteOptions::default() }, &Executor::current()).unwrap();
        let (len, table_end) = (file.len(), 256 + 128 * 6);
        for (index, value, in_front) in hits {
            let at = index.index(if in_front { table_end } else { len });
            file[at] = value;
        }
        if signed {
            sign(&mut file);
        }
        compare(&file)?;
    }
}
