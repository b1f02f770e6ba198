//! The tree as the callbacks make it, in memory of Embree's allocator, and as records afterwards.

use crate::Scene;
use crate::api::{Allocator, Bounds, Primitive};
use std::ffi::{c_uint, c_void};

/// An inner node, or a leaf: both begin with the number of primitives, 0 for an inner node.
#[repr(C, align(16))]
struct Inner {
    count: u64,
    children: [*const Inner; 2],
    bounds: [Bounds; 2],
}

/// A leaf's head; the numbers of its primitives follow.
#[repr(C, align(16))]
struct Leaf {
    count: u64,
}

unsafe fn scene<'a>(user: *mut c_void) -> &'a Scene {
    // SAFETY: `user` is the scene given to `rtcBuildBVH`, which outlives the build and is never written.
    unsafe { &*user.cast::<Scene>() }
}

pub unsafe extern "C" fn create_node(allocator: Allocator, _: c_uint, user: *mut c_void) -> *mut c_void {
    // SAFETY: the allocator is that of the calling thread, as the interface says; it hands out aligned, writable memory.
    unsafe {
        let node = (scene(user).library.allocate)(allocator, size_of::<Inner>(), 16).cast::<Inner>();
        node.write(Inner { count: 0, children: [std::ptr::null(); 2], bounds: [Bounds::default(); 2] });
        node.cast()
    }
}

pub unsafe extern "C" fn set_node_children(
    node: *mut c_void,
    children: *mut *mut c_void,
    count: c_uint,
    _: *mut c_void,
) {
    // SAFETY: the node is one of ours, and there are `count` children, at most 2.
    unsafe {
        for i in 0..(count as usize).min(2) {
            (*node.cast::<Inner>()).children[i] = (*children.add(i)).cast();
        }
    }
}

pub unsafe extern "C" fn set_node_bounds(
    node: *mut c_void,
    bounds: *const *const Bounds,
    count: c_uint,
    _: *mut c_void,
) {
    // SAFETY: as for the children.
    unsafe {
        for i in 0..(count as usize).min(2) {
            (*node.cast::<Inner>()).bounds[i] = **bounds.add(i);
        }
    }
}

pub unsafe extern "C" fn create_leaf(
    allocator: Allocator,
    primitives: *const Primitive,
    count: usize,
    user: *mut c_void,
) -> *mut c_void {
    // SAFETY: `count` primitives are there to read, and the memory has room for the head and their numbers.
    unsafe {
        let bytes = size_of::<Leaf>() + 4 * count;
        let leaf = (scene(user).library.allocate)(allocator, bytes, 16).cast::<Leaf>();
        leaf.write(Leaf { count: count as u64 });
        let numbers = leaf.add(1).cast::<u32>();
        for i in 0..count {
            numbers.add(i).write((*primitives.add(i)).primitive);
        }
        leaf.cast()
    }
}

/// The boxes of a primitive's parts below and above a plane: its triangle's edges cut, and the result within the primitive's own box.
pub unsafe extern "C" fn split_primitive(
    primitive: *const Primitive,
    axis: c_uint,
    position: f32,
    left: *mut Bounds,
    right: *mut Bounds,
    user: *mut c_void,
) {
    // SAFETY: the primitive is one of the scene's, and both results are there to write.
    unsafe {
        let (p, axis) = (&*primitive, axis as usize);
        let corners = &scene(user).triangles[p.primitive as usize];
        let mut parts = [[[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]]; 2];
        let mut grow = |side: usize, point: [f32; 3]| {
            for k in 0..3 {
                parts[side][0][k] = parts[side][0][k].min(point[k]);
                parts[side][1][k] = parts[side][1][k].max(point[k]);
            }
        };
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            if a[axis] <= position {
                grow(0, a);
            }
            if a[axis] >= position {
                grow(1, a);
            }
            if (a[axis] < position && position < b[axis]) || (b[axis] < position && position < a[axis]) {
                let t = (position - a[axis]) / (b[axis] - a[axis]);
                let mut cut = [0, 1, 2].map(|k| a[k] + t * (b[k] - a[k]));
                cut[axis] = position;
                grow(0, cut);
                grow(1, cut);
            }
        }
        for (part, out) in parts.iter().zip([left, right]) {
            // The fourth components hold the primitive's numbers where the result is a primitive: they are not ours to write.
            (*out).lower = [0, 1, 2].map(|k| part[0][k].max(p.lower[k]));
            (*out).upper = [0, 1, 2].map(|k| part[1][k].min(p.upper[k]));
        }
    }
}

/// Number the nodes: pairs of siblings behind their parent, record 1 unused, leaves in depth-first order. The root's own box is
/// nowhere in the tree and comes with it.
///
/// # Safety
/// `root` comes from the callbacks above and its memory is still there.
pub unsafe fn flatten(root: *mut c_void, [lower, upper]: [[f32; 3]; 2]) -> (Vec<[u32; 8]>, Vec<u32>) {
    let (mut nodes, mut refs) = (vec![[0; 8]; 2], Vec::new());
    if root.is_null() {
        return (Vec::new(), refs);
    }
    let mut stack = vec![(0usize, root.cast_const().cast::<Inner>(), lower, upper)];
    while let Some((at, node, lower, upper)) = stack.pop() {
        // SAFETY: inner nodes and leaves both begin with the count, which tells them apart; both children are set.
        let (first, count) = unsafe {
            let count = (*node.cast::<Leaf>()).count as u32;
            if count > 0 {
                let first = refs.len() as u32;
                let numbers = node.cast::<Leaf>().add(1).cast::<u32>();
                refs.extend((0..count as usize).map(|i| *numbers.add(i)));
                (first, count)
            } else {
                let pair = nodes.len();
                nodes.resize(pair + 2, [0; 8]);
                for i in [1, 0] {
                    let b = &(*node).bounds[i];
                    stack.push((pair + i, (*node).children[i], b.lower, b.upper));
                }
                (pair as u32, 0)
            }
        };
        let [a, b] = [lower, upper].map(|v| v.map(f32::to_bits));
        nodes[at] = [a[0], a[1], a[2], first, b[0], b[1], b[2], count];
    }
    (nodes, refs)
}
