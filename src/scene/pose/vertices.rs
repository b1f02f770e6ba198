use crate::geom::Affine;

/// The vertices of one run, a glTF primitive's, as they stand in the file, with all that can move them.
#[derive(Debug, Default)]
pub struct Vertices {
    pub positions: Vec<[f64; 3]>,
    pub targets: Vec<Target>,
    /// `None` where no joint holds them.
    pub influences: Option<Influences>,
}

/// A morph target: a displacement for each vertex.
#[derive(Debug)]
pub struct Target {
    /// Which of the weights it takes.
    pub weight: usize,
    pub displacements: Vec<[f64; 3]>,
}

/// Which joints hold each vertex, and how much.
#[derive(Debug)]
pub struct Influences {
    per_vertex: usize,
    joints: Vec<u32>,
    /// Those of a vertex sum to 1, up to rounding.
    weights: Vec<f64>,
    /// Vertices whose weights were all zero.
    pub unweighted: u64,
}

/// What places the vertices.
#[derive(Clone, Copy)]
pub enum Place<'a> {
    /// Nothing: they stay in the mesh's own space.
    Mesh,
    /// In world space: the joints, or for vertices that no joint holds the node. A joint's transform leads from the mesh's own space through
    /// the joint's (its inverse bind matrix) to world space.
    World { joints: &'a [Affine], node: &'a Affine },
}

impl Influences {
    /// From `per_vertex` joints and weights for each vertex, in the order of the vertices.
    ///
    /// Weights are divided by their sum: files whose weights do not sum to 1 are common, and viewers do so. A vertex whose weights are
    /// all zero, which is not valid and means another thing to each viewer, follows its first joint, so that it stays with the mesh.
    pub fn new(per_vertex: usize, joints: Vec<u32>, mut weights: Vec<f64>) -> Influences {
        let mut unweighted = 0;
        for of_vertex in weights.chunks_exact_mut(per_vertex.max(1)) {
            if of_vertex.iter().all(|w| *w == 0.0) {
                of_vertex[0] = 1.0;
                unweighted += 1;
            }
            let sum: f64 = of_vertex.iter().sum();
            of_vertex.iter_mut().for_each(|w| *w /= sum);
        }
        Influences { per_vertex, joints, weights, unweighted }
    }

    /// The joints and weights that move vertex `v`; joints of weight 0 are not among them.
    fn of(&self, v: usize) -> impl Iterator<Item = (u32, f64)> {
        let run = v * self.per_vertex..(v + 1) * self.per_vertex;
        let pairs = self.joints[run.clone()].iter().copied().zip(self.weights[run].iter().copied());
        pairs.filter(|(_, weight)| *weight != 0.0)
    }

    /// The largest joint number that moves a vertex.
    pub fn largest_joint(&self) -> Option<u32> {
        let used = self.joints.iter().zip(&self.weights).filter(|(_, weight)| **weight != 0.0);
        used.map(|(joint, _)| *joint).max()
    }
}

impl Vertices {
    /// Where the vertices stand: displaced by their targets times `weights`, then placed. A weight that is not given is 0.
    ///
    /// # Panics
    ///
    /// If a vertex has a joint of weight above 0 that `place` has no transform for; see [`Influences::largest_joint`].
    pub fn posed(&self, weights: &[f64], place: Place) -> Vec<[f64; 3]> {
        let active: Vec<(&Target, f64)> = self
            .targets
            .iter()
            .map(|t| (t, weights.get(t.weight).copied().unwrap_or(0.0)))
            .filter(|t| t.1 != 0.0)
            .collect();
        let pose = |(v, position): (usize, &[f64; 3])| {
            let mut p = *position;
            for (target, weight) in &active {
                (0..3).for_each(|k| p[k] += weight * target.displacements[v][k]);
            }
            match (place, &self.influences) {
                (Place::Mesh, _) => p,
                (Place::World { node, .. }, None) => node.transform_point(p),
                (Place::World { joints, .. }, Some(influences)) => {
                    let mut sum = [0.0; 3];
                    for (joint, weight) in influences.of(v) {
                        let moved = joints[joint as usize].transform_point(p);
                        (0..3).for_each(|k| sum[k] += weight * moved[k]);
                    }
                    sum
                }
            }
        };
        self.positions.iter().enumerate().map(pose).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(x: f64) -> Affine {
        Affine { rows: [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] }
    }

    fn vertices() -> Vertices {
        let weights = vec![0.25, 0.25, 0.0, 0.0, 0.0, 4.0];
        Vertices {
            positions: vec![[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]],
            targets: vec![Target { weight: 1, displacements: vec![[0.0, 1.0, 0.0]; 3] }],
            influences: Some(Influences::new(2, vec![0, 1, 1, 0, 9, 1], weights)),
        }
    }

    #[test]
    fn weights_are_divided_by_their_sum_and_none_means_the_first_joint() {
        let vertices = vertices();
        let influences = vertices.influences.as_ref().unwrap();
        assert_eq!((influences.unweighted, influences.largest_joint()), (1, Some(1)));
        let (joints, node) = ([moved(10.0), moved(30.0)], moved(1e6));
        let posed = vertices.posed(&[], Place::World { joints: &joints, node: &node });
        assert_eq!(posed, [[21.0, 0.0, 0.0], [32.0, 0.0, 0.0], [33.0, 0.0, 0.0]]);
    }

    #[test]
    fn displacements_come_before_the_joints_and_by_their_own_weight() {
        let turn = Affine { rows: [[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]] };
        let place = Place::World { joints: &[turn, turn], node: &moved(1e6) };
        assert_eq!(vertices().posed(&[7.0, 2.0], place)[0], [-2.0, 1.0, 0.0]);
        assert_eq!(vertices().posed(&[7.0, 2.0], Place::Mesh)[2], [3.0, 2.0, 0.0]);
    }

    #[test]
    fn vertices_that_no_joint_holds_are_placed_by_the_node() {
        let rigid = Vertices { influences: None, ..vertices() };
        let place = Place::World { joints: &[], node: &moved(100.0) };
        assert_eq!(rigid.posed(&[0.0, 1.0], place)[0], [101.0, 1.0, 0.0]);
    }
}
