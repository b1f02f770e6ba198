//! The top level: one tree over instance boxes, one instance a leaf, by agglomerative clustering.
//!
//! Clusters are merged in pairs that are each other's best match, "best" being the smallest area of the common box (Walter,
//! Bala, Kulkarni and Pingali, "Fast Agglomerative Clustering for Rendering", 2008: the heapless form). The search for a
//! mutual pair walks a chain of best matches; the merged cluster goes back among the candidates and the walk continues
//! from what is left of the chain, so a cluster is asked for its best match about three times in all.

mod balance;

use crate::exec::Executor;
use crate::geom::Aabb;
use crate::tree::{MAX_DEPTH, Node, Tree};

/// Up to this many clusters are agglomerated as they are, which costs about 1.5·n² box unions.
const EXACT_LIMIT: usize = 4096;
/// Above the limit, clusters are first agglomerated in spatial groups of at most this many …
const GROUP_SIZE: usize = 512;
/// … and each group is handed on as the cut of its tree with this many clusters, so that one large instance does not
/// drag its whole group upward.
const CUT_SIZE: usize = 32;

/// Build the tree over `boxes`. Its references are indices into `boxes`, each exactly once; empty boxes are left out, since no
/// ray can hit them.
///
/// No leaf is deeper than [`MAX_DEPTH`]. Ties go to the cluster that was made first, so equal boxes give the same tree every
/// time. Time is O(n²) up to a few thousand boxes and O(n log n) above.
pub fn build(boxes: &[Aabb], exec: &Executor) -> Tree {
    let items: Vec<u32> = (0..boxes.len() as u32).filter(|&i| !boxes[i as usize].is_empty()).collect();
    if items.is_empty() {
        return Tree::default();
    }
    let mut forest = Forest::new(boxes, &items);
    let mut roots: Vec<u32> = (0..items.len() as u32).collect();
    while roots.len() > EXACT_LIMIT {
        roots = forest.reduce_by_groups(roots, exec);
    }
    let root = forest.agglomerate_all(&roots);
    Emitter { boxes, forest: &forest, tree: Tree::default() }.emit(root)
}

/// A cluster: an item (both children are [`NONE`]) or two clusters made before it.
#[derive(Clone, Copy)]
struct Cluster {
    bounds: Aabb,
    children: [u32; 2],
    /// Number of items below.
    count: u32,
    /// Longest way down to an item.
    height: u32,
    /// Index in the caller's boxes; of the first item below for a merged cluster.
    item: u32,
}

const NONE: u32 = u32::MAX;

impl Cluster {
    fn merged(a: u32, b: u32, clusters: [&Cluster; 2]) -> Cluster {
        Cluster {
            bounds: clusters[0].bounds.union(clusters[1].bounds),
            children: [a, b],
            count: clusters[0].count + clusters[1].count,
            height: clusters[0].height.max(clusters[1].height) + 1,
            item: clusters[0].item.min(clusters[1].item),
        }
    }

    fn is_item(&self) -> bool {
        self.children[0] == NONE
    }
}

struct Forest {
    clusters: Vec<Cluster>,
    /// A power of two that brings the scene's longest side to between 1 and 2, so that no area over- or underflows.
    scale: f32,
}

impl Forest {
    fn new(boxes: &[Aabb], items: &[u32]) -> Forest {
        let leaf = |&i: &u32| Cluster { bounds: boxes[i as usize], children: [NONE; 2], count: 1, height: 0, item: i };
        let clusters: Vec<Cluster> = items.iter().map(leaf).collect();
        let all = clusters.iter().fold(Aabb::EMPTY, |b, c| b.union(c.bounds));
        let longest = (0..3).map(|a| f64::from(all.max[a]) - f64::from(all.min[a])).fold(0.0, f64::max);
        let exponent = if longest > 0.0 { longest.log2().floor() as i32 } else { 0 };
        Forest { clusters, scale: 2f32.powi((-exponent).clamp(-126, 126)) }
    }

