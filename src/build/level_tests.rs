use super::sweep::tests::samples;
use super::{BuildOptions, METHODS, Method, NoProgress, Preset, initial_tree};
use crate::exec::Executor;
use crate::simd::{Level, at_most};

#[test]
fn the_level_of_vectors_changes_no_tree() {
    let exec = Executor::sequential();
    for (name, mesh) in samples() {
        for method in METHODS.iter().map(|row| row.method).filter(|method| !method.is_search()) {
            for radius in [1, 14, 31] {
                let options = BuildOptions { method, radius, ..BuildOptions::preset(Preset::Draft) };
                let build = || initial_tree(&mesh, &options, &exec, &NoProgress).unwrap();
                let (wide, narrow) = (build(), at_most(Level::BASE, build));
                assert!(wide == narrow, "{name} by {method:?} with radius {radius}");
                if method != Method::Agglomerative {
                    break;
                }
            }
        }
    }
}
