//! Faces into triangles.

use crate::geom::vector::{cross, dot, sub};
use earcut::Earcut;
use std::collections::HashMap;

/// Most corners of one face. Ear clipping is quadratic on hostile polygons (spirals, ribbons and rows of teeth in which long thin triangles lie
/// side by side); this many take about a second at worst.
pub(super) const MAX_CORNERS: usize = 1 << 14;

/// Faces of more corners than this are large: they share one allowance, the sum of their corners' squares. It lets a file
/// have 65,000 faces of a thousand corners or 256 of the most, which take some three minutes at worst; without it a file
/// of 100 MiB could take half an hour.
pub(super) const LARGE: u64 = 1 << 10;
const MAX_LARGE_WORK: u64 = 1 << 36;

/// How much cutting the large faces of a file takes.
#[derive(Debug)]
pub(super) struct LargeFaces {
    work: u64,
    allowance: u64,
}

impl Default for LargeFaces {
    fn default() -> LargeFaces {
        LargeFaces { work: 0, allowance: MAX_LARGE_WORK }
    }
}

impl LargeFaces {
    /// Whether the allowance still has room for a face of so many corners, which it then takes.
    pub fn afford(&mut self, corners: u64) -> bool {
        if corners > LARGE {
            self.work = self.work.saturating_add(corners.saturating_mul(corners));
        }
        self.work <= self.allowance
    }

    /// How much there may be in all.
    pub fn allowance(&self) -> u64 {
        self.allowance
    }
}

/// Cuts polygons without holes, reusing its buffers. Every polygon of `n` corners gives exactly `n - 2` triangles, all with
/// the polygon's winding and all of its corners used, so that no corner lies on a neighbour's edge unshared.
pub(super) struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
}

impl Triangulator {
    pub fn new() -> Triangulator {
        Triangulator { earcut: Earcut::default(), flat: Vec::new(), ears: Vec::new() }
    }

    /// Append the triangles of one face, which have the numbers of its corners, from 0. `corners` index `positions`; fewer than three give nothing.
    ///
    /// Concave faces are cut along diagonals inside them: by the two diagonals' signs for quadrilaterals, by ear clipping in
    /// the plane for more corners. A face that crosses itself, has no area or is not finite becomes a fan about its
    /// first corner, as most readers make of every face. So does one that is seen to wind around more than once, on which ear clipping takes
    /// cubic time.
    pub fn add(&mut self, corners: &[u32], positions: &[[f64; 3]], out: &mut Vec<[u32; 3]>) {
        let n = corners.len();
        let first = out.len();
        let at = |i: usize| positions[corners[i] as usize];
        match n {
            0..=2 => return,
            3 => {}
            4 => {
                if prefers_other_diagonal([at(0), at(1), at(2), at(3)]) {
                    out.extend([[0, 1, 3], [1, 2, 3]]);
                    return;
                }
            }
            _ if repeats(corners, positions) => {}
            _ => {
                let normal = newell_normal(n, at);
                for project in [Projection::drop_axis(normal), Projection::onto_plane(normal)].into_iter().flatten() {
                    self.flat.clear();
                    self.flat.extend((0..n).map(|i| project.apply(at(i))));
                    if (n <= FEW || !winds_backwards(&self.flat)) && self.clip_ears(out) {
                        return;
                    }
                    out.truncate(first);
                }
            }
        }
        out.extend((1..n as u32 - 1).map(|i| [0, i, i + 1]));
    }

