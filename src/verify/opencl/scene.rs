use super::context::{Context, Parts};
use super::driver::{Arg, Buffer, Status};
use crate::cache::{TriangleRecord, View};
use crate::size;
use crate::tree::Node;
use crate::verify::DeviceError;
use bytemuck::Pod;

/// A view in a device's memory, or in the host's where the device reads that.
pub(super) struct Scene<'a> {
    pub parts: Parts,
    nodes: Vec<Buffer<'a>>,
    triangles: Vec<Buffer<'a>>,
    blases: Buffer<'a>,
    top_nodes: Buffer<'a>,
    instances: Buffer<'a>,
    node_count: u64,
    triangle_count: u64,
    blas_count: u32,
    top_count: u32,
    instance_count: u32,
    /// Bytes that were copied; 0 where all is read in place.
    pub copied: u64,
}

impl<'a> Scene<'a> {
    /// # Errors
    /// Where the device has too little memory.
    pub fn new(context: &Context, view: &View<'a>) -> Result<Scene<'a>, DeviceError> {
        let info = &context.info;
        let most = context.options.max_allocation.unwrap_or(u64::MAX).min(info.max_allocation);
        let mut upload = Upload { context, most, in_place: info.unified_memory && !context.options.copy, copied: 0 };

        // Refuse at once what cannot fit. Indices of slots and instances are 32 bits wide in the records.
        let total = [
            size_of_val(view.nodes),
            size_of_val(view.triangles),
            size_of_val(view.blases),
            size_of_val(view.tlas_nodes),
            size_of_val(view.instances),
        ];
        let total = total.into_iter().map(|bytes| bytes as u64).sum::<u64>();
        if total > info.global_memory && !upload.in_place {
            return Err(upload.too_large("the file's records", total, info.global_memory));
        }
        if view.triangles.len() > u32::MAX as usize {
            return Err(upload.too_many("TRIS", view.triangles.len()));
        }
        let parts = upload.parts(view);
        let nodes = upload.cut(view.nodes, parts.node_shift, parts.count, "NODE")?;
        let triangles = upload.cut(view.triangles, parts.triangle_shift, parts.count, "TRIS")?;
        Ok(Scene {
            parts,
            nodes,
            triangles,
            blases: upload.whole(view.blases, "BLAS")?,
            top_nodes: upload.whole(view.tlas_nodes, "TNOD")?,
            instances: upload.whole(view.instances, "INST")?,
            node_count: view.nodes.len() as u64,
            triangle_count: view.triangles.len() as u64,
            blas_count: upload.count(view.blases.len(), "BLAS")?,
            top_count: upload.count(view.tlas_nodes.len(), "TNOD")?,
            instance_count: upload.count(view.instances.len(), "INST")?,
            copied: upload.copied,
        })
    }

    /// The arguments that the kernels call `SCENE_PARAMETERS`.
    pub fn args(&self) -> Vec<Arg<'_>> {
        let buffers = self.nodes.iter().chain(&self.triangles).chain([&self.blases, &self.top_nodes, &self.instances]);
        let counts = [self.blas_count, self.top_count, self.instance_count];
        buffers
            .map(Arg::Buffer)
            .chain([self.node_count, self.triangle_count].map(Arg::U64))
            .chain(counts.map(Arg::U32))
            .collect()
    }
}

/// The way of records to the device.
struct Upload<'c> {
    context: &'c Context,
    /// Bytes that a buffer may have.
    most: u64,
    in_place: bool,
    copied: u64,
}

impl Upload<'_> {
    fn parts(&self, view: &View<'_>) -> Parts {
        let fits = |bytes: usize| bytes as u64 <= self.most;
        let shift = |record: usize| (self.most / record as u64).max(1).ilog2();
        let cut = !fits(size_of_val(view.nodes)) || !fits(size_of_val(view.triangles));
        if !cut {
            return Parts { count: 1, node_shift: 0, triangle_shift: 0 };
        }
        Parts {
            count: Parts::MANY,
            node_shift: shift(size_of::<Node>()),
            triangle_shift: shift(size_of::<TriangleRecord>()),
        }
    }

    /// A section as `count` buffers of 2^`shift` records; the last ones may be empty.
    fn cut<'a, T: Pod>(
        &mut self,
        records: &'a [T],
        shift: u32,
        count: u32,
        name: &str,
    ) -> Result<Vec<Buffer<'a>>, DeviceError> {
        if count == 1 {
            return Ok(vec![self.whole(records, name)?]);
        }
        let each = 1usize << shift;
        if records.len().div_ceil(each) > count as usize {
            let available = u64::from(count) * (each * size_of::<T>()) as u64;
            let what = format!("{name}, cut into {count} buffers of at most {}", size::bytes(self.most));
            return Err(self.too_large(&what, size_of_val(records) as u64, available));
        }
        let part = |i: usize| &records[(i * each).min(records.len())..((i + 1) * each).min(records.len())];
        (0..count as usize).map(|i| self.whole(part(i), name)).collect()
    }

    fn whole<'a, T: Pod>(&mut self, records: &'a [T], name: &str) -> Result<Buffer<'a>, DeviceError> {
        let (context, bytes) = (self.context, size_of_val(records));
        if bytes as u64 > self.most {
            return Err(self.too_large(name, bytes as u64, self.most));
        }
        // A device that shares memory may still refuse these pages; then they are copied like any other's.
        let aligned = records.as_ptr().addr().is_multiple_of(IN_PLACE_ALIGN);
        if self.in_place
            && aligned
            && bytes > 0
            && let Ok(buffer) = Buffer::share(&context.handle, records)
        {
            return Ok(buffer);
        }
        let copy = || -> Result<Buffer<'a>, Status> {
            let mut buffer = Buffer::new(&context.handle, bytes.max(16))?;
            buffer.write(&context.queue, 0, records)?;
            Ok(buffer)
        };
        self.copied += bytes as u64;
        copy().map_err(|status| context.no_room(status, name, bytes as u64))
    }

    fn count(&self, records: usize, name: &str) -> Result<u32, DeviceError> {
        records.try_into().map_err(|_| self.too_many(name, records))
    }

    fn too_many(&self, name: &str, records: usize) -> DeviceError {
        let (device, what) = (self.context.info.summary(), name.to_string());
        DeviceError::TooMany { device, what, count: records as u64, most: u32::MAX.into() }
    }

    fn too_large(&self, what: &str, needed: u64, available: u64) -> DeviceError {
        DeviceError::OutOfMemory { device: self.context.info.summary(), what: what.to_string(), needed, available }
    }
}

/// Kernels load 16 bytes at a time. A cache's sections start at multiples of 64, and large ones at a page, as some
/// devices want it to spare the copy.
const IN_PLACE_ALIGN: usize = 16;
