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

    /// `None` where memory is short.
    fn check_places(&self, out: &mut Report, exec: &Executor) -> Option<()> {
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
