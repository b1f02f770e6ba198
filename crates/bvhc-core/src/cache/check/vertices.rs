//! `VERT`: what can be proved of the numbers of source vertices without the source.

use crate::cache::report::{Place, Report};
use crate::cache::rules;
use crate::exec::Executor;
use crate::layout::{SectionKind, TriangleRecord, View};

use super::Limits;

/// One record for each of `TRIS`; copies of a triangle have the same vertices; and a vertex of a part stands in one place.
pub fn check(view: &View<'_>, vertices: &[[u32; 3]], limits: &Limits, exec: &Executor) -> Report {
    let mut out = Report::new(limits.max_issues);
    if vertices.len() != view.triangles.len() {
        let (expected, actual) = (view.triangles.len().to_string(), vertices.len().to_string());
        out.add(&rules::E0321, Place::section(SectionKind::VERT), || (expected, actual));
        return out;
    }
    let parts = exec.map_range(view.blases.len(), |tree| {
        let mut part = Report::new(limits.max_issues);
        let range = view.blas(tree).and_then(|records| {
            let start = usize::try_from(view.blases[tree].ref_offset).ok()?;
            Some((records.triangles, vertices.get(start..start.checked_add(records.triangles.len())?)?, start))
        });
        // A tree whose row leads nowhere has its own rules.
        if let Some((triangles, vertices, start)) = range {
            let tree = Tree { number: tree as u32, triangles, vertices, start: start as u64 };
            if tree.check_copies(&mut part, exec).and_then(|()| tree.check_places(&mut part, exec)).is_none() {
                let place = Place::record(SectionKind::BLAS, tree.number.into());
                part.starve(place, &format!("The vertices of tree {}", tree.number));
            }
        }
        part
    });
    parts.into_iter().for_each(|part| out.append(part));
    out
}

/// The records of one tree, and where in their sections they start.
struct Tree<'a> {
    number: u32,
    triangles: &'a [TriangleRecord],
    vertices: &'a [[u32; 3]],
    start: u64,
}