    /// Agglomerate spatial groups apart from each other and return the clusters of their cuts, in group order.
    fn reduce_by_groups(&mut self, roots: Vec<u32>, exec: &Executor) -> Vec<u32> {
        let mut order = roots;
        let clusters = &self.clusters;
        let mut groups: Vec<&mut [u32]> = Vec::new();
        split_into_groups(&mut order, &|i| clusters[i as usize].bounds, &mut groups);

        // Merge inside each group, with new clusters numbered from the group's own start.
        let scale = self.scale;
        let merged = exec.map(groups, |_, group| {
            group.sort_unstable();
            let leaves: Vec<Cluster> = group.iter().map(|&i| clusters[i as usize]).collect();
            (group.to_vec(), agglomerate(&leaves, scale))
        });

        // Renumber into the forest, group after group, and keep each group's cut.
        let mut next = Vec::new();
        for (group, merges) in merged {
            let top = self.append(&group, merges);
            next.extend(self.cut(top));
        }
        next
    }

    fn agglomerate_all(&mut self, roots: &[u32]) -> u32 {
        let leaves: Vec<Cluster> = roots.iter().map(|&i| self.clusters[i as usize]).collect();
        let merges = agglomerate(&leaves, self.scale);
        self.append(roots, merges)
    }

    /// Add a group's merges, whose children count `group`'s clusters first and the merges after them; return the group's root.
    fn append(&mut self, group: &[u32], merges: Vec<Cluster>) -> u32 {
        let base = self.clusters.len() as u32;
        let global = |local: u32| match group.get(local as usize) {
            Some(&id) => id,
            None => base + (local - group.len() as u32),
        };
        self.clusters.extend(merges.into_iter().map(|c| Cluster { children: c.children.map(global), ..c }));
        if self.clusters.len() as u32 > base { self.clusters.len() as u32 - 1 } else { group[0] }
    }

    /// Open the largest clusters below `root` until [`CUT_SIZE`] are there: what a greedy merge in order of area would have left.
    fn cut(&self, root: u32) -> Vec<u32> {
        let mut open = vec![root];
        while open.len() < CUT_SIZE {
            let area = |i: u32| scaled(&self.clusters[i as usize].bounds, self.scale).half_area();
            let candidates = open.iter().enumerate().filter(|&(_, &i)| !self.clusters[i as usize].is_item());
            let Some((at, _)) = candidates.max_by(|(_, a), (_, b)| area(**a).total_cmp(&area(**b)).then(b.cmp(a)))
            else {
                break;
            };
            let id = open.swap_remove(at);
            open.extend(self.clusters[id as usize].children);
        }
        open.sort_unstable();
        open
    }
}

fn scaled(b: &Aabb, scale: f32) -> Aabb {
    Aabb { min: b.min.map(|v| v * scale), max: b.max.map(|v| v * scale) }
}

/// Halve by count at the median of the longest axis until each part has at most [`GROUP_SIZE`] clusters.
fn split_into_groups<'a>(items: &'a mut [u32], bounds: &impl Fn(u32) -> Aabb, out: &mut Vec<&'a mut [u32]>) {
    if items.len() <= GROUP_SIZE {
        out.push(items);
        return;
    }
    let mid = balance::partition(items, bounds);
    let (left, right) = items.split_at_mut(mid);
    split_into_groups(left, bounds, out);
    split_into_groups(right, bounds, out);
}

