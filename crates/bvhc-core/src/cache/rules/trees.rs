//! `E04xx`: is each tree a tree, do its boxes contain what they must, are its triangles sound?

use super::{FOREIGN_WRITER, rules};

rules! {
    E0401 "child-odd", "an inner node's first child is not an even record behind the unused one",
        "the first child must be {expected}, it is {actual}", "51-node-and-tnod-32-bytes",
        means "Siblings would not share a cache line, and two pairs could overlap.", because FOREIGN_WRITER, remedy Rebuild;
    E0402 "node-child-order", "an inner node's children do not lie behind it",
        "the first child must be > {expected}, it is {actual}", "51-node-and-tnod-32-bytes",
        means "The tree could contain a cycle, and a traversal would never end.", because FOREIGN_WRITER, remedy Rebuild;
    E0403 "child-out-of-range", "an inner node's children lie beyond the end of the tree",
        "the last child must be < {expected}, it is {actual}", "51-node-and-tnod-32-bytes",
        means "A traversal that does not check would read memory that is not the tree.", because FOREIGN_WRITER, remedy Rebuild;
    E0404 "pair-claimed-twice", "two inner nodes have the same children",
        "each pair has {expected} parent, this pair already belongs to node {actual}", "51-node-and-tnod-32-bytes",
        means "It is no tree. A ladder of 64 such pairs is in range and without cycle, yet takes 2^64 visits to traverse.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0405 "pair-unclaimed", "a pair of nodes has no parent",
        "each pair has {expected} parent, this pair has {actual}", "51-node-and-tnod-32-bytes",
        means "Part of the tree cannot be reached: rays would miss what is in it.", because FOREIGN_WRITER, remedy Rebuild;
    E0406 "too-deep", "a tree is deeper than a traversal stack",
        "the depth may be at most {expected}, this node's children have {actual}", "11-safety",
        means "A traversal with the promised stack of 64 would overflow it.", because FOREIGN_WRITER, remedy Rebuild;
    E0407 "blas-depth", "a tree's stated depth is not its depth",
        "max_depth must be {expected}, BLAS states {actual}", "54-blas-64-bytes",
        means "A reader that sizes its traversal stack by this number would overflow it or waste it.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0408 "leaf-out-of-range", "a leaf's range reaches beyond the end of the list",
        "the range must end by {expected}, it ends at {actual}", "51-node-and-tnod-32-bytes",
        means "A traversal that does not check would read memory that is not the list.", because FOREIGN_WRITER, remedy Rebuild;
    E0409 "leaf-order", "the leaves do not tile the list in depth-first order",
        "the leaf must start at {expected}, it starts at {actual}", "51-node-and-tnod-32-bytes",
        means "An item stands in two leaves' ranges or in none.", because FOREIGN_WRITER, remedy Rebuild;
    E0410 "leaf-too-large", "a leaf has more items than a leaf may have",
        "at most {expected}, but {actual}", "11-safety",
        means "Readers that keep the count in 8 bits would lose triangles.", because FOREIGN_WRITER, remedy Rebuild;
    E0411 "child-outside", "a node's box does not lie inside its parent's",
        "the parent has {expected}, the child {actual}", "51-node-and-tnod-32-bytes",
        means "Rays that miss the parent would not find what is in the child: holes in the picture.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0412 "node-box", "a node's box is not finite, or its minimum is above its maximum",
        "a box must be {expected}, but {actual}", "51-node-and-tnod-32-bytes",
        means "Box tests with it give arbitrary answers.", because FOREIGN_WRITER, remedy Rebuild;
    E0413 "unused-record", "the unused record 1 of a tree is not zero",
        "all 32 bytes must be {expected}, byte {actual}", "51-node-and-tnod-32-bytes",
        means "Something hides where no reader looks, and equal trees would have different hashes.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0414 "root-box", "a tree's stated box is not that of its root node",
        "the box must be {expected}, BLAS states {actual}", "54-blas-64-bytes",
        means "Instances of this tree would be placed with the wrong box, and rays lost.", because FOREIGN_WRITER, remedy Rebuild;
    E0415 "prim-out-of-range", "a triangle's number is not one of its part's",
        "prim must be in {expected}, it is {actual}", "52-tris-48-bytes",
        means "A hit on it could not be mapped back to its source.", because FOREIGN_WRITER, remedy Rebuild;
    E0416 "geom-out-of-range", "a triangle names a part that is not there or belongs to another tree",
        "geom must be in {expected}, it is {actual}", "52-tris-48-bytes",
        means "A hit on it could not be mapped back to its source.", because FOREIGN_WRITER, remedy Rebuild;
    E0417 "position-not-finite", "a triangle has a corner that is not finite",
        "all coordinates must be {expected}, but {actual}", "52-tris-48-bytes",
        means "Intersection tests with it give arbitrary answers.", because FOREIGN_WRITER, remedy Rebuild;
    E0418 "triangle-flags", "a triangle has unknown flags",
        "known flags are {expected}, the triangle has {actual}", "52-tris-48-bytes",
        means "A newer version may mean something by them that this one would ignore.", because FOREIGN_WRITER, remedy Rebuild;
    E0419 "triangle-outside", "a triangle does not lie inside its leaf's box",
        "the leaf has {expected}, the triangle {actual}", "51-node-and-tnod-32-bytes",
        means "Rays that miss the leaf's box would not find the triangle: holes in the picture.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0420 "triangle-elsewhere", "a triangle does not touch its leaf's box",
        "the leaf has {expected}, the triangle {actual}", "51-node-and-tnod-32-bytes",
        means "With spatial splits a leaf holds the part of a triangle that lies in its box; here there is no such part.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0421 "triangle-repeated", "a triangle stands in the list twice, in a tree without duplicates",
        "each triangle once, but {actual} stands at {expected} already", "52-tris-48-bytes",
        means "A refit or an any-hit count would visit it twice.", because FOREIGN_WRITER, remedy Rebuild;
    E0422 "duplicate-flag", "a triangle's flag does not say whether it stands in several leaves",
        "the DUPLICATED flag must be {expected}, it is {actual}", "52-tris-48-bytes",
        means "Readers that skip duplicates by this flag would lose or repeat triangles.", because FOREIGN_WRITER, remedy Rebuild;
    E0423 "duplicate-in-leaf", "a triangle stands in the same leaf twice",
        "each triangle once a leaf, but {actual} stands at record {expected} already", "52-tris-48-bytes",
        means "Every ray that visits the leaf tests it twice for nothing.", because FOREIGN_WRITER, remedy Rebuild;
    E0424 "duplicate-differs", "two copies of a triangle have different corners",
        "the corners must be those of record {expected}, but {actual}", "52-tris-48-bytes",
        means "Which of the two a ray hits depends on where it comes from.", because FOREIGN_WRITER, remedy Rebuild;
    E0425 "triangle-uncovered", "the leaves of a duplicated triangle do not cover it",
        "{expected}, but {actual}", "51-node-and-tnod-32-bytes",
        means "Rays through the part that no leaf covers miss the triangle: holes in the picture.",
        because "A clipper that rounds inward, or a writer that dropped a reference.", remedy Rebuild;
    E0426 "node-order", "the nodes do not stand in depth-first order",
        "the children must be at {expected}, they are at {actual}", "51-node-and-tnod-32-bytes",
        means "The tree can be traversed, but equal trees would have different hashes and compress worse.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0427 "stated-sah", "a tree's stated SAH cost is not that of its nodes",
        "sah must be {expected}, BLAS states {actual}", "54-blas-64-bytes",
        means "Every comparison of trees by it would be wrong.", because FOREIGN_WRITER, remedy Rebuild;
    E0428 "loose-box", "a box of a tree that may be refitted is larger than what it holds",
        "the box must be {expected}, it is {actual}", "51-node-and-tnod-32-bytes",
        means "Rays visit the node in vain, and a refit would change boxes of a scene that did not move.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0429 "compact-lanes", "a node of a compact tree has too few children or too many, or something stands where it has none",
        "the node must have {expected}, but {actual}", "57-compact-trees",
        means "Rays would visit what is no child, or a node for nothing.", because FOREIGN_WRITER, remedy Rebuild;
    E0430 "compact-links", "the children of a compact tree's node are not the next nodes and references",
        "{expected} must come next, but it is {actual}", "57-compact-trees",
        means "The records could share branches or contain a cycle, and a traversal would never end.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0431 "compact-widening", "a child of a compact tree's node stands for no node of the binary tree",
        "each child must stand for {expected}, but {actual}", "57-compact-trees",
        means "The compact tree is not the binary one with fewer nodes, so that nothing vouches for its boxes.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0432 "compact-box", "a box of a compact tree does not hold the box that it stands for",
        "the box must hold {expected}, but {actual}", "57-compact-trees",
        means "Rays that miss the box would not find what is in it: holes in the picture.",
        because "A writer that rounds a plane to the nearest step of the grid, or inward.", remedy Rebuild;
    E0433 "compact-reference", "a reference of a compact tree is not the triangle that belongs there",
        "the reference must be {expected}, CREF states {actual}", "57-compact-trees",
        means "A ray would test other triangles than those in the box that it met.", because FOREIGN_WRITER, remedy Rebuild;
    E0434 "loose-split-box", "a box of a tree with clipped boxes is larger than what it may hold",
        "the box may be {expected}, it is {actual}", "51-node-and-tnod-32-bytes",
        means "Rays visit the node in vain, in the worst case every ray every node, and the bounds of the scene are wrong.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0435 "compact-grid", "a compact tree's node has another grid, or other planes on it, than the least that hold its boxes",
        "{expected}, but {actual}", "57-compact-trees",
        means "Boxes are larger than eight bits need, so that rays visit nodes in vain, in the worst case every ray every node.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0436 "turn-axes", "the axes of a turned subtree are not at right angles, or not of length 1",
        "a row must have {expected}, but {actual}", "58-turned-subtrees",
        means "What arithmetic loses in a turned ray would be more than boxes are widened for, so that rays could miss what they hit.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0437 "turn-links", "a turned node leads elsewhere than the node that it stands for",
        "the node must have {expected}, ONOD states {actual}", "58-turned-subtrees",
        means "Rays would come to other triangles than in the tree, or to none.", because FOREIGN_WRITER, remedy Rebuild;
    E0438 "turn-box", "a box of a turned subtree does not hold what is below it",
        "the box must hold {expected}, it is {actual}", "58-turned-subtrees",
        means "Rays that miss the box would not find what is in it: holes in the picture.",
        because "A writer that rounds inward, or that turns boxes and not the triangles in them.", remedy Rebuild;
    E0439 "loose-turn-box", "a box of a turned subtree is larger than whole triangles need",
        "the box may be {expected}, it is {actual}", "58-turned-subtrees",
        means "Rays visit the node in vain, in the worst case every ray every node.", because FOREIGN_WRITER, remedy Rebuild;
    W0401 "negative-zero", "a position is minus zero",
        "a zero is written as {expected}, but {actual}", "52-tris-48-bytes",
        means "It traverses like plus zero, but equal scenes get different hashes.",
        because "Another writer: this one writes every zero as plus zero.", remedy Rebuild;
}