    /// Cut the polygon in `flat`, which winds counter-clockwise; the triangles hold numbers of its corners. False if they
    /// do not cover exactly the polygon.
    fn clip_ears(&mut self, out: &mut Vec<[u32; 3]>) -> bool {
        let flat = &self.flat;
        let n = flat.len();
        let polygon_area: f64 = (1..n - 1).map(|i| area2(flat[0], flat[i], flat[i + 1])).sum();
        if !(polygon_area.is_finite() && polygon_area > 0.0 && polygon_area <= box_area2(flat)) {
            return false;
        }
        let first = out.len();
        self.earcut.earcut_slice(flat, &[], &mut self.ears);
        let area = |t: &[u32; 3]| area2(flat[t[0] as usize], flat[t[1] as usize], flat[t[2] as usize]);
        // All ears wind in one way. Those that are seen from their edge have no sign of their own, so all together decide.
        let ears = self.ears.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
        let turned = ears.clone().map(|t| area(&t)).sum::<f64>() < 0.0;
        out.extend(ears.map(|t| if turned { [t[0], t[2], t[1]] } else { t }));
        insert_straight_corners(n, first, out);
        let triangles = &out[first..];
        let sum: f64 = triangles.iter().map(area).sum();
        let slack = polygon_area * 1e-9;
        triangles.len() == n - 2 && triangles.iter().all(|t| area(t) >= -slack) && (sum - polygon_area).abs() <= slack
    }
}

/// Faces of more corners than this are looked at before they are cut, where that may take long.
const FEW: usize = 32;

/// Whether a face of many corners stands at most of its points more than once. One that is joined to its holes stands at some of them twice.
fn repeats(corners: &[u32], positions: &[[f64; 3]]) -> bool {
    if corners.len() <= FEW {
        return false;
    }
    // 0 and -0 are one coordinate.
    let bits = |v: &u32| positions[*v as usize].map(|c| (c + 0.0).to_bits());
    let mut points: Vec<[u64; 3]> = corners.iter().map(bits).collect();
    points.sort_unstable();
    points.dedup();
    2 * points.len() < corners.len()
}

/// Whether a polygon that winds counter-clockwise on the whole is seen to wind the other way around much of its box.
///
/// Triangles that all have the polygon's winding add up to its winding number at every point, so that nothing covers a polygon with a negative one
/// but triangles that are turned over. Corners scattered at random make such polygons, and ear clipping takes longest on them. The
/// points are the same for every polygon of one box; some of them would have to meet the slivers below the slack of [`Triangulator::clip_ears`] for a
/// wrong answer.
fn winds_backwards(flat: &[[f64; 2]]) -> bool {
    const FIRST: usize = 16;
    const ALL: usize = 64;
    const ENOUGH: usize = 8;
    let [low, high] = box_of(flat);
    let extent = [high[0] - low[0], high[1] - low[1]];
    let unsure = 1e-12 * extent[0] * extent[1];
    // Multiples of the powers of the plastic number lie evenly (M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
    let sample = |i: usize| {
        let at = |k: usize, step: f64| low[k] + extent[k] * (0.5 + i as f64 * step).fract();
        [at(0, 0.754_877_666_246_692_7), at(1, 0.569_840_290_998_053_2)]
    };
    let is_behind = |i: &usize| winding(flat, sample(*i), unsure).is_some_and(|number| number < 0);
    let first = (0..FIRST).filter(is_behind).count();
    first > 0 && first + (FIRST..ALL).filter(is_behind).count() >= ENOUGH
}

/// How often a polygon winds around a point; `None` where an edge passes it so closely that rounding could decide.
fn winding(flat: &[[f64; 2]], p: [f64; 2], unsure: f64) -> Option<i64> {
    let mut number = 0;
    let mut a = *flat.last()?;
    for &b in flat {
        if (a[1] <= p[1]) != (b[1] <= p[1]) {
            let side = area2(a, b, p);
            if side.abs() <= unsure {
                return None;
            }
            let is_upward = b[1] > p[1];
            if is_upward == (side > 0.0) {
                number += if is_upward { 1 } else { -1 };
            }
        }
        a = b;
    }
    Some(number)
}

/// The corners of the box around the points.
fn box_of(flat: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let [mut low, mut high] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for p in flat {
        (0..2).for_each(|k| (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k])));
    }
    [low, high]
}

/// Twice the area of the box around the points, which no polygon that goes around once has more of; with some slack for rounding.
fn box_area2(flat: &[[f64; 2]]) -> f64 {
    let [low, high] = box_of(flat);
    2.0 * (high[0] - low[0]) * (high[1] - low[1]) * (1.0 + 1e-9)
}

