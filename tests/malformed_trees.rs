//! No tree, however broken, makes traversal panic, read out of bounds or run on: it ends with an error or with a bounded walk.

use bvhc::cache::{BlasRecord, InstanceRecord, TriangleRecord, View};
use bvhc::geom::{Aabb, Ray};
use bvhc::trace::{Counters, Malformed, any_hit, closest_hit, try_any_hit, try_closest_hit};
use bvhc::tree::Node;

const BOX: Aabb = Aabb { min: [-1.0; 3], max: [1.0; 3] };
const UNUSED: Node = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };

/// Beside the ray of `trace`, but in a box that it meets: what is walked is not cut short by a hit.
fn triangles(count: usize) -> Vec<TriangleRecord> {
    let [v0, v1, v2] = [[0.8, 0.8, 0.0], [0.9, 0.8, 0.0], [0.8, 0.9, 0.0]];
    (0..count as u32).map(|prim| TriangleRecord { v0, prim, v1, geom: 0, v2, flags: 0 }).collect()
}

fn blas(nodes: usize, refs: usize) -> BlasRecord {
    BlasRecord { node_count: nodes as u32, ref_count: refs as u32, ..bytemuck::Zeroable::zeroed() }
}

/// Both questions with their counters; they must agree, and the forms without an observer must say the same.
fn trace(view: &View<'_>) -> (Result<bool, Malformed>, Counters) {
    let ray = Ray::new([0.01, 0.02, -5.0], [0.001, 0.002, 1.0]);
    let (mut closest, mut any) = (Counters::default(), Counters::default());
    let hit = try_closest_hit(view, &ray, &mut closest);
    #[cfg(feature = "opencl")]
    opencl_agrees(view, ray, hit);
    assert_eq!(try_any_hit(view, &ray, &mut any), hit.map(|h| h.is_some()));
    // The short forms hide nothing: a miss is told apart from a tree that cannot be walked.
    assert_eq!((closest_hit(view, &ray), any_hit(view, &ray)), (hit, hit.map(|h| h.is_some())));
    assert_eq!(closest, any);
    (hit.map(|h| h.is_some()), closest)
}

/// The kernels end on the same trees with the same words, where there is a device.
#[cfg(feature = "opencl")]
fn opencl_agrees(view: &View<'_>, ray: Ray, hit: Result<Option<bvhc::trace::Hit>, Malformed>) {
    use bvhc::verify::opencl::{Context, OpenCl, Options, list_devices, preferred};
    use bvhc::verify::{Device, DeviceError, HitRecord, Query};
    static CONTEXT: std::sync::OnceLock<Option<Context>> = std::sync::OnceLock::new();
    let open = || {
        let devices = list_devices().inspect_err(|error| println!("skipped on OpenCL: {error}")).ok()?;
        Some(Context::open(preferred(&devices)?.index, Options::default()).expect("it opens"))
    };
    let Some(context) = CONTEXT.get_or_init(open) else { return };
    let mut device = OpenCl::new(context, *view).expect("memory");
    for query in [Query::Closest, Query::Any] {
        let answer = |hit: Option<_>| match query {
            Query::Closest => HitRecord::from(hit),
            Query::Any => HitRecord::any(hit.is_some()),
        };
        match (device.trace(&[ray], query), hit) {
            (Ok(records), Ok(hit)) => assert_eq!(records, [answer(hit)]),
            (Err(DeviceError::Malformed { malformed, .. }), Err(want)) => assert_eq!(malformed, want),
            (got, want) => panic!("{got:?}, not {want:?}"),
        }
    }
}

fn trace_one_level(nodes: &[Node], refs: usize) -> (Result<bool, Malformed>, Counters) {
    let (triangles, blases) = (triangles(refs), [blas(nodes.len(), refs)]);
    trace(&View { nodes, triangles: &triangles, geoms: &[], blases: &blases, tlas_nodes: &[], instances: &[] })
}

fn trace_two_levels(tlas_nodes: &[Node], blas_index: u32) -> (Result<bool, Malformed>, Counters) {
    let (nodes, triangles, blases) = ([Node::leaf(BOX, 0, 1), UNUSED], triangles(1), [blas(2, 1)]);
    let world_to_object = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let instance = InstanceRecord { blas: blas_index, world_to_object, ..bytemuck::Zeroable::zeroed() };
    trace(&View {
        nodes: &nodes,
        triangles: &triangles,
        geoms: &[],
        blases: &blases,
        tlas_nodes,
        instances: &[instance],
    })
}

#[test]
fn cycles_end() {
    // The root's first child is the root's twin: its children are the pair that it stands in.
    let nodes = [Node::inner(BOX, 2), UNUSED, Node::inner(BOX, 2), Node::leaf(BOX, 0, 1)];
    let (result, counters) = trace_one_level(&nodes, 1);
    assert_eq!(result, Err(Malformed::NotATree { nodes: 4 }));
    assert!(counters.inner_nodes <= 3);

    // Two pairs that name each other, and a root that names itself.
    let nodes = [Node::inner(BOX, 2), UNUSED, Node::inner(BOX, 4), UNUSED, Node::inner(BOX, 2), UNUSED];
    assert!(trace_one_level(&nodes, 1).0.is_err());
    assert!(trace_one_level(&[Node::inner(BOX, 0), UNUSED], 1).0.is_err());
}

