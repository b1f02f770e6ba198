use super::boxes::{Items, show_corners};
use super::cover::{Cover, Covered, most_steps};
use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::exec::Executor;
use crate::geom::Aabb;
use crate::layout::{GeomRecord, Node, SectionKind, TriangleRecord};

/// Every triangle of one tree counted once: is each there as often as its flag, its part and its tree say?
///
/// `tiled` as in [`super::boxes::check`]; `stated` is the tree's `prim_count`.
pub fn check(nodes: &[Node], items: Items<'_>, tiled: bool, stated: u32, max_issues: usize, exec: &Executor) -> Report {
    let mut out = Report::new(max_issues);
    let (low, high) = items.geoms;
    let rows = items.prims.get(low as usize..high as usize).unwrap_or_default();
    let Some(numbering) = Numbering::new(rows, low, items.triangles, exec) else {
        starve(items.tree, "are there once", &mut out);
        return out;
    };
    if let Some(copies) = tiled.then(|| look_once(nodes, items, &numbering, stated)).flatten() {
        return check_copies(nodes, items, &copies, max_issues, exec);
    }
    look_closely(nodes, items, &numbering, tiled, stated, max_issues, exec)
}

/// The way that nearly every tree takes: one look at each triangle, in its leaf. `None` where anything is wrong, which is for
/// [`look_closely`] to say.
fn look_once(nodes: &[Node], items: Items<'_>, numbering: &Numbering<'_>, stated: u32) -> Option<Copies> {
    let mut kept = vec![0u32; numbering.rows.len()];
    let (mut once, mut several) = (Bits::new(numbering.len)?, Bits::new(numbering.len)?);
    let mut list: Vec<Copied> = Vec::new(); // a third of the size of the triangles at most
    for (i, node) in nodes.iter().enumerate().filter(|(i, n)| *i != 1 && n.is_leaf()) {
        let first = node.first as usize;
        for (k, triangle) in items.triangles.get(first..first.checked_add(node.count as usize)?)?.iter().enumerate() {
            let number = numbering.number(triangle)?;
            let new = if triangle.flags & TriangleRecord::DUPLICATED == 0 {
                if once.set(number) {
                    return None;
                }
                true
            } else {
                list.push((number, (first + k) as u32, i as u32));
                !several.set(number)
            };
            kept[(triangle.geom - numbering.low) as usize] += u32::from(new);
        }
    }

    // No triangle is both, and the counts are those that part and tree state.
    let apart = once.0.iter().zip(&several.0).all(|(a, b)| a & b == 0);
    let distinct: u64 = kept.iter().map(|k| u64::from(*k)).sum();
    let as_stated = distinct == u64::from(stated) && numbering.rows.iter().zip(&kept).all(|(r, k)| r.kept_count == *k);
    if !apart || !as_stated || !(items.split || list.is_empty()) {
        return None;
    }
    let copies = Copies::new(&list, &several)?;
    let all_again = copies.starts.windows(2).all(|pair| pair[1] - pair[0] > 1);
    all_again.then_some(copies)
}

/// Every triangle again, collecting what is wrong.
fn look_closely(
    nodes: &[Node],
    items: Items<'_>,
    numbering: &Numbering<'_>,
    tiled: bool,
    stated: u32,
    max_issues: usize,
    exec: &Executor,
) -> Report {
    let mut out = Report::new(max_issues);
    let (rows, low) = (numbering.rows, numbering.low);

    // See which numbers occur, and which occur again.
    let mut kept = vec![0u32; rows.len()];
    let mut seen = Bits::new(numbering.len);
    let mut again = Bits::new(numbering.len);
    let (Some(seen), Some(again)) = (&mut seen, &mut again) else {
        starve(items.tree, "are there once", &mut out);
        return out;
    };
    let (mut copies, mut complete) = (0usize, true);
    for (slot, triangle) in items.triangles.iter().enumerate() {
        let Some(number) = numbering.number(triangle) else {
            complete = false;
            continue;
        };
        if !seen.set(number) {
            kept[(triangle.geom - low) as usize] += 1;
        } else {
            copies += 1;
            again.set(number);
            if !items.split {
                out.add(&rules::E0421, items.place(slot), || {
                    ("an earlier record".into(), format!("prim {} of part {}", triangle.prim, triangle.geom))
                });
            }
        }
    }

    // Compare with the counts that the part and the tree state, unless a triangle of no part is there.
    for (k, (row, kept)) in rows.iter().zip(&kept).enumerate() {
        if complete && row.kept_count != *kept {
            let place = Place::record(SectionKind::GEOM, u64::from(low) + k as u64);
            out.add(&rules::E0318, place, || (kept.to_string(), row.kept_count.to_string()));
        }
    }
    let distinct: u64 = kept.iter().map(|k| u64::from(*k)).sum();
    if complete && distinct != u64::from(stated) {
        let place = Place::record(SectionKind::BLAS, u64::from(items.tree));
        out.add(&rules::E0319, place, || (distinct.to_string(), stated.to_string()));
    }

    // Compare the flags with what was seen.
    for (slot, triangle) in items.triangles.iter().enumerate() {
        let Some(number) = numbering.number(triangle) else { continue };
        let repeated = items.split && again.get(number);
        let flagged = triangle.flags & TriangleRecord::DUPLICATED != 0;
        if repeated != flagged {
            out.add(&rules::E0422, items.place(slot), || (set(repeated), set(flagged)));
        }
    }

    // Look at all copies of a triangle together.
    if items.split && copies > 0 && tiled {
        match list_copies(nodes, items, numbering, again, copies) {
            Some(copies) => out.append(check_copies(nodes, items, &copies, max_issues, exec)),
            None => starve(items.tree, "are covered by their leaves", &mut out),
        }
    } else if items.split && !tiled {
        out.skip(format!("Whether the leaves of tree {} cover its triangles: they do not tile them.", items.tree));
    }
    out
}

