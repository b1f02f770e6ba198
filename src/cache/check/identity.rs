use rayon::prelude::*;

use super::boxes::{Items, show_corners};
use super::cover::Cover;
use super::report::{Place, Report};
use crate::cache::{GeomRecord, SectionKind, TriangleRecord, rules};
use crate::geom::Aabb;
use crate::tree::Node;

/// Every triangle of one tree counted once: is each there as often as its flag, its part and its tree say?
///
/// `tiled` as in [`super::boxes::check`]; `stated` is the tree's `prim_count`.
pub fn check(nodes: &[Node], items: Items<'_>, tiled: bool, stated: u32, max_issues: usize) -> Report {
    let mut out = Report::new(max_issues);
    let (low, high) = items.geoms;
    let rows = items.prims.get(low as usize..high as usize).unwrap_or_default();
    let Some(numbering) = Numbering::new(rows, low, items.triangles) else {
        out.skip(format!("Whether the triangles of tree {} are there once: there is not enough memory.", items.tree));
        return out;
    };

    // See which numbers occur, and which occur again.
    let mut kept = vec![0u32; rows.len()];
    let mut seen = Bits::new(numbering.len);
    let mut again = Bits::new(numbering.len);
    let (Some(seen), Some(again)) = (&mut seen, &mut again) else {
        out.skip(format!("Whether the triangles of tree {} are there once: there is not enough memory.", items.tree));
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
        out.append(check_copies(nodes, items, &numbering, again, copies, max_issues));
    } else if items.split && !tiled {
        out.skip(format!("Whether the leaves of tree {} cover its triangles: they do not tile them.", items.tree));
    }
    out
}

fn set(yes: bool) -> String {
    if yes { "set".into() } else { "clear".into() }
}

/// One copy of a repeated triangle: its number, where it stands, and the leaf that holds it there.
type Copied = (u64, u32, u32);

fn check_copies(
    nodes: &[Node],
    items: Items<'_>,
    numbering: &Numbering<'_>,
    again: &Bits,
    copies: usize,
    max_issues: usize,
) -> Report {
    // List the copies, those of one triangle beside each other.
    let mut out = Report::new(max_issues);
    let mut list: Vec<Copied> = Vec::new();
    // Each further copy goes with at most one first copy.
    if list.try_reserve(copies.saturating_mul(2)).is_err() {
        out.skip(format!("Whether the leaves of tree {} cover its triangles: there is not enough memory.", items.tree));
        return out;
    }
    for (i, node) in nodes.iter().enumerate().filter(|(i, n)| *i != 1 && n.is_leaf()) {
        let first = node.first as usize;
        let triangles = items.triangles.get(first..first.saturating_add(node.count as usize)).unwrap_or_default();
        for (k, triangle) in triangles.iter().enumerate() {
            if let Some(number) = numbering.number(triangle).filter(|n| again.get(*n)) {
                list.push((number, (first + k) as u32, i as u32));
            }
        }
    }
    list.par_sort_unstable();

    // Cut the list between triangles, into pieces of about the same length.
    const PIECE: usize = 1 << 12;
    let mut pieces: Vec<&[Copied]> = Vec::new();
    let mut rest = list.as_slice();
    while !rest.is_empty() {
        let mut end = PIECE.min(rest.len());
        while end < rest.len() && rest[end].0 == rest[end - 1].0 {
            end += 1;
        }
        let (piece, behind) = rest.split_at(end);
        pieces.push(piece);
        rest = behind;
    }
    let parts: Vec<Report> = pieces
        .into_par_iter()
        .map(|piece| {
            let mut part = Report::new(max_issues);
            let (mut boxes, mut cover) = (Vec::<Aabb>::new(), Cover::default());
            for group in piece.chunk_by(|a, b| a.0 == b.0) {
                boxes.clear();
                boxes.extend(group.iter().map(|c| nodes[c.2 as usize].bounds()));
                check_group(group, &boxes, &mut cover, items, &mut part);
            }
            part
        })
        .collect();
    parts.into_iter().for_each(|part| out.append(part));
    out
}

fn check_group(group: &[Copied], boxes: &[Aabb], cover: &mut Cover, items: Items<'_>, out: &mut Report) {
    let slot = group[0].1 as usize;
    let triangle = &items.triangles[slot];
    let corners = triangle.corners().map(|p| p.map(f32::to_bits));
    let mut equal = true;
    for copy in &group[1..] {
        let other = &items.triangles[copy.1 as usize];
        if other.corners().map(|p| p.map(f32::to_bits)) != corners {
            equal = false;
            out.add(&rules::E0424, items.place(copy.1 as usize), || {
                ((items.start + slot as u64).to_string(), format!("they are {}", show_corners(other)))
            });
        }
    }
    if !equal || boxes.iter().any(|b| !b.is_valid()) {
        return;
    }
    if let Some(point) = cover.hole(triangle.corners(), boxes) {
        out.add(&rules::E0425, items.place(slot), || {
            (format!("its {} leaves must cover it", boxes.len()), format!("none holds its point {point:?}"))
        });
    }
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
    fn new(rows: &'a [GeomRecord], low: u32, triangles: &[TriangleRecord]) -> Option<Numbering<'a>> {
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
            pairs.par_sort_unstable();
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

    #[inline]
    pub fn get(&self, n: u64) -> bool {
        self.0.get((n / 64) as usize).is_some_and(|word| word >> (n % 64) & 1 != 0)
    }
}
