//! Parts of a text that was read in ranges become one mesh, some parts at a time.
//!
//! Each part has its positions anew, so that the numbers within it depend on nothing before it: groups of parts count theirs from 0 side by side, and the
//! numbers before each group are added once all are known. What is numbered over all faces, corners and [`Mesh::faces`], goes by
//! [`super::joined`] instead, one part after the other.

use super::given::{Finger, Given};
use super::parts::PartName;
use super::polygon::Triangulator;
use super::range::Range;
use super::ranges::Everyday;
use crate::exec::Executor;
use crate::scene::{Mesh, Part};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// A group has so many faces or more, and no text is more than [`MOST`] groups.
pub(super) const FACES: usize = 1 << 16;
const MOST: usize = 64;

/// Positions that a task moves.
const CHUNK: usize = 1 << 14;

/// The mesh of a text without its positions, these, and how many of the text's no face uses. Groups have so many faces or more.
pub(super) fn join(text: Everyday, faces: usize, name: String, exec: &Executor) -> (Mesh, Vec<[f64; 3]>, u64) {
    let Everyday { mut ranges, parts, positions: count, triangles: all, .. } = text;
    let given = Given::of(&mut ranges);
    let used: Vec<AtomicBool> = exec.generate(count, |_| AtomicBool::new(false));
    let groups = cut(&ranges, &parts, faces);

    // Number the positions of each group from 0.
    let mut triangles: Vec<[u32; 3]> = bytemuck::zeroed_vec(all);
    let jobs = slices(&mut triangles, groups.iter().map(|group| group.triangles)).into_iter().zip(&groups).collect();
    let work = Work { ranges: &ranges, parts: &parts, given: &given, used: &used };
    let numbered = exec.map(jobs, |_, (out, group)| group.number(&work, out));
    drop(groups);
    drop(ranges);

    // Count on from group to group.
    let lengths: Vec<usize> = numbered.iter().map(|group| group.order.len()).collect();
    let mut positions: Vec<[f64; 3]> = bytemuck::zeroed_vec(lengths.iter().sum());
    let placed = slices(&mut positions, lengths.iter().copied());
    for (out, group) in placed.into_iter().zip(&numbered) {
        exec.map_chunks_mut(out, CHUNK, |chunk, out| {
            let mut finger = Finger::default();
            for (position, number) in out.iter_mut().zip(&group.order[chunk * CHUNK..]) {
                *position = given.position(*number as usize, &mut finger);
            }
        });
    }
    let mut base = 0u32;
    let counted = slices(&mut triangles, numbered.iter().map(|group| group.triangles()));
    for (out, length) in counted.into_iter().zip(lengths) {
        if base > 0 {
            exec.map_chunks_mut(out, CHUNK, |_, out| out.iter_mut().flatten().for_each(|corner| *corner += base));
        }
        base += length as u32;
    }
    let mut mesh = Mesh { name, triangles, ..Mesh::default() };
    let counts = numbered.iter().flat_map(|group| &group.parts);
    let mut first = 0;
    for ((_, PartName { name, material }), triangle_count) in parts.into_iter().zip(counts) {
        mesh.parts.push(Part {
            name,
            material,
            source_part: mesh.parts.len() as u32,
            first_triangle: first,
            triangle_count: *triangle_count,
            first_prim: first,
            prim_count: *triangle_count,
            ..Part::default()
        });
        first += triangle_count;
    }
    let unreferenced = used.iter().filter(|used| !used.load(Relaxed)).count();
    (mesh, positions, unreferenced as u64)
}

/// Cut a list into pieces of these lengths.
fn slices<T>(list: &mut [T], lengths: impl Iterator<Item = usize>) -> Vec<&mut [T]> {
    let mut rest = list;
    let mut next = |length: usize| {
        let (own, tail) = std::mem::take(&mut rest).split_at_mut(length);
        rest = tail;
        own
    };
    lengths.map(&mut next).collect()
}

/// What all groups read.
struct Work<'a> {
    ranges: &'a [Range],
    parts: &'a [(usize, PartName)],
    given: &'a Given,
    /// Of each position of the text, whether any face uses it. That only ever becomes true, whoever is first.
    used: &'a [AtomicBool],
}

/// Parts next to each other.
#[derive(Clone, Debug, Default)]
struct Group {
    /// Number of the first, and how many faces of the text are before it.
    part: usize,
    face: usize,
    faces: usize,
    triangles: usize,
    /// The range that its first face is in, and how many faces and corners of that range are before it.
    range: usize,
    before: (usize, usize),
}

/// A group with its own numbers.
struct Numbered {
    /// Of each of its positions the number in the text.
    order: Vec<u32>,
    /// Triangles of each part.
    parts: Vec<u32>,
}