fn starve(tree: u32, question: &str, out: &mut Report) {
    let place = Place::record(SectionKind::BLAS, tree.into());
    out.starve(place, &format!("Whether the triangles of tree {tree} {question}"));
}

fn set(yes: bool) -> String {
    if yes { "set".into() } else { "clear".into() }
}

/// One copy of a repeated triangle: its number, where it stands, and the leaf that holds it there.
type Copied = (u64, u32, u32);

/// The copies of repeated triangles, those of one triangle beside each other.
struct Copies {
    /// Where each triangle's copies start in `list`, and its end.
    starts: Vec<u32>,
    /// Where a copy stands, and its leaf.
    list: Vec<(u32, u32)>,
}

impl Copies {
    /// `several` holds the numbers in `list` and no others. `None` where memory is short.
    fn new(list: &[Copied], several: &Bits) -> Option<Copies> {
        // Sort by counting: the numbers in use, closed up, are the places to count in.
        let ranks = several.ranks()?;
        let rank = |number: u64| several.rank(&ranks, number) as usize;
        let groups = several.0.iter().map(|word| u64::from(word.count_ones())).sum::<u64>() as usize;
        let mut starts: Vec<u32> = Vec::new();
        starts.try_reserve_exact(groups + 2).ok()?;
        starts.resize(groups + 2, 0);
        for (number, ..) in list {
            starts[rank(*number) + 2] += 1;
        }
        for i in 2..starts.len() {
            starts[i] += starts[i - 1];
        }
        let mut sorted: Vec<(u32, u32)> = Vec::new();
        sorted.try_reserve_exact(list.len()).ok()?;
        sorted.resize(list.len(), (0, 0));
        for (number, slot, leaf) in list {
            let at = &mut starts[rank(*number) + 1];
            sorted[*at as usize] = (*slot, *leaf);
            *at += 1;
        }
        starts.pop();
        let mut copies = Copies { starts, list: sorted };
        // Leaves were listed in the order of their records, which is not quite that of their triangles.
        for pair in copies.starts.windows(2) {
            copies.list[pair[0] as usize..pair[1] as usize].sort_unstable();
        }
        Some(copies)
    }
}

/// List the copies of triangles that stand in the tree `again`; `copies`: how many there are beyond the first ones.
fn list_copies(
    nodes: &[Node],
    items: Items<'_>,
    numbering: &Numbering<'_>,
    again: &Bits,
    copies: usize,
) -> Option<Copies> {
    let mut list: Vec<Copied> = Vec::new();
    // Each further copy goes with at most one first copy.
    list.try_reserve(copies.saturating_mul(2)).ok()?;
    for (i, node) in nodes.iter().enumerate().filter(|(i, n)| *i != 1 && n.is_leaf()) {
        let first = node.first as usize;
        let triangles = items.triangles.get(first..first.saturating_add(node.count as usize)).unwrap_or_default();
        for (k, triangle) in triangles.iter().enumerate() {
            if let Some(number) = numbering.number(triangle).filter(|n| again.get(*n)) {
                list.push((number, (first + k) as u32, i as u32));
            }
        }
    }
    Copies::new(&list, again)
}

/// Look at all copies of a triangle together.
fn check_copies(nodes: &[Node], items: Items<'_>, copies: &Copies, max_issues: usize, exec: &Executor) -> Report {
    const PIECE: usize = 1 << 10;
    let mut out = Report::new(max_issues);
    let groups = copies.starts.len() - 1;
    let parts = exec.map_range(groups.div_ceil(PIECE), |c| {
        let mut part = Report::new(max_issues);
        let (mut boxes, mut cover) = (Vec::<Aabb>::new(), Cover::default());
        for pair in copies.starts[c * PIECE..=((c + 1) * PIECE).min(groups)].windows(2) {
            let group = &copies.list[pair[0] as usize..pair[1] as usize];
            if group.is_empty() {
                continue; // a number without a copy, which a tiled tree does not have
            }
            boxes.clear();
            boxes.extend(group.iter().map(|c| nodes[c.1 as usize].bounds()));
            check_group(group, &boxes, &mut cover, items, &mut part);
        }
        part
    });
    parts.into_iter().for_each(|part| out.append(part));
    out
}

