use std::collections::BTreeMap;

/// What an animation makes of the nodes at one time. Whatever it does not name keeps what the file gives it.
#[derive(Debug, Default)]
pub struct Motion {
    nodes: BTreeMap<u32, Moved>,
}

/// What an animation makes of one node.
#[derive(Debug, Default)]
pub struct Moved {
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    /// Of the morph targets of the node's mesh.
    pub weights: Option<Vec<f64>>,
}

/// A property of nodes that a channel can move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
}

impl Path {
    pub fn parse(name: &str) -> Option<Path> {
        [Path::Translation, Path::Rotation, Path::Scale, Path::Weights].into_iter().find(|path| path.name() == name)
    }

    pub fn name(self) -> &'static str {
        match self {
            Path::Translation => "translation",
            Path::Rotation => "rotation",
            Path::Scale => "scale",
            Path::Weights => "weights",
        }
    }
}

impl Motion {
    pub fn of(&self, node: u32) -> Option<&Moved> {
        self.nodes.get(&node)
    }

    /// Note the value of a property: as many numbers as it has.
    pub fn set(&mut self, node: u32, path: Path, value: Vec<f64>) {
        let moved = self.nodes.entry(node).or_default();
        match path {
            Path::Translation => moved.translation = value.first_chunk().copied(),
            Path::Rotation => moved.rotation = value.first_chunk().copied(),
            Path::Scale => moved.scale = value.first_chunk().copied(),
            Path::Weights => moved.weights = Some(value),
        }
    }
}