impl Tree<'_> {
    fn place(&self, slot: u32) -> Place {
        let tree = Some((self.number, slot.into()));
        Place { tree, ..Place::record(SectionKind::VERT, self.start + u64::from(slot)) }
    }

    /// `None` where memory is short.
    fn check_copies(&self, out: &mut Report, exec: &Executor) -> Option<()> {
        let is_copy = |t: &TriangleRecord| t.flags & TriangleRecord::DUPLICATED != 0;
        let mut copies: Vec<(u32, u32, u32)> = Vec::new();
        copies.try_reserve_exact(self.triangles.iter().filter(|t| is_copy(t)).count()).ok()?;
        let all = self.triangles.iter().enumerate().filter(|(_, t)| is_copy(t));
        copies.extend(all.map(|(slot, t)| (t.geom, t.prim, slot as u32)));
        exec.sort_unstable(&mut copies);
        for group in copies.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let first = self.vertices[group[0].2 as usize];
            for (.., slot) in &group[1..] {
                let other = self.vertices[*slot as usize];
                if other != first {
                    out.add(&rules::E0322, self.place(*slot), || (format!("{first:?}"), format!("{other:?}")));
                }
            }
        }
        Some(())
    }

    /// Whether every vertex stands in one place, by a look at each corner: the way that nearly every tree takes. `None` where the numbers
    /// of a part lie so far apart that a table of them would outgrow the file, or memory is short.
    fn look_once(&self) -> Option<bool> {
        let count = u32::try_from(self.triangles.len()).ok().filter(|count| *count < u32::MAX / 3)?;
        let geoms = || self.triangles.iter().map(|t| t.geom);
        let (low, high) = (geoms().min().unwrap_or(0), geoms().max().unwrap_or(0));
        if high - low > count {
            return None;
        }
        let parts = (high - low) as usize + 1;

        // Close the numbers up: of each part from its least to its greatest.
        let mut spans: Vec<(u32, u32)> = Vec::new();
        spans.try_reserve_exact(parts).ok()?;
        spans.resize(parts, (u32::MAX, 0));
        for (triangle, vertex) in
            self.triangles.iter().zip(self.vertices).flat_map(|(t, v)| v.map(|vertex| (t, vertex)))
        {
            let span = &mut spans[(triangle.geom - low) as usize];
            *span = (span.0.min(vertex), span.1.max(vertex));
        }
        let (mut starts, mut len) = (Vec::new(), 0u64);
        starts.try_reserve_exact(parts).ok()?;
        for (least, greatest) in &spans {
            starts.push(len as usize);
            len += if least <= greatest { u64::from(greatest - least) + 1 } else { 0 };
            if len > 8 * u64::from(count) + 64 {
                return None;
            }
        }

        // Hold each corner against the first with its vertex.
        const NONE: u32 = u32::MAX;
        let mut firsts: Vec<u32> = Vec::new();
        firsts.try_reserve_exact(len as usize).ok()?;
        firsts.resize(len as usize, NONE);
        let at = |corner: u32| {
            self.triangles[(corner / 3) as usize].corners()[(corner % 3) as usize].map(|c| (c + 0.0).to_bits())
        };
        for (slot, (triangle, vertices)) in (0..count).zip(self.triangles.iter().zip(self.vertices)) {
            let part = (triangle.geom - low) as usize;
            for (k, vertex) in (0..3).zip(vertices) {
                let first = &mut firsts[starts[part] + (vertex - spans[part].0) as usize];
                let this = 3 * slot + k;
                if *first == NONE {
                    *first = this;
                } else if at(*first) != at(this) {
                    return Some(false);
                }
            }
        }
        Some(true)
    }

    /// `None` where memory is short.
    fn check_places(&self, out: &mut Report, exec: &Executor) -> Option<()> {
        if self.look_once() == Some(true) {
            return Some(());
        }
        // By part and vertex: the slot, and which of its corners.
        let mut uses: Vec<(u32, u32, u32, u8)> = Vec::new();
        uses.try_reserve_exact(self.triangles.len().checked_mul(3)?).ok()?;
        for (slot, (triangle, vertices)) in self.triangles.iter().zip(self.vertices).enumerate() {
            uses.extend((0..3u8).zip(vertices).map(|(k, vertex)| (triangle.geom, *vertex, slot as u32, k)));
        }
        exec.sort_unstable(&mut uses);
        let at = |slot: u32, corner: u8| self.triangles[slot as usize].corners()[usize::from(corner)].map(|c| c + 0.0);
        for group in uses.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let first = at(group[0].2, group[0].3);
            for (_, vertex, slot, corner) in &group[1..] {
                let other = at(*slot, *corner);
                if other.map(f32::to_bits) != first.map(f32::to_bits) {
                    let expected = format!("{first:?}, where record {} has it", self.start + u64::from(group[0].2));
                    out.add(&rules::E0323, self.place(*slot), || {
                        (expected, format!("{other:?}, as corner {corner} with vertex {vertex}"))
                    });
                }
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn a_table_tells_what_sorting_tells() {
        let at = |x: f32| TriangleRecord {
            v0: [x, 0.0, 0.0],
            v1: [x + 1.0, 0.0, 0.0],
            v2: [x, 1.0, 0.0],
            geom: 7,
            ..TriangleRecord::zeroed()
        };
        let told = |triangles: &[TriangleRecord], vertices: &[[u32; 3]]| {
            let tree = Tree { number: 0, triangles, vertices, start: 0 };
            let mut report = Report::new(9);
            tree.check_places(&mut report, &Executor::sequential()).expect("memory");
            (tree.look_once(), report.count(&rules::E0323))
        };
        // The second triangle's first vertex is the first one's second.
        let two = [at(0.0), at(1.0)];
        assert_eq!(told(&two, &[[5, 6, 9], [6, 11, 12]]), (Some(true), 0));
        assert_eq!(told(&two, &[[5, 6, 9], [5, 11, 12]]), (Some(false), 1));
        // Each part has its own numbers, and zeros have no sign.
        let other = TriangleRecord { geom: 9, ..two[1] };
        assert_eq!(told(&[two[0], other], &[[5, 6, 9], [5, 11, 12]]), (Some(true), 0));
        let negative = TriangleRecord { v0: [-0.0, -0.0, 0.0], ..two[1] };
        assert_eq!(told(&[two[0], negative], &[[5, 6, 9], [5, 11, 12]]), (Some(true), 0));
        // Numbers far apart take no table.
        assert_eq!(told(&two, &[[5, 6, u32::MAX], [6, 11, 12]]), (None, 0));
        assert_eq!(told(&two, &[[5, 6, u32::MAX], [5, 11, 12]]), (None, 1));
        assert_eq!(told(&[], &[]), (Some(true), 0));
    }
}
