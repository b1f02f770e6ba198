use super::accessor::{self, Shape};
use super::nodes;
use super::reader::Reader;
use crate::geom::Affine;
use crate::scene::SceneError;

/// A skin: nodes as joints, and for each the way from the mesh's space into the joint's at binding.
pub(super) struct Skin {
    pub joints: Vec<u32>,
    inverse_binds: Vec<Affine>,
}

/// How far the last row of an inverse bind matrix may be from 0 0 0 1: exporters invert matrices in `f32`.
const SLACK: f64 = 1e-4;

impl Skin {
    /// Read a skin. Its memory is charged and stays charged. Joints are not yet known to be nodes.
    pub fn read(reader: &mut Reader, index: u32) -> Result<Skin, SceneError> {
        let json = reader.document.skin(index, reader.source)?;
        let joints: Vec<u32> = json.joints.iter().map(|j| j.0).collect();
        let count = joints.len();
        reader.source.charge((count * (size_of::<u32>() + size_of::<Affine>())) as u64, "the skins")?;
        let Some(accessor) = json.inverse_bind_matrices else {
            return Ok(Skin { joints, inverse_binds: vec![Affine::IDENTITY; count] });
        };
        let (accessor, before) = (accessor.0 as usize, reader.source.passing());
        let given = accessor::count(reader, accessor)?;
        if given < count as u64 {
            let reason = format!("skin {index} has {count} joints, but {given} inverse bind matrices");
            return Err(SceneError::malformed(reader.source.path, reason));
        }
        let matrices = accessor::numbers::<16>(reader, accessor, Shape::INVERSE_BIND)?;
        let source = &mut *reader.source;
        let bind = |(joint, matrix): (usize, &[f64; 16])| {
            nodes::affine(matrix, SLACK, &format!("inverse bind matrix {joint} of skin {index}"), source)
        };
        let inverse_binds = matrices.iter().take(count).enumerate().map(bind).collect::<Result<_, _>>()?;
        drop(matrices);
        source.release(source.passing() - before);
        Ok(Skin { joints, inverse_binds })
    }

    /// Each joint's transform from the mesh's space to world space, where `to_world` is that of each node.
    pub fn transforms(&self, to_world: &[Affine]) -> Vec<Affine> {
        let joints = self.joints.iter().zip(&self.inverse_binds);
        joints.map(|(joint, inverse_bind)| to_world[*joint as usize].then_inner(inverse_bind)).collect()
    }
}
