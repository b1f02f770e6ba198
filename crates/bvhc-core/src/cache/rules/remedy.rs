use std::fmt;

/// What to do about a finding: data, so that a program can say it with the commands that it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Remedy {
    /// Build the file again from its model.
    Rebuild,
    /// Read the file by the version that wrote it or a later one, or build it again.
    Newer,
    /// Read the file by a program that was built with what decodes it (in Rust the crate's feature `zstd`), or by a later version; or store it raw.
    Decoder,
    /// See whether it is the file that was meant, and how it was copied; or build it again.
    RightFile,
    /// Allow more memory.
    MoreMemory,
    /// Nothing need be done; the section can be left out.
    LeaveOut,
    /// Build the file again from the model as it is now.
    RebuildFromSource,
}

impl Remedy {
    /// Every remedy.
    pub const ALL: [Remedy; 7] = [
        Remedy::Rebuild,
        Remedy::Newer,
        Remedy::Decoder,
        Remedy::RightFile,
        Remedy::MoreMemory,
        Remedy::LeaveOut,
        Remedy::RebuildFromSource,
    ];
}

/// In words that name no command.
impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Remedy::Rebuild => "Build the file again from its model. A cache is made again, never mended.",
            Remedy::Newer => {
                "Use the version that wrote the file, or a later one; or build the file again with this one."
            }
            Remedy::Decoder => {
                "Use a reader that was built with what decodes it, or a later version; or store the file's sections raw."
            }
            Remedy::RightFile => "Check the path; transfer caches as binary files; or build the file again.",
            Remedy::MoreMemory => {
                "Raise the limit if you trust the file. Sections that are not compressed are mapped and take none."
            }
            Remedy::LeaveOut => "Nothing, or leave the section out.",
            Remedy::RebuildFromSource => {
                "Build the file again. If the model has not changed and it still happens, please report it."
            }
        })
    }
}
