use crate::exec::Executor;
use crate::geom::Aabb;
use crate::scene::Mesh;
use crate::simd::{LaneBox, Lanes};

/// A primitive reference: the box of a primitive, or of the part of it that belongs to a node.
///
/// References themselves are moved during partition rather than an index array, so that every later pass over a node is
/// a linear read (the reason for the speed of Embree's builders: Wald et al., "Embree: A Kernel Framework for Efficient
/// CPU Ray Tracing", 2014). One is two 16-byte vectors and half a cache line.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct PrimRef {
    pub min: [f32; 3],
    /// The triangle of the mesh or the instance of the scene.
    pub prim: u32,
    pub max: [f32; 3],
    /// The strategy's own note; 0 at the start.
    pub extra: u32,
}

const _: () = assert!(size_of::<PrimRef>() == 32);

impl PrimRef {
    /// The box with the two integers in the fourth lanes.
    #[inline(always)]
    pub(super) fn lanes(&self) -> LaneBox {
        *bytemuck::cast_ref(self)
    }

    /// Negative zeros become positive ones: minima and maxima then have the same bits in whatever order they are taken.
    #[inline]
    pub fn new(bounds: &Aabb, prim: u32) -> PrimRef {
        PrimRef { min: bounds.min.map(|v| v + 0.0), prim, max: bounds.max.map(|v| v + 0.0), extra: 0 }
    }

    #[inline]
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.min, max: self.max }
    }

    /// See [`Aabb::center2`].
    #[inline]
    pub fn center2(&self) -> [f32; 3] {
        self.bounds().center2()
    }
}

/// References with the boxes that the root needs.
#[derive(Clone, Debug)]
pub struct PrimRefs {
    pub refs: Vec<PrimRef>,
    /// Union of the references' boxes.
    pub bounds: Aabb,
    /// Box of the references' [`PrimRef::center2`].
    pub centroids: Aabb,
}

/// Bounds and centroid bounds of some references.
pub fn bounds_of(refs: &[PrimRef]) -> (Aabb, Aabb) {
    let (bounds, centroids) = refs.iter().fold((LaneBox::EMPTY, LaneBox::EMPTY), |(b, c), r| {
        let r = r.lanes();
        (b.union(r), c.grow(r.min.plus(r.max)))
    });
    (bounds.aabb(), centroids.aabb())
}

/// References a task makes at once. A constant, so that nothing depends on the number of threads.
const CHUNK: usize = 1 << 14;

impl PrimRefs {
    /// One reference per triangle, in order, followed by `slack` empty slots for the duplicates of spatial splits.
    pub fn of_mesh(mesh: &Mesh, slack: usize, exec: &Executor) -> PrimRefs {
        let count = mesh.triangles.len();
        PrimRefs::generate(count, slack, exec, |i| {
            let [a, b, c] = mesh.triangles[i].map(|v| Lanes::of_point(mesh.positions[v as usize]));
            let bounds = LaneBox { min: a.min(b).min(c), max: a.max(b).max(c) };
            PrimRef::new(&bounds.aabb(), i as u32)
        })
    }

    /// One reference per box, in order.
    pub fn of_boxes(boxes: &[Aabb], exec: &Executor) -> PrimRefs {
        PrimRefs::generate(boxes.len(), 0, exec, |i| PrimRef::new(&boxes[i], i as u32))
    }

    /// References that stand already.
    pub fn of_refs(refs: Vec<PrimRef>, exec: &Executor) -> PrimRefs {
        let boxes = exec.map_chunks(&refs, CHUNK, |_, chunk| bounds_of(chunk));
        let (bounds, centroids) = join(boxes);
        PrimRefs { refs, bounds, centroids }
    }

    fn generate(count: usize, slack: usize, exec: &Executor, make: impl Fn(usize) -> PrimRef + Sync) -> PrimRefs {
        // Cleared by one thread, since allocators hand out memory of this alignment uncleared; that costs little beside what follows.
        let mut refs: Vec<PrimRef> = bytemuck::zeroed_vec(count + slack);
        let boxes = exec.map_chunks_mut(&mut refs[..count], CHUNK, |chunk_index, chunk| {
            for (i, slot) in chunk.iter_mut().enumerate() {
                *slot = make(chunk_index * CHUNK + i);
            }
            bounds_of(chunk)
        });
        let (bounds, centroids) = join(boxes);
        PrimRefs { refs, bounds, centroids }
    }
}

/// The common box of boxes, and of centroid boxes.
fn join(boxes: Vec<(Aabb, Aabb)>) -> (Aabb, Aabb) {
    boxes.iter().fold((Aabb::EMPTY, Aabb::EMPTY), |(b, c), x| (b.union(x.0), c.union(x.1)))
}
