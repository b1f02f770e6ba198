//! From a hit back to the model: what a file says of a triangle's source beyond its numbers.

use super::reader::Opened;
use super::records_by_id::RecordsById;
use crate::layout::{Names, side_flags};

impl Opened<'_> {
    /// The names of the parts, parallel to [`Cache::geoms`](Opened::geoms); empty where the file has none.
    pub fn names(&self) -> Names<'_> {
        self.strings(self.places.nams)
    }

    /// The name of a part, which [`Hit::geom`](crate::trace::Hit::geom) numbers; empty where it has none.
    pub fn name(&self, geom: u32) -> &str {
        self.names().get(geom as usize).unwrap_or_default()
    }

    /// The names of the parts' materials, parallel to [`Cache::geoms`](Opened::geoms); empty where the file has none.
    pub fn materials(&self) -> Names<'_> {
        self.strings(self.places.mats)
    }

    /// The name of a part's material; empty where it has none.
    pub fn material(&self, geom: u32) -> &str {
        self.materials().get(geom as usize).unwrap_or_default()
    }

    /// Which vertices of the source each triangle has, in the order `v0`, `v1`, `v2`: parallel to [`Cache::triangles`](Opened::triangles), so
    /// that [`Hit::triangle`](crate::trace::Hit::triangle) finds them. Empty where the file was built without them.
    ///
    /// Of a glTF model they are vertices of the primitive: indices into each of its accessors. Of an OBJ model they are corners of faces,
    /// counted from 0 over all `f` and `fo` statements of the file. Of arrays they are indices into the positions.
    pub fn vertices(&self) -> &[[u32; 3]] {
        let all: &[[u32; 3]] = self.records(self.places.vert);
        // A list of another length is of no use, and would be read beyond its end.
        if all.len() == self.triangles().len() { all } else { &[] }
    }

    /// Whether the transform that was baked into a part's positions mirrors. Then `(v1 − v0) × (v2 − v0)` points to the back.
    pub fn is_mirrored(&self, geom: u32) -> bool {
        let sides: &[u32] = self.records(self.places.side);
        sides.get(geom as usize).is_some_and(|side| side & side_flags::MIRRORED != 0)
    }

    /// The index in [`Cache::instances`](Opened::instances) of the instance that the scene numbers so, as hits do.
    pub fn instance_record(&self, id: u32) -> Option<usize> {
        self.by_id.get_or_init(|| RecordsById::new(self.instances())).record(id)
    }

    fn strings(&self, place: Option<usize>) -> Names<'_> {
        Names::new(place.and_then(|i| self.section_bytes(i)).unwrap_or_default())
    }
}
