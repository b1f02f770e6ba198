use super::accessor::{self, Shape};
use super::document::Primitive;
use super::reader::Reader;
use super::whole::Index;
use crate::scene::SceneError;
use crate::scene::pose::{Influences, Target, Vertices};
use std::collections::BTreeMap;

/// The accessors of a primitive's vertices: equal ones mean equal vertices.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Attributes {
    pub positions: usize,
    /// Each target's weight and displacements.
    targets: Vec<(usize, usize)>,
    /// Each set's joints and weights.
    influences: Vec<(usize, usize)>,
}

impl Attributes {
    /// What a pose with these morph weights, and perhaps a skin, needs of a primitive that has positions.
    pub fn new(primitive: &Primitive, positions: usize, weights: &[f64], is_skinned: bool) -> Attributes {
        let targets = primitive.targets.iter().flatten().enumerate();
        let moves = |(i, target): (usize, &BTreeMap<String, Index>)| {
            let is_active = weights.get(i).is_some_and(|w| *w != 0.0);
            target.get("POSITION").filter(|_| is_active).map(|accessor| (i, accessor.0 as usize))
        };
        let influences = if is_skinned { influences(primitive) } else { Vec::new() };
        Attributes { positions, targets: targets.filter_map(moves).collect(), influences }
    }

    /// Read them. `joints` is how many the skin has; `place` names the primitive. Memory is charged and stays charged.
    pub fn read(&self, reader: &mut Reader, joints: usize, place: &str) -> Result<Vertices, SceneError> {
        let path = reader.source.path;
        let malformed = |what: String| SceneError::malformed(path, format!("{place} {what}"));
        let count = accessor::count(reader, self.positions)?;
        let others = self.targets.iter().map(|t| t.1).chain(self.influences.iter().flat_map(|i| [i.0, i.1]));
        for accessor in others {
            let other = accessor::count(reader, accessor)?;
            if other != count {
                let what = format!("has {count} positions, but {other} elements in accessor {accessor}");
                return Err(malformed(what));
            }
        }
        let read3 = |accessor, reader: &mut Reader| accessor::numbers::<3>(reader, accessor, Shape::POSITIONS);
        let positions = read3(self.positions, reader)?;
        let mut targets = Vec::with_capacity(self.targets.len());
        for &(weight, accessor) in &self.targets {
            targets.push(Target { weight, displacements: read3(accessor, reader)? });
        }
        if self.influences.is_empty() {
            return Ok(Vertices { positions, targets, influences: None });
        }

        // Lay the sets of each vertex side by side.
        let per_vertex = 4 * self.influences.len();
        let of_all = (positions.len() * per_vertex) as u64;
        reader.source.charge(of_all * (size_of::<u32>() + size_of::<f64>()) as u64, "the joint weights")?;
        let (mut numbers, mut weights) =
            (vec![0; positions.len() * per_vertex], vec![0.0; positions.len() * per_vertex]);
        for (set, &(joints_accessor, weights_accessor)) in self.influences.iter().enumerate() {
            let of_set = accessor::joints(reader, joints_accessor)?;
            for (place, four) in numbers.chunks_exact_mut(per_vertex).zip(of_set) {
                place[4 * set..4 * set + 4].copy_from_slice(&four);
            }
            let of_set = accessor::fractions::<4>(reader, weights_accessor, Shape::WEIGHTS)?;
            for (place, four) in weights.chunks_exact_mut(per_vertex).zip(of_set) {
                place[4 * set..4 * set + 4].copy_from_slice(&four);
            }
        }
        let influences = Influences::new(per_vertex, numbers, weights);
        match influences.largest_joint() {
            Some(joint) if joint as usize >= joints => {
                Err(malformed(format!("uses joint {joint}, but its skin has {joints}")))
            }
            _ => Ok(Vertices { positions, targets, influences: Some(influences) }),
        }
    }
}

/// Every set of joints and weights that a primitive has, from set 0 on.
pub(super) fn influences(primitive: &Primitive) -> Vec<(usize, usize)> {
    let set =
        |n: usize| Some((primitive.attribute(&format!("JOINTS_{n}"))?, primitive.attribute(&format!("WEIGHTS_{n}"))?));
    (0..).map_while(set).collect()
}