#[test]
fn a_ladder_of_shared_children_does_not_take_exponential_time() {
    // Both nodes of each pair name the next pair: 2⁶⁰ paths.
    let mut nodes = vec![Node::inner(BOX, 2), UNUSED];
    for level in 1..60 {
        nodes.extend([Node::inner(BOX, 2 * level + 2); 2]);
    }
    nodes.extend([Node::leaf(BOX, 0, 1); 2]);
    let (result, counters) = trace_one_level(&nodes, 1);
    assert_eq!(result, Err(Malformed::NotATree { nodes: nodes.len() }));
    assert!(counters.inner_nodes as usize <= nodes.len());

    // A chain deeper than any file's tree runs out of stack instead.
    let mut nodes = vec![Node::inner(BOX, 2), UNUSED];
    for level in 1..200 {
        nodes.extend([Node::inner(BOX, 2 * level + 2), Node::leaf(BOX, 0, 1)]);
    }
    nodes.extend([Node::leaf(BOX, 0, 1); 2]);
    assert_eq!(trace_one_level(&nodes, 1).0, Err(Malformed::TooDeep));
}

#[test]
fn children_out_of_range_are_refused() {
    // The last: a pair of which only the first record is there.
    for first in [4, 5, 1 << 31, u32::MAX, 3] {
        let nodes = [Node::inner(BOX, first), UNUSED, Node::leaf(BOX, 0, 1), Node::leaf(BOX, 0, 1)];
        assert_eq!(trace_one_level(&nodes, 1).0, Err(Malformed::ChildOutOfRange { first, nodes: 4 }));
    }
}

#[test]
fn leaves_out_of_range_are_refused() {
    for (first, count) in [(0, 301), (300, 1), (301, 1), (u32::MAX, 1), (1, u32::MAX), (u32::MAX, u32::MAX), (0, 256)] {
        let result = trace_one_level(&[Node::leaf(BOX, first, count), UNUSED], 300).0;
        assert_eq!(result, Err(Malformed::LeafOutOfRange { first, count, refs: 300 }));
    }
    assert_eq!(trace_one_level(&[Node::leaf(BOX, 45, 255), UNUSED], 300).0, Ok(false));
}

#[test]
fn the_top_level_is_as_careful() {
    assert_eq!(trace_two_levels(&[Node::leaf(BOX, 0, 1), UNUSED], 0).0, Ok(false));
    assert!(trace_two_levels(&[Node::inner(BOX, 0), UNUSED], 0).0.is_err());
    let looped = [Node::inner(BOX, 2), UNUSED, Node::inner(BOX, 2), Node::leaf(BOX, 0, 1)];
    assert_eq!(trace_two_levels(&looped, 0).0, Err(Malformed::NotATree { nodes: 4 }));
    let out = Malformed::LeafOutOfRange { first: 1, count: 1, refs: 1 };
    assert_eq!(trace_two_levels(&[Node::leaf(BOX, 1, 1), UNUSED], 0).0, Err(out));
    for blas in [1, u32::MAX] {
        let refused = Err(Malformed::BlasOutOfRange { instance: 0, blas });
        assert_eq!(trace_two_levels(&[Node::leaf(BOX, 0, 1), UNUSED], blas).0, refused);
    }
}

#[test]
fn blas_ranges_out_of_their_sections_are_refused() {
    let (nodes, triangles) = ([Node::leaf(BOX, 0, 1), UNUSED], triangles(1));
    for broken in [
        BlasRecord { node_count: 3, ..blas(2, 1) },
        BlasRecord { ref_count: 2, ..blas(2, 1) },
        BlasRecord { node_offset: u64::MAX, ..blas(2, 1) },
        BlasRecord { ref_offset: u64::MAX - 1, ..blas(2, 1) },
    ] {
        let view = View {
            nodes: &nodes,
            triangles: &triangles,
            geoms: &[],
            blases: &[broken],
            tlas_nodes: &[],
            instances: &[],
        };
        assert_eq!(trace(&view).0, Err(Malformed::BlasOutOfRange { instance: 0, blas: 0 }));
    }
}

#[test]
fn boxes_and_triangles_of_no_number_end_in_a_bounded_walk() {
    for v in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -f32::MAX, 1e-45] {
        for (min, max) in
            [([v; 3], [v; 3]), ([v, -1.0, -1.0], [1.0; 3]), ([-1.0; 3], [1.0, v, 1.0]), ([1.0; 3], [v; 3])]
        {
            let strange = Aabb { min, max };
            for root in [BOX, strange] {
                let nodes = [Node::inner(root, 2), UNUSED, Node::leaf(strange, 0, 1), Node::leaf(BOX, 1, 1)];
                let (result, counters) = trace_one_level(&nodes, 2);
                assert_eq!(result, Ok(false), "{strange:?}");
                assert!(counters.inner_nodes <= 1 && counters.triangles <= 2);
            }
            let corners = [min, max, [v, 0.5, v]];
            let [v0, v1, v2] = corners;
            let triangles = [TriangleRecord { v0, prim: 0, v1, geom: 0, v2, flags: 0 }];
            let (nodes, blases) = ([Node::leaf(strange, 0, 1), UNUSED], [blas(2, 1)]);
            let view = View {
                nodes: &nodes,
                triangles: &triangles,
                geoms: &[],
                blases: &blases,
                tlas_nodes: &[],
                instances: &[],
            };
            assert!(trace(&view).0.is_ok(), "{strange:?}");
        }
    }
}
