use super::animation::{Motion, Moved};
use super::document::{Document, Node};
use super::extensions::VISIBILITY;
use crate::geom::Affine;
use crate::scene::SceneError;
use crate::scene::pose::Hierarchy;
use crate::scene::source::Source;

/// What a scene shows, apart from where its nodes stand.
pub(super) struct Layout {
    /// The nodes of the scene, and later those that joints need.
    pub hierarchy: Hierarchy,
    /// The nodes that show a mesh, in depth-first order.
    pub shown: Vec<Shown>,
    /// Nodes with a mesh that are hidden.
    pub hidden: u64,
    /// Nodes with a matrix and with translation, rotation or scale beside it.
    pub placed_twice: u64,
}

/// A node that shows a mesh.
#[derive(Clone, Copy)]
pub(super) struct Shown {
    pub node: u32,
    pub mesh: u32,
    pub skin: Option<u32>,
}

/// Walk the scene that is asked for.
pub(super) fn layout(document: &Document, source: &mut Source) -> Result<Layout, SceneError> {
    let mut layout =
        Layout { hierarchy: Hierarchy::new(document.nodes.len()), shown: Vec::new(), hidden: 0, placed_twice: 0 };
    let honours_visibility = !source.options.ignores(VISIBILITY);
    let roots = roots(document, source)?;
    let mut stack: Vec<(u32, Option<u32>, bool)> = roots.into_iter().rev().map(|root| (root, None, true)).collect();

    // Walk with a stack of our own, so that no depth of nesting can exhaust the thread's. Each node is reached at most
    // once, so this ends.
    while let Some((index, parent, is_visible)) = stack.pop() {
        let node = get(document, index, "the scene or a node", source)?;
        if !layout.hierarchy.add(index, parent) {
            let reason = format!("node {index} is reached twice; a node has one parent and is not its own descendant");
            return Err(SceneError::malformed(source.path, reason));
        }
        let has_parts = node.translation.is_some() || node.rotation.is_some() || node.scale.is_some();
        layout.placed_twice += u64::from(node.matrix.is_some() && has_parts);
        let is_visible = is_visible && !(honours_visibility && is_hidden(node));
        if let Some(mesh) = node.mesh.map(|m| m.0) {
            if mesh as usize >= document.meshes.len() {
                let reason = format!("node {index} shows mesh {mesh}, but there are {}", document.meshes.len());
                return Err(SceneError::malformed(source.path, reason));
            }
            if is_visible {
                layout.shown.push(Shown { node: index, mesh, skin: node.skin.map(|s| s.0) });
            } else {
                layout.hidden += 1;
            }
        }
        stack.extend(node.children.iter().flatten().rev().map(|child| (child.0, Some(index), is_visible)));
    }
    Ok(layout)
}

fn is_hidden(node: &Node) -> bool {
    let visibility = node.extensions.as_ref().and_then(|e| e.visibility.as_ref());
    visibility.is_some_and(|v| v.visible == Some(false))
}

fn get<'d>(document: &'d Document, index: u32, who: &str, source: &Source) -> Result<&'d Node, SceneError> {
    document.nodes.get(index as usize).ok_or_else(|| {
        let count = document.nodes.len();
        SceneError::malformed(source.path, format!("{who} names node {index}, but there are {count}"))
    })
}

/// The nodes to start from: those of the scene asked for, else of the default scene, else of the first; without scenes, the
/// nodes that are nobody's child.
fn roots(document: &Document, source: &Source) -> Result<Vec<u32>, SceneError> {
    let count = document.scenes.len();
    let chosen = match (source.options.scene, document.scene.map(|s| s.0)) {
        (Some(asked), _) if asked as usize >= count => {
            let path = source.path.to_owned();
            return Err(SceneError::NoSuchScene { path, asked, count: count as u64 });
        }
        (Some(asked), _) => asked,
        (None, Some(default)) if default as usize >= count => {
            let reason = format!("its default scene is {default}, but it has {count}");
            return Err(SceneError::malformed(source.path, reason));
        }
        (None, default) => default.unwrap_or(0),
    };
    if let Some(scene) = document.scenes.get(chosen as usize) {
        return Ok(scene.nodes.iter().map(|n| n.0).collect());
    }
    let parents = parents(document);
    Ok((0..document.nodes.len() as u32).filter(|n| parents[*n as usize].is_none()).collect())
}

