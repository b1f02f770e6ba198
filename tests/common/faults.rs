//! Mistakes planted in the records of a sound image, each as a builder, a writer or a disk might make it.
use bvhc::cache::{Image, TriangleRecord};
use bvhc::geom::Aabb;
use bvhc::tree::Node;
use std::collections::HashMap;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// An inner node's box loses half of its length.
    ShrunkBox,
    /// Two siblings exchange what they lead to, and keep their boxes.
    SwappedChildren,
    /// Two siblings exchange their boxes.
    SwappedBoxes,
    /// A corner of a large triangle moves inward.
    MovedVertex,
    /// A leaf forgets a triangle that stands in other leaves too.
    DroppedReference,
    /// The matrix that takes rays into an instance is off by a quarter of the mesh.
    WrongMatrix,
    /// A top-level box loses half of its length.
    ShrunkTopBox,
}

impl Fault {
    pub const ALL: [(&'static str, Fault); 7] = [
        ("box", Fault::ShrunkBox),
        ("children", Fault::SwappedChildren),
        ("boxes", Fault::SwappedBoxes),
        ("vertex", Fault::MovedVertex),
        ("reference", Fault::DroppedReference),
        ("matrix", Fault::WrongMatrix),
        ("top-box", Fault::ShrunkTopBox),
    ];
}

/// A fault that was planted: the records that may be blamed for it, by section.
#[derive(Clone, Debug, PartialEq)]
pub struct Planted {
    pub section: &'static str,
    pub records: Vec<u64>,
}

/// Plant a fault; `None` where the image has nothing that can be broken so.
pub fn plant(image: &mut Image, fault: Fault) -> Option<Planted> {
    match fault {
        Fault::ShrunkBox => {
            let node = inner(&image.nodes, 3)?;
            shrink(&mut image.nodes[node]);
            Some(Planted { section: "NODE", records: vec![node as u64] })
        }
        Fault::SwappedChildren => {
            let [a, b] = pair(&image.nodes)?;
            let (one, other) = (image.nodes[a], image.nodes[b]);
            (image.nodes[a].first, image.nodes[a].count) = (other.first, other.count);
            (image.nodes[b].first, image.nodes[b].count) = (one.first, one.count);
            Some(Planted { section: "NODE", records: vec![a as u64, b as u64] })
        }
        Fault::SwappedBoxes => {
            let [a, b] = pair(&image.nodes)?;
            let (one, other) = (image.nodes[a].bounds(), image.nodes[b].bounds());
            (image.nodes[a].min, image.nodes[a].max) = (other.min, other.max);
            (image.nodes[b].min, image.nodes[b].max) = (one.min, one.max);
            Some(Planted { section: "NODE", records: vec![a as u64, b as u64] })
        }
        Fault::MovedVertex => {
            let single = |t: &&(usize, &TriangleRecord)| t.1.flags & TriangleRecord::DUPLICATED == 0;
            let triangles: Vec<(usize, &TriangleRecord)> = image.triangles.iter().enumerate().collect();
            let (slot, _) = triangles.iter().filter(single).max_by(|a, b| area(a.1).total_cmp(&area(b.1)))?;
            let slot = *slot;
            let record = &mut image.triangles[slot];
            record.v0 = [0, 1, 2].map(|a| 0.5 * record.v0[a] + 0.25 * (record.v1[a] + record.v2[a]));
            Some(Planted { section: "TRIS", records: vec![slot as u64] })
        }
        Fault::DroppedReference => dropped_reference(image),
        Fault::WrongMatrix => {
            let width = image.blases.get(image.instances.first()?.blas as usize).map(|b| b.max[0] - b.min[0])?;
            image.instances[0].world_to_object[3] += 0.25 * width;
            Some(Planted { section: "INST", records: vec![0] })
        }
        Fault::ShrunkTopBox => {
            let node = inner(&image.tlas_nodes, 2)?;
            shrink(&mut image.tlas_nodes[node]);
            Some(Planted { section: "TNOD", records: vec![node as u64] })
        }
    }
}

/// An inner node at this depth below record 0, toward the first child where both are inner.
fn inner(nodes: &[Node], depth: usize) -> Option<usize> {
    let mut node = 0;
    for _ in 0..depth {
        let first = nodes.get(node)?.first as usize;
        node = [first, first + 1].into_iter().find(|&n| nodes.get(n).is_some_and(|n| !n.is_leaf()))?;
    }
    Some(node)
}

/// Two inner siblings whose boxes differ.
fn pair(nodes: &[Node]) -> Option<[usize; 2]> {
    let firsts = nodes.iter().filter(|n| !n.is_leaf()).map(|n| n.first as usize);
    let both_inner = |&a: &usize| a > 2 && nodes.get(a + 1).is_some_and(|b| !b.is_leaf() && !nodes[a].is_leaf());
    firsts.filter(both_inner).find(|&a| nodes[a].bounds() != nodes[a + 1].bounds()).map(|a| [a, a + 1])
}

fn shrink(node: &mut Node) {
    let extent = node.bounds().extent();
    let axis = (0..3).fold(0, |best, a| if extent[a] > extent[best] { a } else { best });
    node.max[axis] = node.min[axis] + 0.5 * extent[axis];
}

fn area(t: &TriangleRecord) -> f64 {
    let [a, b, c] = t.corners().map(|p| p.map(f64::from));
    let (e, f) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
    let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
    n.iter().map(|v| v * v).sum()
}

/// From the leaf of the first tree that alone holds the largest part of a duplicated triangle, and another one.
fn dropped_reference(image: &mut Image) -> Option<Planted> {
    let tree = image.blases.first()?;
    let (nodes, slots) =
        (tree.node_offset as usize..tree.node_offset as usize + tree.node_count as usize, tree.ref_offset);
    let slots_of = |n: &Node| (slots as usize + n.first as usize)..(slots as usize + (n.first + n.count) as usize);
    let leaves = || nodes.clone().filter(|&n| image.nodes[n].count > 0);
    let mut held = HashMap::<u32, Vec<usize>>::new();
    for leaf in leaves() {
        slots_of(&image.nodes[leaf]).for_each(|slot| held.entry(image.triangles[slot].prim).or_default().push(leaf));
    }
    let alone = |leaf: usize, slot: usize| {
        let triangle = &image.triangles[slot];
        let others: Vec<Aabb> =
            held[&triangle.prim].iter().filter(|&&n| n != leaf).map(|&n| image.nodes[n].bounds()).collect();
        let lost = |p: &[f32; 3]| {
            let point = Aabb { min: *p, max: *p };
            image.nodes[leaf].bounds().contains(&point) && !others.iter().any(|b| b.contains(&point))
        };
        area(triangle) * points(triangle).filter(lost).count() as f64
    };
    let shared = leaves().filter(|&leaf| image.nodes[leaf].count > 1);
    let candidates = shared.flat_map(|leaf| slots_of(&image.nodes[leaf]).map(move |slot| (leaf, slot)));
    let duplicated = candidates.filter(|(_, slot)| image.triangles[*slot].flags & TriangleRecord::DUPLICATED != 0);
    let weighed = duplicated.map(|(leaf, slot)| (leaf, slot, alone(leaf, slot)));
    let (leaf, slot, _) = weighed.filter(|w| w.2 > 0.0).max_by(|a, b| a.2.total_cmp(&b.2))?;
    let last = slots as usize + (image.nodes[leaf].first + image.nodes[leaf].count) as usize - 1;
    image.triangles.swap(slot, last);
    image.nodes[leaf].count -= 1;
    Some(Planted { section: "NODE", records: vec![leaf as u64] })
}

/// Points all over a triangle.
fn points(triangle: &TriangleRecord) -> impl Iterator<Item = [f32; 3]> {
    const STEPS: u8 = 16;
    let [a, b, c] = triangle.corners();
    let shares = (0..=STEPS).flat_map(|i| (0..=STEPS - i).map(move |j| [i, j, STEPS - i - j].map(f32::from)));
    shares.map(move |[i, j, k]| [0, 1, 2].map(|x| (a[x] * i + b[x] * j + c[x] * k) / f32::from(STEPS)))
}