fn check_group(group: &[(u32, u32)], boxes: &[Aabb], cover: &mut Cover, items: Items<'_>, out: &mut Report) {
    let slot = group[0].0 as usize;
    let triangle = &items.triangles[slot];
    let corners = triangle.corners().map(|p| p.map(f32::to_bits));
    let mut equal = true;
    for copy in &group[1..] {
        let other = &items.triangles[copy.0 as usize];
        if other.corners().map(|p| p.map(f32::to_bits)) != corners {
            equal = false;
            out.add(&rules::E0424, items.place(copy.0 as usize), || {
                ((items.start + slot as u64).to_string(), format!("they are {}", show_corners(other)))
            });
        }
    }
    if !equal || boxes.iter().any(|b| !b.is_valid()) {
        return;
    }
    let actual = match cover.look(triangle.corners(), boxes) {
        Covered::Whole => return,
        Covered::Hole(point) => format!("none holds its point {point:?}"),
        Covered::Unknown => format!("that is not seen within {} steps", most_steps(boxes.len())),
    };
    out.add(&rules::E0425, items.place(slot), || (format!("its {} leaves must cover it", boxes.len()), actual));
}

/// Numbers the triangles of a tree without a hole between parts: part by part, primitive by primitive, dropped ones included; or,
/// where a part states far more primitives than the tree has triangles, by rank.
struct Numbering<'a> {
    rows: &'a [GeomRecord],
    low: u32,
    /// Number of each row's first primitive.
    starts: Vec<u64>,
    /// Sorted (part, primitive) pairs, if numbers go by rank.
    ranks: Option<Vec<(u32, u32)>>,
    len: u64,
}

impl<'a> Numbering<'a> {
    /// `None` where memory is short.
    fn new(rows: &'a [GeomRecord], low: u32, triangles: &[TriangleRecord], exec: &Executor) -> Option<Numbering<'a>> {
        let mut starts = Vec::new();
        starts.try_reserve_exact(rows.len()).ok()?;
        let mut len = 0u64;
        for row in rows {
            starts.push(len);
            len += u64::from(row.prim_count);
        }
        // A bit for each primitive is cheapest, but what a row states is not to be trusted with more memory than the file has.
        let mut ranks = None;
        if len > 64 * triangles.len() as u64 + 4096 {
            let mut pairs: Vec<(u32, u32)> = Vec::new();
            pairs.try_reserve_exact(triangles.len()).ok()?;
            pairs.extend(triangles.iter().map(|t| (t.geom, t.prim)));
            exec.sort_unstable(&mut pairs);
            pairs.dedup();
            len = pairs.len() as u64;
            ranks = Some(pairs);
        }
        Some(Numbering { rows, low, starts, ranks, len })
    }

    /// `None` for a triangle whose part or number is out of range, which has its own rules.
    #[inline]
    fn number(&self, t: &TriangleRecord) -> Option<u64> {
        let k = t.geom.checked_sub(self.low)? as usize;
        let row = self.rows.get(k)?;
        let within = t.prim.checked_sub(row.first_prim).filter(|w| *w < row.prim_count)?;
        match &self.ranks {
            None => Some(self.starts[k] + u64::from(within)),
            Some(pairs) => pairs.binary_search(&(t.geom, t.prim)).ok().map(|rank| rank as u64),
        }
    }
}

/// A set of small numbers.
pub struct Bits(Vec<u64>);

impl Bits {
    /// `None` where memory is short.
    pub fn new(len: u64) -> Option<Bits> {
        let words = usize::try_from(len.div_ceil(64)).ok()?;
        let mut bits = Vec::new();
        bits.try_reserve_exact(words).ok()?;
        bits.resize(words, 0);
        Some(Bits(bits))
    }

    /// Put `n` in; whether it was in before. Numbers beyond the length are in already.
    #[inline]
    pub fn set(&mut self, n: u64) -> bool {
        let Some(word) = self.0.get_mut((n / 64) as usize) else { return true };
        let bit = 1u64 << (n % 64);
        let was = *word & bit != 0;
        *word |= bit;
        was
    }

    /// For each word how many numbers are in the words before it; `None` where memory is short.
    fn ranks(&self) -> Option<Vec<u64>> {
        let mut ranks = Vec::new();
        ranks.try_reserve_exact(self.0.len()).ok()?;
        let mut sum = 0u64;
        ranks.extend(self.0.iter().map(|word| {
            sum += u64::from(word.count_ones());
            sum - u64::from(word.count_ones())
        }));
        Some(ranks)
    }

    /// How many smaller numbers are in.
    fn rank(&self, ranks: &[u64], n: u64) -> u64 {
        let word = (n / 64) as usize;
        ranks[word] + u64::from((self.0[word] & ((1u64 << (n % 64)) - 1)).count_ones())
    }

    /// Whether `n` is in; `false` beyond the numbers that the set was made for.
    #[inline]
    pub fn get(&self, n: u64) -> bool {
        self.0.get((n / 64) as usize).is_some_and(|word| word >> (n % 64) & 1 != 0)
    }
}