/// Each node's parent, the first that names it.
fn parents(document: &Document) -> Vec<Option<u32>> {
    let mut parents = vec![None; document.nodes.len()];
    for (index, node) in document.nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            if let Some(parent) = parents.get_mut(child.0 as usize) {
                parent.get_or_insert(index as u32);
            }
        }
    }
    parents
}

/// Make sure that the hierarchy has `joints` and all above them. They should be nodes of the scene that shows the skin, but files
/// exist where some are not.
pub(super) fn reach(
    document: &Document,
    joints: &[u32],
    hierarchy: &mut Hierarchy,
    source: &Source,
) -> Result<(), SceneError> {
    if joints.iter().all(|j| hierarchy.contains(*j)) {
        return Ok(());
    }
    let parents = parents(document);
    for joint in joints {
        // Climb to the first node that is there already, or to a root, and come back down.
        let mut way = vec![*joint];
        while let Some(last) = way.last().filter(|last| !hierarchy.contains(**last)) {
            get(document, *last, "a skin", source)?;
            if way.len() > document.nodes.len() {
                let reason = format!("node {joint} is its own descendant");
                return Err(SceneError::malformed(source.path, reason));
            }
            match parents[*last as usize] {
                Some(parent) => way.push(parent),
                None => break,
            }
        }
        while let Some(node) = way.pop() {
            hierarchy.add(node, way_parent(&parents, node));
        }
    }
    Ok(())
}

fn way_parent(parents: &[Option<u32>], node: u32) -> Option<u32> {
    parents.get(node as usize).copied().flatten()
}

/// The own transforms of a hierarchy's nodes, moved by an animation or at rest, by node number; identities for nodes outside of it.
pub(super) fn own_transforms(
    document: &Document,
    hierarchy: &Hierarchy,
    motion: &Motion,
    source: &mut Source,
) -> Result<Vec<Affine>, SceneError> {
    source.charge((document.nodes.len() * size_of::<Affine>()) as u64, "the nodes' transforms")?;
    let mut own = vec![Affine::IDENTITY; document.nodes.len()];
    for node in hierarchy.nodes() {
        own[node as usize] = local_transform(&document.nodes[node as usize], node, motion.of(node), source)?;
    }
    Ok(own)
}

/// A node's own transform: its matrix, or else translation · rotation · scale, each as an animation has it or else the node.
fn local_transform(node: &Node, index: u32, moved: Option<&Moved>, source: &Source) -> Result<Affine, SceneError> {
    if let Some(m) = &node.matrix {
        let what = format!("the matrix of node {index}");
        return affine(m, 1e-6, &what, source);
    }
    let translation = moved.and_then(|m| m.translation).or(node.translation).unwrap_or([0.0; 3]);
    let rotation = moved.and_then(|m| m.rotation).or(node.rotation).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = moved.and_then(|m| m.scale).or(node.scale).unwrap_or([1.0; 3]);
    Ok(compose(translation, rotation, scale))
}

/// A column-major 4×4 matrix whose last row is 0 0 0 1, up to what exporters' arithmetic leaves of it.
pub(super) fn affine(m: &[f64; 16], slack: f64, what: &str, source: &Source) -> Result<Affine, SceneError> {
    let column = |c: usize| [0, 1, 2, 3].map(|r| m[c * 4 + r]);
    let last_row = [0, 1, 2, 3].map(|c| m[c * 4 + 3]);
    let is_affine = last_row.iter().zip([0.0, 0.0, 0.0, 1.0]).all(|(v, want)| (v - want).abs() < slack);
    if !is_affine {
        let reason = format!("{what} has the last row {last_row:?}; it must be 0 0 0 1");
        return Err(SceneError::malformed(source.path, reason));
    }
    Ok(Affine::from_columns([column(0), column(1), column(2), column(3)]))
}

/// Translation · rotation · scale. The quaternion is brought to unit length, since its numbers never quite have it; one without
/// length rotates nothing.
pub(super) fn compose(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Affine {
    let [x, y, z, w] = rotation;
    let norm = x * x + y * y + z * z + w * w;
    let s = if norm > 0.0 { 2.0 / norm } else { 0.0 };
    let turn = [
        [1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
        [s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w)],
        [s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)],
    ];
    let [sx, sy, sz] = scale;
    let row = |r: usize| [turn[r][0] * sx, turn[r][1] * sy, turn[r][2] * sz, translation[r]];
    Affine { rows: [row(0), row(1), row(2)] }
}
