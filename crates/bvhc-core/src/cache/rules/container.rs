//! `E01xx`: can the file be cut into sections at all?

use super::{FOREIGN_WRITER, rules};

const DAMAGE: &str = "The file was cut short, joined with another, or damaged in storage or transfer.";

rules! {
    E0101 "file-too-short", "the file is shorter than a header",
        "a cache file has at least {expected} bytes, this one has {actual}", "2-header",
        means "Nothing can be read: the first 256 bytes say what everything else is.",
        because "The copy was interrupted, or the file is something else.", remedy Rebuild;
    E0102 "bad-magic", "the file does not start with the signature of a cache",
        "this is no cache file: its first 8 bytes are {actual}, and those of a cache {expected}", "2-header",
        means "This is another kind of file, or a transfer in text mode changed line ends or cut the eighth bit.",
        because "A wrong path, or a transfer in text mode (FTP, or version control that translates line ends).",
        remedy RightFile;
    E0103 "unsupported-major", "the file has another major version of the format",
        "this reader knows major version {expected}, the file has version {actual}", "12-versions",
        means "The meaning of the bytes has changed; nothing beyond the version can be read.",
        because "A much older or newer bvhc wrote it.", remedy Newer;
    E0104 "newer-reader-needed", "the file asks for a newer reader",
        "this reader has version {expected}, the file asks for version {actual} or later", "12-versions",
        means "The writer used something that readers before that version misread.",
        because "A newer bvhc wrote it.", remedy Newer;
    E0105 "header-length", "the header has an impossible length",
        "header_len must be {expected}, it is {actual}", "2-header",
        means "The section table cannot be found.", because DAMAGE, remedy Rebuild;
    E0106 "file-length", "the file is not as long as its header says",
        "the header states {expected} bytes, the file has {actual}", "2-header",
        means "Something is missing at the end, or something was appended.",
        because "The copy was interrupted, or something was appended.", remedy Rebuild;
    E0107 "unknown-required-feature", "the file needs a feature that this reader does not know",
        "known required features are {expected}, the file requires {actual}", "12-versions",
        means "Reading on would misread the file.", because "A newer bvhc wrote it.", remedy Newer;
    E0108 "section-count", "the file states more sections than may be",
        "at most {expected} sections, the header states {actual}", "11-safety",
        means "The count is refused before anything is sized by it.", because FOREIGN_WRITER, remedy Rebuild;
    E0109 "section-entry-length", "the section table has entries of another size",
        "section_entry_len must be {expected}, it is {actual}", "3-section-table",
        means "The section table cannot be read.", because DAMAGE, remedy Rebuild;
    E0110 "section-table-place", "the section table does not lie behind the header, inside the file",
        "the table must be {expected}, the header puts it {actual}", "3-section-table",
        means "The section table cannot be read.", because DAMAGE, remedy Rebuild;
    E0111 "header-reserved", "reserved bytes of the header are not zero",
        "bytes 224 to 255 must be {expected}, byte {actual}", "2-header",
        means "Either damage, or a use of these bytes that a newer version invented without saying so in features_required.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0112 "section-reserved", "reserved bytes of a section's entry are not zero",
        "bytes 52 to 63 of the entry must be {expected}, byte {actual}", "3-section-table",
        means "Either damage, or a use of these bytes that a newer version invented without saying so.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0113 "unknown-critical-section", "the file has a section that a reader must understand and this one does not",
        "a critical section must be one of {expected}, this one is {actual}", "3-section-table",
        means "Skipping it would give wrong answers, so the whole file is refused.",
        because "A newer bvhc wrote it.", remedy Newer;
    E0114 "unknown-schema", "a known section has a layout that this reader does not know",
        "the section is stored with {actual}; this reader knows {expected}", "3-section-table",
        means "Its records cannot be interpreted.", because "A newer bvhc wrote it.", remedy Newer;
    E0115 "unknown-codec", "a section is stored with a codec that this reader does not know",
        "this reader knows {expected}, the section has {actual}", "8-compression",
        means "Its bytes cannot be decoded.",
        because "A newer bvhc wrote it, or this reader was built without what decodes it.", remedy Decoder;
    E0116 "section-alignment", "a section does not start on the boundary that it states",
        "{expected}, but {actual}", "3-section-table",
        means "Mapped records would be misaligned for readers that rely on it, such as a GPU upload without a copy.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0117 "section-out-of-file", "a section reaches beyond the end of the file",
        "the section must end by byte {expected}, it ends at {actual}", "3-section-table",
        means "Its bytes are not there.", because DAMAGE, remedy Rebuild;
    E0118 "section-overlap", "sections overlap or are not in the order of their offsets",
        "the section must start at byte {expected} or later, it starts at {actual}", "4-tiling",
        means "One byte would be two things at once; two readers could see two files in one.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0119 "padding-not-zero", "padding between sections is not zero",
        "padding bytes must be {expected}, byte {actual}", "4-tiling",
        means "Something hides between the sections where no hash reaches it.", because DAMAGE, remedy Rebuild;
    E0120 "gap-too-long", "there is more padding than alignment needs",
        "{expected}, but {actual}", "4-tiling",
        means "The sections must tile the file, so that every byte belongs to something that is hashed.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0121 "duplicate-section", "two sections have the same type and ordinal",
        "each type and ordinal once, but {actual} is the second (the first is entry {expected})", "3-section-table",
        means "Two readers could pick different ones.", because FOREIGN_WRITER, remedy Rebuild;
    E0122 "element-size", "a known section has records of another size",
        "records of this type have {expected} bytes, the entry states {actual}", "3-section-table",
        means "Its records cannot be interpreted.", because FOREIGN_WRITER, remedy Rebuild;
    E0123 "section-size", "a section's lengths do not agree with each other",
        "{expected}, but {actual}", "3-section-table",
        means "The number of records is not certain, so none is read.", because FOREIGN_WRITER, remedy Rebuild;
    E0124 "section-flags", "a section's flags are not those of its type",
        "the flags must be {expected}, they are {actual}", "3-section-table",
        means "A tool that copies files by these flags would lose or keep the wrong sections, or leave data out of content_id.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0125 "missing-section", "a section that every such file has is missing",
        "the file must have {expected}, it has {actual}", "5-sections",
        means "Without it nothing can be traversed.", because FOREIGN_WRITER, remedy Rebuild;
    E0126 "tree-flags", "the header's tree flags contradict each other or are unknown",
        "{expected}, but tree_flags is {actual}", "2-header",
        means "Whether triangles may repeat, and whether there is a top level, is not certain.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0127 "memory-limit", "decoding or checking the file would take more memory than allowed or free",
        "at most {expected}, but {actual}", "11-safety",
        means "The file may be sound, but it was not decoded, or not all of it was checked. What decoding takes is summed up from the section table before anything is allocated.",
        because "A large compressed scene, or a small file made to fill memory.",
        remedy MoreMemory;
    E0128 "version-order", "the writer's version is older than the version it asks for",
        "a file that asks for version {expected} must be of that version or later, and it states {actual}", "12-versions",
        means "The version numbers cannot both be true, and one of them is beyond this reader: nothing behind them can be trusted to mean what it seems to.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0129 "section-too-large", "a section is larger than its type may be",
        "at most {expected}, but {actual}", "11-safety",
        means "It is refused before anything is sized by it.", because FOREIGN_WRITER, remedy Rebuild;
    E0130 "reader-version", "a file says that a reader can read it that does not know what it needs",
        "min_minor of a sequence must be at least 2, and with a section of codec 2 at least 3: {expected}; it is {actual}", "12-versions",
        means "A reader that goes by the version alone would take the file for a broken one, and not for one that it cannot read.",
        because FOREIGN_WRITER, remedy Rebuild;
    W0101 "unchecked-section", "a section is of a kind that this version cannot read",
        "known are {expected}; {actual} was hashed but not looked into", "3-section-table",
        means "The file is usable: the section says of itself that it may be skipped.",
        because "A newer bvhc, or another tool, added something of its own.",
        remedy LeaveOut;
}
