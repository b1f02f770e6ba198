//! The forms that the same trees can have: how wide nodes are and in how many bits their boxes stand, against bytes and rays a second. No form loses a hit,
//! which is counted here and not supposed.

use super::times::Times;
use crate::cache::Image;
use crate::geom::Ray;
use crate::trace::probe::{Camera, ProbeRays, SETS};
use crate::trace::wide::{Collapse, CompactTrees, WideTrees};
use crate::trace::{Hit, Malformed, any_hit, closest_hit};
use serde::Serialize;
use std::time::Instant;

/// One form of the trees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FormRow {
    /// Unique among the forms.
    pub name: &'static str,
    /// Children of a node.
    pub children: u32,
    /// Bits of each plane of a box.
    pub bits: u32,
    /// Of nodes, and of what leaves need beside the file's triangles to be traced: an order, or triangles in blocks.
    pub bytes_per_triangle: f64,
    /// Rays of three sets that are answered, in millions a second on one thread: the median of the rounds.
    pub mrays_per_second: f64,
    /// Seconds for all of these rays.
    pub trace: Times,
    /// Rays that were asked in each round.
    pub rays: u64,
    /// Of these, those that get another answer than in the binary trees, to the last bit of distance and place.
    pub lost: u64,
}

/// After so many rays it is asked whether to go on.
const ASKED: u64 = 1 << 10;

/// What a form says to a ray: its nearest hit, or whether there is any.
type Ask<'a> = Box<dyn Fn(&Ray, bool) -> Result<Answer, Malformed> + 'a>;
/// Bits of the nearest hit and the triangle that it names, or that there is one.
type Answer = Option<([u32; 3], [u32; 2])>;

fn ask<'a>(
    closest: impl Fn(&Ray) -> Result<Option<Hit>, Malformed> + 'a,
    any: impl Fn(&Ray) -> Result<bool, Malformed> + 'a,
) -> Ask<'a> {
    let told = |hit: Hit| ([hit.t, hit.u, hit.v].map(f32::to_bits), [hit.geom, hit.prim]);
    Box::new(move |ray, is_any| {
        Ok(if is_any { any(ray)?.then_some(([0; 3], [0; 2])) } else { closest(ray)?.map(told) })
    })
}

/// All forms of an image's trees, with about `rays` rays in each of three sets, in so many rounds that alternate over the forms; fewer where `goes_on` says so, and
/// none where that is before the first round ends.
///
/// # Errors
/// Where the trees are malformed.
pub fn forms(image: &Image, rays: usize, rounds: u32, goes_on: impl Fn() -> bool) -> Result<Vec<FormRow>, Malformed> {
    let view = image.view();
    let (collapse, triangles) =
        (Collapse::default(), view.blases.iter().map(|blas| f64::from(blas.prim_count)).sum::<f64>());
    let (four, eight) = (WideTrees::<4>::new(&view, &collapse)?, WideTrees::<8>::new(&view, &collapse)?);
    let compact = CompactTrees::new(&eight);
    let (four, eight, compact) = (four.view(&view), eight.view(&view), compact.view(&view));
    let wide =
        |nodes: usize, order: &[u32], blocks: usize| (nodes + size_of_val(order) + blocks) as f64 / triangles.max(1.0);
    let bytes = [
        wide(size_of_val(view.nodes), &[], 0),
        wide(size_of_val(four.nodes), four.order, size_of_val(four.blocks)),
        wide(size_of_val(eight.nodes), eight.order, size_of_val(eight.blocks)),
        wide(size_of_val(compact.nodes), compact.order, size_of_val(compact.blocks)),
    ];
    let heads = [("binary", 2, 32), ("4 children", 4, 32), ("8 children", 8, 32), ("8 children, compact", 8, 8)];
    let asks: [Ask<'_>; 4] = [
        ask(|ray| closest_hit(&view, ray), |ray| any_hit(&view, ray)),
        ask(|ray| four.closest_hit(ray), |ray| four.any_hit(ray)),
        ask(|ray| eight.closest_hit(ray), |ray| eight.any_hit(ray)),
        ask(|ray| compact.closest_hit(ray), |ray| compact.any_hit(ray)),
    ];

    let probe = ProbeRays::around_while(&view, &Camera::around(&view), rays, &goes_on);
    let all = || (0..SETS.len()).flat_map(|set| probe.rays(set).iter().map(move |ray| (ray, set == 2)));
    let (mut lost, mut count) = ([0u64; 4], 0);
    for (ray, is_any) in all() {
        if count % ASKED == 0 && !goes_on() {
            return Ok(Vec::new());
        }
        let want = asks[0](ray, is_any)?;
        for (lost, ask) in lost.iter_mut().zip(&asks) {
            *lost += u64::from(ask(ray, is_any)? != want);
        }
        count += 1;
    }
    let mut seconds = [const { Vec::new() }; 4];
    'rounds: for _ in 0..rounds {
        let mut round = [0.0; 4];
        for (seconds, ask) in round.iter_mut().zip(&asks) {
            let start = Instant::now();
            for (number, (ray, is_any)) in all().enumerate() {
                if (number as u64).is_multiple_of(ASKED) && !goes_on() {
                    break 'rounds;
                }
                std::hint::black_box(ask(ray, is_any)?);
            }
            *seconds = start.elapsed().as_secs_f64();
        }
        seconds.iter_mut().zip(round).for_each(|(all, one)| all.push(one));
    }
    if seconds[0].is_empty() {
        return Ok(Vec::new());
    }
    let row = |i: usize| {
        let ((name, children, bits), trace) = (heads[i], Times::of(&seconds[i]));
        let mrays_per_second = if trace.median_seconds > 0.0 { count as f64 / 1e6 / trace.median_seconds } else { 0.0 };
        FormRow {
            name,
            children,
            bits,
            bytes_per_triangle: bytes[i],
            mrays_per_second,
            trace,
            rays: count,
            lost: lost[i],
        }
    };
    Ok((0..heads.len()).map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::build::{BuildOptions, NoProgress};
    use crate::compile::compile;
    use crate::exec::Executor;
    use crate::scene::{ReadOptions, read};

    #[test]
    fn no_form_loses_a_hit_and_compact_nodes_are_the_smallest() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/helicopter/heli.0001.obj");
        let (scene, exec) = (read(&path, &ReadOptions::default()).unwrap(), Executor::sequential());
        let image = Image::new(&compile(scene, &BuildOptions::default(), &exec, &NoProgress).unwrap(), &exec).unwrap();
        let rows = forms(&image, 256, 2, || true).unwrap();
        assert_eq!(rows.iter().map(|row| row.lost).collect::<Vec<_>>(), [0; 4]);
        assert!(
            rows.iter().all(|row| row.rays > 300 && row.trace.rounds == 2 && row.mrays_per_second > 0.0),
            "{rows:?}"
        );
        let least = rows.iter().min_by(|a, b| a.bytes_per_triangle.total_cmp(&b.bytes_per_triangle)).unwrap();
        assert_eq!((least.name, least.bits), ("8 children, compact", 8));
        assert!(forms(&image, 256, 2, || false).unwrap().is_empty());
        assert_eq!(rows[0].bytes_per_triangle, size_of_val(&image.nodes[..]) as f64 / 4662.0);
    }
}
