//! `E02xx`: are the bytes those that were written?

use super::{FOREIGN_WRITER, rules};

const DAMAGE: &str = "A bit flipped in storage or transfer, or something edited the file.";

rules! {
    E0201 "stored-hash", "a section's bytes do not have the hash that the table states",
        "the BLAKE3 hash must be {expected}, the stored bytes have {actual}: the file is damaged", "9-hashes-and-keys",
        means "The section is not what was written. It is neither decompressed nor looked into.", because DAMAGE, remedy Rebuild;
    E0202 "raw-hash", "a section's decoded bytes do not have the hash that the table states",
        "the BLAKE3 hash must be {expected}, the decoded bytes have {actual}", "9-hashes-and-keys",
        means "The stored bytes are intact but decode to something else.",
        because "A writer error, or a broken decompressor.", remedy Rebuild;
    E0203 "file-id", "the header and section table do not have the stated file id",
        "file_id must be {expected}, header and table give {actual}: the file is damaged", "91-file_id",
        means "The header or the table changed after writing, so none of the other hashes can be believed either.",
        because DAMAGE, remedy Rebuild;
    E0204 "content-id", "the content sections do not have the stated content id",
        "content_id must be {expected}, the table gives {actual}", "92-content_id",
        means "Tools that compare files by content_id would take two different trees for the same one, or the same for two.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0205 "decode", "a compressed section cannot be decoded",
        "{expected}, but {actual}", "8-compression",
        means "The section's content is not available, and what depends on it was not checked.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0206 "meta-encoding", "the META section is not in its one valid encoding",
        "{expected}, but {actual}", "6-meta",
        means "Traversal works, but where the file came from and whether it is up to date cannot be told.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0207 "build-key", "the build key does not follow from META",
        "build_key must be {expected}, the header states {actual}", "93-build_key",
        means "The tool would take the file for up to date when it is not, or build it again each time.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0208 "names-encoding", "the NAMS section cannot be cut into names",
        "{expected}, but {actual}", "7-nams",
        means "Traversal works, but parts cannot be named.", because FOREIGN_WRITER, remedy Rebuild;
    E0209 "input-name", "META names an input by a path that is absolute on some system",
        "the name of input {expected} must be relative to the model's folder, it is {actual}", "6-meta",
        means "A tool that looks for the input would leave the model's folder, and the file depends on the machine that it was built on.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0210 "materials-encoding", "the MATS section cannot be cut into names",
        "{expected}, but {actual}", "1033-mats",
        means "Traversal works, but the materials of parts cannot be named.", because FOREIGN_WRITER, remedy Rebuild;
}