/// Merge `leaves` into one tree; the result lists the merges in the order made, the last one being the root. Children count
/// leaves first, then merges.
fn agglomerate(leaves: &[Cluster], scale: f32) -> Vec<Cluster> {
    let n = leaves.len();
    let mut merges: Vec<Cluster> = Vec::with_capacity(n.saturating_sub(1));
    let mut active = Active::new(leaves, scale);
    let mut chain: Vec<u32> = Vec::new();
    while active.len() > 1 {
        let top = match chain.last() {
            Some(&top) => top,
            None => {
                let first = active.first();
                chain.push(first);
                first
            }
        };
        let best = active.best_match(top);

        // Follow the chain until two clusters are each other's best match. It cannot close into a longer ring: pairs along it
        // grow strictly better in the order (area, smaller id, larger id), and a merged cluster, being larger and newer, is
        // never better for an older link than the one that link has.
        if chain.len() < 2 || chain[chain.len() - 2] != best {
            chain.push(best);
            continue;
        }
        chain.truncate(chain.len() - 2);
        let (a, b) = (top.min(best), top.max(best));
        let get = |i: u32| if (i as usize) < n { &leaves[i as usize] } else { &merges[i as usize - n] };
        let cluster = Cluster::merged(a, b, [get(a), get(b)]);
        active.remove(a);
        active.remove(b);
        active.insert((n + merges.len()) as u32, &cluster.bounds);
        merges.push(cluster);
    }
    merges
}

/// The clusters that can still be merged: box planes in columns, so that one loop computes eight areas at a time.
struct Active {
    scale: f32,
    ids: Vec<u32>,
    /// min x, y, z, then max x, y, z.
    planes: [Vec<f32>; 6],
    /// Where each cluster stands in the columns.
    slot_of: Vec<u32>,
    areas: Vec<f32>,
}

impl Active {
    fn new(leaves: &[Cluster], scale: f32) -> Active {
        let mut active = Active {
            scale,
            ids: Vec::new(),
            planes: Default::default(),
            slot_of: vec![NONE; 2 * leaves.len()],
            areas: Vec::new(),
        };
        for (i, leaf) in leaves.iter().enumerate() {
            active.insert(i as u32, &leaf.bounds);
        }
        active
    }

    fn len(&self) -> usize {
        self.ids.len()
    }

    fn first(&self) -> u32 {
        self.ids[0]
    }

    fn insert(&mut self, id: u32, bounds: &Aabb) {
        self.slot_of[id as usize] = self.ids.len() as u32;
        self.ids.push(id);
        let b = scaled(bounds, self.scale);
        for axis in 0..3 {
            self.planes[axis].push(b.min[axis]);
            self.planes[axis + 3].push(b.max[axis]);
        }
    }

    fn remove(&mut self, id: u32) {
        let slot = self.slot_of[id as usize] as usize;
        self.ids.swap_remove(slot);
        for column in &mut self.planes {
            column.swap_remove(slot);
        }
        if let Some(&moved) = self.ids.get(slot) {
            self.slot_of[moved as usize] = slot as u32;
        }
    }

    /// The cluster whose common box with `id` has the smallest area; the one made first among equals.
    fn best_match(&mut self, id: u32) -> u32 {
        let own_slot = self.slot_of[id as usize] as usize;
        let own = [0, 1, 2, 3, 4, 5].map(|p| self.planes[p][own_slot]);

        // Write all areas, then find the smallest: two plain loops that compile to vector code.
        let n = self.ids.len();
        self.areas.resize(n, 0.0);
        let [x0, y0, z0, x1, y1, z1] = self.planes.each_ref().map(|c| &c[..n]);
        let areas = &mut self.areas[..n];
        for i in 0..n {
            let lower = |a: f32, b: f32| if a < b { a } else { b };
            let upper = |a: f32, b: f32| if a > b { a } else { b };
            let x = upper(own[3], x1[i]) - lower(own[0], x0[i]);
            let y = upper(own[4], y1[i]) - lower(own[1], y0[i]);
            let z = upper(own[5], z1[i]) - lower(own[2], z0[i]);
            let area = x * y + y * z + z * x;
            areas[i] = if area < f32::INFINITY { area } else { f32::INFINITY };
        }
        areas[own_slot] = f32::INFINITY;
        let mut lanes = [f32::INFINITY; 8];
        for chunk in areas.chunks(8) {
            for (lane, &a) in lanes.iter_mut().zip(chunk) {
                *lane = if a < *lane { a } else { *lane };
            }
        }
        let smallest = lanes.into_iter().fold(f32::INFINITY, f32::min);

        // Among equal areas take the oldest cluster.
        let mut best = NONE;
        for (i, &a) in areas.iter().enumerate() {
            if a <= smallest && i != own_slot && self.ids[i] < best {
                best = self.ids[i];
            }
        }
        best
    }
}