/// Put back the corners that ear clipping leaves out because they lie straight between their neighbours: the triangle on
/// that edge is cut into a fan. Without them the edge would not meet the edges of the face next to it.
fn insert_straight_corners(n: usize, first: usize, out: &mut Vec<[u32; 3]>) {
    let mut used = vec![false; n];
    out[first..].iter().flatten().for_each(|&v| used[v as usize] = true);
    let Some(start) = used.iter().position(|u| *u).filter(|_| used.contains(&false)) else { return };
    let mut edges: HashMap<[u32; 2], usize> = HashMap::new();
    for (i, t) in out.iter().enumerate().skip(first) {
        edges.extend((0..3).map(|k| ([t[k], t[(k + 1) % 3]], i)));
    }

    // Walk once around, from one used corner to the next, along the run of unused ones between them.
    let mut from = start;
    while from < start + n {
        let to = (from + 1..=start + n).find(|i| used[i % n]).unwrap_or(start + n);
        let corner = |i: usize| (i % n) as u32;
        if to > from + 1
            && let Some(&index) = edges.get(&[corner(from), corner(to)])
        {
            let t = out[index];
            let apex = t.iter().copied().find(|&v| v != corner(from) && v != corner(to)).unwrap_or(t[0]);
            out[index] = [corner(from), corner(from + 1), apex];
            edges.insert([corner(to), apex], out.len() + (to - from - 2));
            out.extend((from + 1..to).map(|i| [corner(i), corner(i + 1), apex]));
        }
        from = to;
    }
}

/// Whether the diagonal 1–3 cuts a quadrilateral well and 0–2 does not, judged along the face's normal.
fn prefers_other_diagonal(p: [[f64; 3]; 4]) -> bool {
    let normal = newell_normal(4, |i| p[i]);
    let turns_left = |a: usize, b: usize, c: usize| dot(normal, cross(sub(p[b], p[a]), sub(p[c], p[a]))) > 0.0;
    !(turns_left(0, 1, 2) && turns_left(0, 2, 3)) && turns_left(0, 1, 3) && turns_left(1, 2, 3)
}

/// The sum of the cross products around the polygon: its length is twice the area, its direction the best-fit plane's
/// (Newell; see Sutherland, Sproull and Schumacker, "A Characterization of Ten Hidden-Surface Algorithms", 1974).
fn newell_normal(n: usize, at: impl Fn(usize) -> [f64; 3]) -> [f64; 3] {
    let origin = at(0);
    let mut normal = [0.0; 3];
    for i in 1..n - 1 {
        let c = cross(sub(at(i), origin), sub(at(i + 1), origin));
        (0..3).for_each(|k| normal[k] += c[k]);
    }
    normal
}

/// Two rows that map a point to the plane, so that the polygon winds counter-clockwise there.
struct Projection([[f64; 3]; 2]);

impl Projection {
    /// Leave out the axis on which the normal is longest: the coordinates stay exact, so straight corners stay straight.
    fn drop_axis(normal: [f64; 3]) -> Option<Projection> {
        let axis = (0..3).max_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()))?;
        if !normal[axis].is_finite() || normal[axis] == 0.0 {
            return None;
        }
        let unit = |k: usize| [0, 1, 2].map(|i| if i == k { 1.0 } else { 0.0 });
        let (x, y) = (unit((axis + 1) % 3), unit((axis + 2) % 3));
        Some(Projection(if normal[axis] > 0.0 { [x, y] } else { [y, x] }))
    }

    /// Onto the best-fit plane itself, for faces so bent that the coordinate plane shows them crossing.
    fn onto_plane(normal: [f64; 3]) -> Option<Projection> {
        let Projection([x, _]) = Self::drop_axis(normal)?;
        let y = cross(normal, x);
        let unit = |v: [f64; 3]| {
            let length = dot(v, v).sqrt();
            (length.is_finite() && length > 0.0).then(|| v.map(|c| c / length))
        };
        let y = unit(y)?;
        Some(Projection([cross(y, unit(normal)?), y]))
    }

    fn apply(&self, p: [f64; 3]) -> [f64; 2] {
        [dot(self.0[0], p), dot(self.0[1], p)]
    }
}

/// Twice the signed area of a triangle in the plane.
fn area2(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests;
