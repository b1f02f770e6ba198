//! How a file is opened.

/// How deeply a file is looked into when it is opened. Each level includes the ones before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Validation {
    /// Header, section table, tiling, `file_id`: the file is of this format, complete, and its parts are where they are said to be.
    /// Milliseconds for any size. Traversal of a damaged file then ends and touches no foreign memory, but may miss or invent hits.
    Quick,
    /// And the hash of every section: the bytes are those that were written.
    #[default]
    Hash,
    /// And every record: indices, tree shape, boxes, triangles, instances, counts. For files from strangers, who can hash
    /// anything.
    Tree,
}

/// How a file is opened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OpenOptions {
    /// What is checked before the file is handed out.
    pub validation: Validation,
    /// Map the file instead of reading it. A mapping is not a snapshot: whoever changes the file in place changes what is
    /// traced, and whoever shortens it ends the process (SIGBUS). This crate's writer does neither; turn mapping off for files
    /// that others may write.
    pub mmap: bool,
    /// Most bytes that decoded sections, without `mmap` the file, and of a sequence the frame that is put together may take.
    pub max_memory: u64,
}

impl OpenOptions {
    /// [`OpenOptions::max_memory`] unless another is given: 8 GiB.
    pub const DEFAULT_MAX_MEMORY: u64 = 8 << 30;
}

impl Default for OpenOptions {
    fn default() -> Self {
        OpenOptions { validation: Validation::default(), mmap: true, max_memory: Self::DEFAULT_MAX_MEMORY }
    }
}
