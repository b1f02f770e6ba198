use std::collections::BTreeSet;

/// What of a file an animation can move in the scene that is read.
#[derive(Debug)]
pub struct Scope {
    /// By node: whether a mesh or a joint is at it or below.
    carries: Vec<bool>,
    meshes: BTreeSet<u32>,
}

impl Scope {
    /// `carries` says of each node whether a mesh or a joint of the scene is at it or below; `meshes` are those at such nodes.
    pub fn new(carries: Vec<bool>, meshes: BTreeSet<u32>) -> Scope {
        Scope { carries, meshes }
    }

    /// Whether moving a node moves something of the scene.
    pub fn carries(&self, node: u32) -> bool {
        self.carries.get(node as usize) == Some(&true)
    }

    /// Whether a mesh stands in the scene.
    pub fn shows(&self, mesh: u32) -> bool {
        self.meshes.contains(&mesh)
    }
}
