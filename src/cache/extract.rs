//! One frame of a sequence becomes the content of a still file.

use super::{Frame, Frames, Image};

impl Image {
    /// What a still file of this frame holds: the same trees, triangles, parts and instances, numbered as in the frame.
    pub fn of_frame(sequence: &Frames<'_>, frame: &Frame<'_>) -> Image {
        let view = frame.view();
        let parts = || frame.parts().iter().map(|part| *part as usize);
        let named = |names: bvhc_core::layout::Names<'_>| -> Vec<String> {
            let some: Vec<String> = parts().map(|part| names.get(part).unwrap_or_default().to_owned()).collect();
            if some.iter().all(String::is_empty) { Vec::new() } else { some }
        };
        let sides: Vec<u32> = parts().map(|part| sequence.sides().get(part).copied().unwrap_or(0)).collect();

        // Rows of VERT are parallel to the triangles of all topologies.
        let mut vertices = Vec::new();
        for pose in frame.poses().iter().filter_map(|pose| sequence.poses().get(*pose as usize)) {
            let Some(topology) = sequence.topologies().get(pose.topology as usize) else { continue };
            let (start, count) = (topology.ref_offset as usize, topology.ref_count as usize);
            vertices.extend_from_slice(sequence.vertices().get(start..start + count).unwrap_or_default());
        }
        Image {
            nodes: view.nodes.to_vec(),
            triangles: view.triangles.to_vec(),
            geoms: view.geoms.to_vec(),
            blases: view.blases.to_vec(),
            tlas_nodes: view.tlas_nodes.to_vec(),
            instances: view.instances.to_vec(),
            names: named(sequence.names()),
            materials: named(sequence.materials()),
            sides: if sides.iter().all(|side| *side == 0) { Vec::new() } else { sides },
            vertices,
            compact: None,
            turns: None,
            flags: frame.tree_flags(),
        }
    }
}
