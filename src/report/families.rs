//! [`FamilyReport`]: what each family of rays pays in the trees of a file.

use crate::cache::View;
use crate::exec::Executor;
use crate::trace::probe::{Family, FamilyRays};
use serde::Serialize;

/// Neither the searches nor adaptation have rays from this seed: no tree was formed or chosen by the rays that are told here.
const SEED: u64 = 23;

/// What a ray of a family costs on average. Files of one scene are asked with the same rays.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FamilyReport {
    /// As [`Family::name`] has it.
    pub name: &'static str,
    /// How many rays.
    pub rays: u64,
    /// 1.2 · inner nodes + triangles a ray.
    pub cost: f64,
    /// Standard deviation of that over the rays.
    pub deviation: f64,
    /// Standard error of the mean, as if the rays were independent: what other rays of the family would most likely differ by. Eyes inside stand on the
    /// lines of few rays where little lies between surfaces, and differ by more then.
    pub standard_error: f64,
}

impl FamilyReport {
    /// Trace about `count` rays of each family; those families that have rays in this scene, in the order of [`Family::ALL`].
    pub fn of_view(view: &View<'_>, count: usize, exec: &Executor) -> Vec<FamilyReport> {
        let rays = FamilyRays::new(view, count, SEED, exec);
        if rays.is_empty() {
            return Vec::new(); // There is no surface that a ray could start from or meet.
        }
        let paid = rays.cost(view, exec);
        let of = |family: Family| {
            let (cost, deviation) = paid.spread(family)?;
            let rays = rays.len(family) as u64;
            let standard_error = deviation / (rays as f64).sqrt();
            Some(FamilyReport { name: family.name(), rays, cost, deviation, standard_error })
        };
        Family::ALL.into_iter().filter_map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress, Preset};
    use crate::cache::Image;
    use crate::compile::compile;
    use crate::scene::{ReadOptions, read};

    #[test]
    fn every_family_that_has_rays_is_told_with_what_chance_does_to_it() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/pillar.obj");
        let exec = Executor::sequential();
        let image = |preset| {
            let scene = read(&path, &ReadOptions::default()).unwrap();
            let accel = compile(scene, &BuildOptions::preset(preset), &exec, &NoProgress).unwrap();
            Image::new(&accel, &exec).unwrap()
        };
        let (draft, balanced) = (image(Preset::Draft), image(Preset::Balanced));
        let told = |image: &Image, count| FamilyReport::of_view(&image.view(), count, &exec);
        let (few, many) = (told(&draft, 512), told(&draft, 4096));
        assert!(many.len() >= 6, "{many:?}");
        for (few, many) in few.iter().zip(&many) {
            assert_eq!(few.name, many.name);
            // Both are means of the same: they differ by chance, which the errors tell. Six of them are one in a billion. Eyes inside are not
            // independent: there is little between the surfaces of a pillar, so that many stand on the same few lines.
            let most = 6.0 * (few.standard_error.powi(2) + many.standard_error.powi(2)).sqrt();
            assert!(few.name == "inside" || (few.cost - many.cost).abs() <= most, "{few:?} {many:?}");
            assert!(many.standard_error < few.standard_error && many.deviation > 0.0, "{few:?} {many:?}");
        }
        let names = |reports: &[FamilyReport]| reports.iter().map(|r| (r.name, r.rays)).collect::<Vec<_>>();
        assert_eq!(names(&many), names(&told(&balanced, 4096)), "the same rays for every tree");
        let all = |reports: &[FamilyReport]| reports.iter().map(|report| report.cost).sum::<f64>();
        assert!(all(&told(&balanced, 4096)) < all(&many));
        assert_eq!(many, FamilyReport::of_view(&draft.view(), 4096, &Executor::new(2).unwrap()));
        assert_eq!(FamilyReport::of_view(&Image::default().view(), 64, &exec), []);
    }
}
