use super::buffers::Buffers;
use super::document::Document;
use crate::scene::source::Source;

/// What every part of a model is read with.
pub(super) struct Reader<'d, 's> {
    pub document: &'d Document,
    pub buffers: Buffers<'d>,
    pub source: &'d mut Source<'s>,
}
