/// What a set of rays is after.
///
/// The numbers are part of a set's seed and never change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
#[non_exhaustive]
pub enum RaySet {
    /// Chords between two random points of a sphere around the scene.
    Uniform = 0,
    /// Along an axis, with zeros of both signs.
    Axis = 1,
    /// At a vertex, half of them exactly.
    Vertices = 2,
    /// At an edge, half of them exactly at its middle.
    Edges = 3,
    /// From a point of a triangle, cosine-weighted, starting on the surface itself.
    Surface = 4,
    /// The same, with `t_min` as renderers choose it.
    Bounce = 5,
    /// The same, ending at a tenth of the diagonal.
    Shadow = 6,
    /// Through the pixels of eight pinhole cameras.
    Camera = 7,
    /// Inside an axis-aligned plane through a vertex.
    Planes = 8,
    /// From deep inside, some of them short.
    Nested = 9,
    /// From up to 10⁷ diagonals away.
    Far = 10,
    /// From points of a lattice in directions of small whole numbers.
    Grid = 11,
    /// At a point inside a triangle, which [`Sampler::targets`](super::Sampler::targets) names.
    Triangles = 12,
}

impl RaySet {
    /// In the order in which help lists them.
    pub const ALL: [RaySet; 13] = [
        RaySet::Camera,
        RaySet::Uniform,
        RaySet::Surface,
        RaySet::Bounce,
        RaySet::Shadow,
        RaySet::Triangles,
        RaySet::Vertices,
        RaySet::Edges,
        RaySet::Axis,
        RaySet::Planes,
        RaySet::Nested,
        RaySet::Far,
        RaySet::Grid,
    ];

    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            RaySet::Camera => "camera",
            RaySet::Uniform => "uniform",
            RaySet::Surface => "surface",
            RaySet::Bounce => "bounce",
            RaySet::Shadow => "shadow",
            RaySet::Vertices => "vertices",
            RaySet::Edges => "edges",
            RaySet::Axis => "axis",
            RaySet::Planes => "planes",
            RaySet::Nested => "nested",
            RaySet::Far => "far",
            RaySet::Grid => "grid",
            RaySet::Triangles => "triangles",
        }
    }

    /// What it is, in a line of help.
    pub fn about(self) -> &'static str {
        match self {
            RaySet::Camera => "Through the pixels of eight pinhole cameras, half of them inside the scene",
            RaySet::Uniform => "Chords between two random points of a sphere around the scene",
            RaySet::Surface => "From a point of a triangle, cosine-weighted, starting on the surface itself",
            RaySet::Bounce => "The same, starting at 10⁻⁴ of the diagonal as a renderer's bounces do",
            RaySet::Shadow => "The same, ending at 10 % of the diagonal",
            RaySet::Triangles => "At a point inside a triangle, half of them from close by: nobody may look past it",
            RaySet::Vertices => "At a vertex, half of them exactly",
            RaySet::Edges => "At the middle of an edge, half of them exactly, or anywhere on it",
            RaySet::Axis => "Along an axis, with zeros of both signs, half of them through coordinates of vertices",
            RaySet::Planes => "Inside an axis-aligned plane through a vertex: faces of boxes, walls and floors",
            RaySet::Nested => "From deep inside: between vertices, at vertices and in the middle of boxes, some short",
            RaySet::Far => "From up to 10⁷ diagonals away",
            RaySet::Grid => "From points of a lattice in directions of small whole numbers",
        }
    }

    /// How many of `rays` rays each of `sets` gets: the same for all, but a hundredth for rays from far away, each of which meets most boxes of
    /// the scene.
    pub fn shares(sets: &[RaySet], rays: u64) -> Vec<u64> {
        let weight = |set: &RaySet| if *set == RaySet::Far { 1 } else { 100 };
        let all: u128 = sets.iter().map(weight).sum();
        let up_to = |weight: u128| (u128::from(rays) * weight / all.max(1)) as u64;
        let ends = sets.iter().scan(0, |sum, set| {
            *sum += weight(set);
            Some(*sum)
        });
        ends.zip(sets).map(|(end, set)| up_to(end) - up_to(end - weight(set))).collect()
    }

    /// The seed of this set's own sequence.
    pub(super) fn seed(self, seed: u64) -> u64 {
        seed ^ (self as u64) << 32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_and_the_far_get_little() {
        for rays in [0, 1, 13, 1_000_003] {
            let shares = RaySet::shares(&RaySet::ALL, rays);
            assert_eq!(shares.iter().sum::<u64>(), rays);
            let far = RaySet::ALL.iter().position(|s| *s == RaySet::Far).expect("it is among all");
            assert!(shares[far] <= rays / 1000, "{shares:?}");
            let (low, high) = (rays * 100 / 1201, rays * 100 / 1201 + 1);
            assert!(shares.iter().enumerate().all(|(i, s)| i == far || (low..=high).contains(s)), "{shares:?}");
        }
        assert_eq!(RaySet::shares(&[RaySet::Far], 7), [7]);
        assert!(RaySet::shares(&[], 7).is_empty());
    }

    #[test]
    fn names_and_numbers_are_distinct() {
        for (i, a) in RaySet::ALL.into_iter().enumerate() {
            for b in RaySet::ALL.into_iter().skip(i + 1) {
                assert!(a.name() != b.name() && a.about() != b.about() && a.seed(1) != b.seed(1));
            }
        }
    }
}
