//! `E03xx`: do the numbers that stand in several places agree?

use super::{FOREIGN_WRITER, rules};

rules! {
    E0301 "node-total", "the header's node count is not the sum over the trees",
        "node_count must be {expected}, the header states {actual}", "2-header",
        means "What is told of the file without reading its trees is wrong.", because FOREIGN_WRITER, remedy Rebuild;
    E0302 "ref-total", "the header's reference count is not the number of TRIS records, in a sequence of TRIX records",
        "ref_count must be {expected}, the header states {actual}", "2-header",
        means "What is told of the file without reading its trees is wrong.", because FOREIGN_WRITER, remedy Rebuild;
    E0303 "prim-total", "the header's triangle count is not the sum over the trees",
        "prim_count must be {expected}, the header states {actual}", "2-header",
        means "What is told of the file without reading its trees is wrong.", because FOREIGN_WRITER, remedy Rebuild;
    E0304 "blas-total", "the header's tree count is not the number of BLAS records, in a sequence of TOPO records",
        "blas_count must be {expected}, the header states {actual}", "2-header",
        means "What is told of the file without reading its trees is wrong.", because FOREIGN_WRITER, remedy Rebuild;
    E0305 "instance-total", "the header's instance count is not the number of INST records",
        "instance_count must be {expected}, the header states {actual}", "2-header",
        means "What is told of the file without reading its trees is wrong.", because FOREIGN_WRITER, remedy Rebuild;
    E0306 "stated-depth", "the header's depth is not that of the deepest tree",
        "max_depth must be {expected}, the header states {actual}", "2-header",
        means "A reader that sizes its traversal stack by this number would overflow it or waste it.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0307 "scene-bounds", "the header's scene box is not the box of the root, in a sequence of all roots",
        "scene_bounds must be {expected}, the header states {actual}", "2-header",
        means "A renderer that places cameras or clips rays by this box would be wrong.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0308 "frame-total", "the header's frame count is not the number of FRAM records",
        "frame_count must be {expected}, the header states {actual}", "2-header",
        means "What is told of the file without reading its trees is wrong.", because FOREIGN_WRITER, remedy Rebuild;
    E0309 "flags-against-content", "the header's tree flags are not what the trees are",
        "tree_flags must be {expected}, the header states {actual}", "2-header",
        means "A reader would refit a file with clipped boxes, or miss the top level.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0310 "blas-node-range", "the trees do not tile the NODE section in order",
        "the tree must start at record {expected}, BLAS states {actual}", "54-blas-64-bytes",
        means "Two trees would share nodes, or nodes would belong to none. The tree was not checked.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0311 "blas-ref-range", "the trees do not tile the TRIS section in order",
        "the tree must start at record {expected}, BLAS states {actual}", "54-blas-64-bytes",
        means "Two trees would share triangles, or triangles would belong to none. The tree was not checked.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0312 "node-count", "a tree has a node count that no tree can have",
        "the node count must be {expected}, it is {actual}", "54-blas-64-bytes",
        means "A tree has a root, an unused record and pairs, hence an even count; it is empty exactly if it has no triangles.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0313 "tree-kind", "a tree's flags are not one of those that a tree can have",
        "the flags must be {expected}, BLAS states {actual}", "54-blas-64-bytes",
        means "Whether triangles may repeat in this tree is not certain.", because FOREIGN_WRITER, remedy Rebuild;
    E0314 "geom-blas", "a GEOM row names a tree that is not there, or the rows are not in the order of their trees",
        "the tree must be {expected}, GEOM states {actual}", "53-geom-64-bytes",
        means "Hits could not be mapped back to their source.", because FOREIGN_WRITER, remedy Rebuild;
    E0315 "geom-reserved", "the reserved field of a GEOM row is not zero",
        "reserved must be {expected}, it is {actual}", "53-geom-64-bytes",
        means "Either a writer error, or a use of this field that a newer version invented without saying so.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0316 "geom-range", "a GEOM row's primitive numbers do not fit 32 bits",
        "first_prim + prim_count must be at most {expected}, it is {actual}", "53-geom-64-bytes",
        means "Hits could not be mapped back to their source.", because FOREIGN_WRITER, remedy Rebuild;
    E0317 "trees-without-top", "a file without a top level has more than one tree",
        "at most {expected} tree without TWO_LEVEL, BLAS has {actual}", "2-header",
        means "The other trees could never be reached by a ray.", because FOREIGN_WRITER, remedy Rebuild;
    E0318 "geom-kept-count", "a GEOM row's count is not the number of its triangles in the file",
        "kept_count must be {expected}, GEOM states {actual}", "53-geom-64-bytes",
        means "Triangles of this part are missing or counted twice.", because FOREIGN_WRITER, remedy Rebuild;
    E0319 "blas-prim-count", "a tree's triangle count is not the number of different triangles in it",
        "prim_count must be {expected}, BLAS states {actual}", "54-blas-64-bytes",
        means "Triangles are missing or counted twice.", because FOREIGN_WRITER, remedy Rebuild;
    E0320 "part-name", "a part's name does not have the hash that GEOM states",
        "name_hash must be {expected}, GEOM states {actual}", "7-nams",
        means "Parts would be shown under the wrong names.", because FOREIGN_WRITER, remedy Rebuild;
    E0321 "vertex-count", "VERT has another number of records than TRIS, in a sequence than TRIX",
        "VERT must have {expected} records, it has {actual}", "1031-vert-12-bytes",
        means "The vertices of a hit's triangle could not be found.", because FOREIGN_WRITER, remedy Rebuild;
    E0322 "vertex-copies", "copies of one triangle have different vertices",
        "the vertices must be {expected}, VERT states {actual}", "1031-vert-12-bytes",
        means "Normals and texture coordinates at a hit would depend on the leaf in which the ray found the triangle.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0323 "vertex-position", "one vertex of a part stands in two places",
        "the vertex must be at {expected}, it is at {actual}", "1031-vert-12-bytes",
        means "Normals and texture coordinates would be taken from other vertices than the triangle's own.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0324 "side-records", "SIDE is not one word of known bits for each part",
        "SIDE must have {expected}, it has {actual}", "1032-side-4-bytes",
        means "Which side of a baked part is its front could not be told.", because FOREIGN_WRITER, remedy Rebuild;
    E0325 "side-unbaked", "a part is marked as mirrored that no node's transform was baked into",
        "a mirrored part must have {expected}, GEOM states {actual}", "1032-side-4-bytes",
        means "Normals would be turned around that need not be.", because FOREIGN_WRITER, remedy Rebuild;
    E0326 "compact-count", "the sections of compact trees are not all there, or have too few records or too many",
        "there must be {expected}, there are {actual}", "57-compact-trees",
        means "A reader would have to trace the binary trees, or would look for references that are not there.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0327 "compact-row", "a row of CROW is not what its tree is",
        "the row must state {expected}, it states {actual}", "57-compact-trees",
        means "Two trees would share nodes, nodes would belong to none, or a stack of the stated size would overflow.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0328 "part-numbers", "parts of one mesh have numbers of triangles in common, or one part has different ones",
        "the part must {expected}, but {actual}", "53-geom-64-bytes",
        means "Two triangles lead to one triangle of the model: to its normals, its material and its name.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0329 "turn-count", "the sections of turned subtrees are not both there, have another number of records, or are of no one tree",
        "there must be {expected}, there are {actual}", "58-turned-subtrees",
        means "A reader would look for nodes that are not there, or in the wrong tree.", because FOREIGN_WRITER, remedy Rebuild;
    E0330 "turn-row", "a row of OROW does not name what lies below a node",
        "the row must state {expected}, it states {actual}", "58-turned-subtrees",
        means "A ray would be turned at the wrong node, or meet the boxes of one subtree along the axes of another.",
        because FOREIGN_WRITER, remedy Rebuild;
}