impl Numbered {
    fn triangles(&self) -> usize {
        self.parts.iter().map(|count| *count as usize).sum()
    }
}

/// Parts in groups. A group ends where a part begins.
fn cut(ranges: &[Range], parts: &[(usize, PartName)], least: usize) -> Vec<Group> {
    let all: usize = ranges.iter().map(|range| range.faces).sum();
    let least = least.max(all.div_ceil(MOST));
    let (mut groups, mut group, mut face): (Vec<Group>, _, _) = (Vec::new(), Group::default(), 0);
    let mut parts = parts.iter().map(|(first, _)| *first).enumerate().peekable();
    for (number, range) in ranges.iter().enumerate() {
        let mut corner = 0;
        let mut i = 0;
        while i < range.faces {
            if let Some((part, _)) = parts.next_if(|(_, first)| *first == face)
                && group.faces >= least
            {
                let next = Group { part, face, range: number, before: (i, corner), ..Group::default() };
                groups.push(std::mem::replace(&mut group, next));
            }
            // Go on to the next part, or to the end of the range.
            let end = parts.peek().map_or(range.faces, |(_, first)| range.faces.min(i + (first - face)));
            let corners: usize = match &range.arities[..] {
                [] => 3 * (end - i),
                arities => arities[i..end].iter().map(|arity| *arity as usize).sum(),
            };
            group.faces += end - i;
            group.triangles += corners - 2 * (end - i);
            (corner, face, i) = (corner + corners, face + (end - i), end);
        }
    }
    groups.push(group);
    groups
}

impl Group {
    /// The faces in order, each by the numbers of its positions in the text.
    fn faces<'a>(&self, ranges: &'a [Range]) -> impl Iterator<Item = &'a [u32]> {
        let (mut i, mut corner) = self.before;
        let mut ranges = ranges[self.range..].iter();
        let mut range = ranges.next();
        let next = move || {
            while i == range?.faces {
                (range, i, corner) = (ranges.next(), 0, 0);
            }
            let here = range?;
            let arity = here.arities.get(i).map_or(3, |arity| *arity as usize);
            (i, corner) = (i + 1, corner + arity);
            Some(&here.corners[corner - arity..corner])
        };
        std::iter::from_fn(next).take(self.faces)
    }

    /// Number the positions in the order in which faces first use them, part by part, and write the triangles.
    fn number(&self, work: &Work, out: &mut [[u32; 3]]) -> Numbered {
        let ends = |(low, high): (u32, u32), corner: &u32| (low.min(*corner), high.max(*corner));
        let (low, high) = self.faces(work.ranges).flatten().fold((u32::MAX, 0), ends);
        // For each position its latest number, counted from 1; one that is not above the part's first is an earlier part's.
        let mut numbers = vec![0u32; (high + 1).saturating_sub(low) as usize];
        let mut numbered = Numbered { order: Vec::new(), parts: Vec::new() };
        let (mut base, mut written, mut begun) = (0, 0, 0);
        let mut parts = work.parts[self.part..].iter().map(|(first, _)| first - self.face).peekable();
        let (mut face, mut cutter) = (Vec::new(), Cutter::default());
        for (i, corners) in self.faces(work.ranges).enumerate() {
            if parts.next_if(|first| *first == i).is_some() && i > 0 {
                numbered.parts.push((written - begun) as u32);
                (base, begun) = (numbered.order.len() as u32, written);
            }
            face.clear();
            for &corner in corners {
                let number = &mut numbers[(corner - low) as usize];
                if *number <= base {
                    numbered.order.push(corner);
                    *number = numbered.order.len() as u32;
                    work.used[corner as usize].store(true, Relaxed);
                }
                face.push(*number - 1);
            }
            match face[..] {
                [a, b, c] => out[written] = [a, b, c],
                _ => cutter.cut(corners, &face, work.given, &mut out[written..]),
            }
            written += face.len() - 2;
        }
        numbered.parts.push((written - begun) as u32);
        numbered
    }
}

/// Cuts faces of more than three corners.
#[derive(Default)]
struct Cutter {
    cut: Option<Triangulator>,
    finger: Finger,
    own: Vec<u32>,
    positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    /// Write the triangles of a face whose positions have these numbers in the text and in the group.
    fn cut(&mut self, corners: &[u32], face: &[u32], given: &Given, out: &mut [[u32; 3]]) {
        let Cutter { cut, finger, own, positions, triangles } = self;
        positions.clear();
        positions.extend(corners.iter().map(|corner| given.position(*corner as usize, finger)));
        own.clear();
        own.extend(0..face.len() as u32);
        triangles.clear();
        cut.get_or_insert_with(Triangulator::new).add(own, positions, triangles);
        for (out, triangle) in out.iter_mut().zip(&*triangles) {
            *out = triangle.map(|corner| face[corner as usize]);
        }
    }
}
