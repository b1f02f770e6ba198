use super::buffers::Buffers;
use super::document::Document;
use crate::scene::source::Source;

/// What every part of a model is read with.
pub(super) struct Reader<'r, 'b, 's> {
    pub document: &'r Document,
    pub buffers: &'r mut Buffers<'b>,
    pub source: &'r mut Source<'s>,
}
