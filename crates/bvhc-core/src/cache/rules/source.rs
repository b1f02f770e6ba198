//! `E06xx`: is this the tree of that model?

use super::rules;

const STALE: &str =
    "The model changed after the file was built, or it is another model, or the file was built with other options.";

rules! {
    E0601 "source-triangle-missing", "a triangle of the source is not in the file",
        "the file must have {expected}, but {actual}", "11-safety",
        means "Rays would miss it: a hole in the picture.", because STALE, remedy RebuildFromSource;
    E0602 "source-triangle-extra", "the file has a triangle that the source does not have",
        "the source has {expected}, the file {actual}", "11-safety",
        means "Rays would hit what is not there.", because STALE, remedy RebuildFromSource;
    E0603 "source-corners", "a triangle's corners are not those of the source",
        "the corners must be {expected}, they are {actual}", "11-safety",
        means "The geometry of the file is not that of the model.", because STALE, remedy RebuildFromSource;
    E0604 "source-parts", "the GEOM rows are not the parts of the source",
        "{expected}, but {actual}", "11-safety",
        means "Hits would be mapped back to the wrong part.", because STALE, remedy RebuildFromSource;
    E0605 "source-instances", "the instances are not those of the source",
        "{expected}, but {actual}", "11-safety",
        means "Something stands at the wrong place, is missing, or should not be there.", because STALE, remedy RebuildFromSource;
    E0606 "source-input", "META does not tell of the source: of its files, or of instances that were left out",
        "{expected}, but {actual}", "11-safety",
        means "The file was built from other bytes; if nothing else was found, the change did not touch the geometry. Where counts differ, a reader takes another element of an instance.",
        because STALE, remedy RebuildFromSource;
    E0607 "source-vertices", "a triangle's vertices are not those of the source",
        "{expected}, but {actual}", "11-safety",
        means "Normals and texture coordinates at hits would be taken from other vertices than the triangle's own.",
        because STALE, remedy RebuildFromSource;
}
