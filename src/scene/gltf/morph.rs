//! Morph weights: which of them move something, found out once for each mesh and not for each node that shows it.

use super::document::Mesh;
use std::collections::BTreeMap;

/// What morph weights find in a mesh.
pub(super) struct Targets {
    /// For each weight whether it moves positions.
    moves: Vec<bool>,
    /// How many of the first weights find a target in every primitive.
    everywhere: usize,
}

impl Targets {
    pub fn of(mesh: &Mesh) -> Targets {
        let mut found = Targets { moves: Vec::new(), everywhere: usize::MAX };
        for primitive in mesh.primitives.iter().filter(|p| p.surface_positions().is_some()) {
            let targets = primitive.targets.as_deref().unwrap_or_default();
            found.everywhere = found.everywhere.min(targets.len());
            found.moves.resize(found.moves.len().max(targets.len()), false);
            for (moves, target) in found.moves.iter_mut().zip(targets) {
                *moves |= target.contains_key("POSITION");
            }
        }
        found
    }

    /// The weights that move something, without zeros at their end, and how many others than 0 find no target.
    pub fn weigh(&self, given: &[f64]) -> (Vec<f64>, u64) {
        let without = given.iter().skip(self.everywhere).filter(|w| **w != 0.0).count() as u64;
        let moving = given.iter().zip(&self.moves).map(|(w, moves)| if *moves { *w } else { 0.0 });
        let mut moving: Vec<f64> = moving.collect();
        let end = moving.iter().rposition(|w| *w != 0.0).map_or(0, |last| last + 1);
        moving.truncate(end);
        (moving, without)
    }
}

/// Lists of weights by numbers: equal lists have one. Number 0 is the empty list.
pub(super) struct WeightLists {
    lists: Vec<Vec<f64>>,
    /// By their bits.
    numbers: BTreeMap<Vec<u64>, u32>,
}

impl WeightLists {
    pub fn new() -> WeightLists {
        WeightLists { lists: vec![Vec::new()], numbers: BTreeMap::from([(Vec::new(), 0)]) }
    }

    /// The number of a list.
    pub fn number(&mut self, list: Vec<f64>) -> u32 {
        // A weight of -0 moves as little as one of 0.
        let bits = list.iter().map(|w| if *w == 0.0 { 0 } else { w.to_bits() }).collect();
        *self.numbers.entry(bits).or_insert_with(|| {
            self.lists.push(list);
            self.lists.len() as u32 - 1
        })
    }

    pub fn get(&self, number: u32) -> &[f64] {
        &self.lists[number as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mesh whose primitives have these targets: with positions, or without.
    fn mesh(primitives: &[&[bool]]) -> Mesh {
        let target = |moves: &bool| if *moves { "{\"POSITION\":1}" } else { "{\"NORMAL\":1}" };
        let primitive = |targets: &&[bool]| {
            let targets: Vec<&str> = targets.iter().map(target).collect();
            format!("{{\"attributes\":{{\"POSITION\":0}},\"targets\":[{}]}}", targets.join(","))
        };
        let primitives: Vec<String> = primitives.iter().map(primitive).collect();
        serde_json::from_str(&format!("{{\"primitives\":[{}]}}", primitives.join(","))).unwrap()
    }

    #[test]
    fn weights_move_what_one_primitive_has_and_miss_what_one_has_not() {
        let targets = Targets::of(&mesh(&[&[true, false, false, true], &[false, false, true]]));
        assert_eq!(targets.weigh(&[0.5, 1.0, 2.0, 3.0, 4.0]), (vec![0.5, 0.0, 2.0, 3.0], 2));
        assert_eq!(targets.weigh(&[0.0, 1.0]), (vec![], 0));
        assert_eq!(Targets::of(&mesh(&[])).weigh(&[1.0]), (vec![], 0));
        assert_eq!(Targets::of(&mesh(&[&[]])).weigh(&[1.0, 0.0]), (vec![], 1));
    }

    #[test]
    fn equal_lists_have_one_number() {
        let mut lists = WeightLists::new();
        let numbers = [vec![], vec![0.5], vec![0.0, 1.0], vec![-0.0, 1.0], vec![0.5]].map(|list| lists.number(list));
        assert_eq!(numbers, [0, 1, 2, 2, 1]);
        assert_eq!(lists.get(2), [0.0, 1.0]);
    }
}