/// Writes clusters in the canonical order of [`Tree`]: the child of larger area first, the one with the smaller item among equals.
struct Emitter<'a> {
    boxes: &'a [Aabb],
    forest: &'a Forest,
    tree: Tree,
}

impl Emitter<'_> {
    fn emit(mut self, root: u32) -> Tree {
        let count = self.forest.clusters[root as usize].count as usize;
        self.tree.nodes.reserve_exact(2 * count);
        self.tree.refs.reserve_exact(count);
        self.tree.nodes.resize(2, bytemuck::Zeroable::zeroed());
        self.cluster(root, 0, 0);
        self.tree
    }

    /// Write cluster `id` into record `slot` at `depth`, and everything below it behind all records that are there.
    fn cluster(&mut self, id: u32, slot: usize, depth: u32) {
        let cluster = self.forest.clusters[id as usize];
        if cluster.is_item() {
            return self.leaf(cluster.item, slot);
        }

        // Keep the clustering as long as what lies below still fits, at worst as a balanced tree.
        let fits = |c: &Cluster| depth + 1 + c.height.min(balance::depth(c.count)) <= MAX_DEPTH;
        let children = cluster.children.map(|c| &self.forest.clusters[c as usize]);
        if !children.iter().all(|c| fits(c)) {
            let mut items = self.items_below(id);
            return self.balanced(&mut items, slot);
        }
        let area = |c: &Cluster| scaled(&c.bounds, self.forest.scale).half_area();
        let swap =
            area(children[0]).total_cmp(&area(children[1])).then(children[1].item.cmp(&children[0].item)).is_lt();
        let pair = self.pair(cluster.bounds, slot);
        let [first, second] = if swap { [cluster.children[1], cluster.children[0]] } else { cluster.children };
        self.cluster(first, pair, depth + 1);
        self.cluster(second, pair + 1, depth + 1);
    }

    /// Write a balanced tree over `items`.
    fn balanced(&mut self, items: &mut [u32], slot: usize) {
        if let [item] = items {
            return self.leaf(*item, slot);
        }
        let bounds = items.iter().fold(Aabb::EMPTY, |b, &i| b.union(self.boxes[i as usize]));
        let boxes = self.boxes;
        let mid = balance::partition(items, &|i| boxes[i as usize]);
        let (left, right) = items.split_at_mut(mid);
        let pair = self.pair(bounds, slot);
        self.balanced(left, pair);
        self.balanced(right, pair + 1);
    }

    fn pair(&mut self, bounds: Aabb, slot: usize) -> usize {
        let pair = self.tree.nodes.len();
        self.tree.nodes[slot] = Node::inner(bounds, pair as u32);
        self.tree.nodes.resize(pair + 2, bytemuck::Zeroable::zeroed());
        pair
    }

    fn leaf(&mut self, item: u32, slot: usize) {
        self.tree.nodes[slot] = Node::leaf(self.boxes[item as usize], self.tree.refs.len() as u32, 1);
        self.tree.refs.push(item);
    }

    fn items_below(&self, id: u32) -> Vec<u32> {
        let mut items = Vec::new();
        let mut open = vec![id];
        while let Some(id) = open.pop() {
            let cluster = &self.forest.clusters[id as usize];
            if cluster.is_item() {
                items.push(cluster.item);
            } else {
                open.extend(cluster.children);
            }
        }
        items.sort_unstable();
        items
    }
}

#[cfg(test)]
mod tests;
