//! `E05xx`: do the instances stand where the top level says, and do their matrices undo each other?

use super::{FOREIGN_WRITER, rules};

rules! {
    E0501 "matrix-not-finite", "an instance's matrix has an entry that is not finite",
        "all 24 entries must be {expected}, but {actual}", "55-inst-128-bytes",
        means "No ray can be brought into the instance's space.", because FOREIGN_WRITER, remedy Rebuild;
    E0502 "matrix-inverse", "an instance's two matrices do not undo each other",
        "{expected}, but {actual}", "55-inst-128-bytes",
        means "Rays would be traced somewhere else than where the instance stands.", because FOREIGN_WRITER, remedy Rebuild;
    E0503 "instance-blas", "an instance names a tree that is not there",
        "blas must be < {expected}, it is {actual}", "55-inst-128-bytes",
        means "A traversal that does not check would read memory that is not the tree.", because FOREIGN_WRITER, remedy Rebuild;
    E0504 "instance-id", "instance numbers are not each number once",
        "{expected}, but {actual}", "55-inst-128-bytes",
        means "A hit could not be mapped back to its instance.", because FOREIGN_WRITER, remedy Rebuild;
    E0505 "instance-flags", "an instance's flags are unknown or do not tell whether it mirrors",
        "the flags must be {expected}, they are {actual}", "55-inst-128-bytes",
        means "Back faces would be taken for front faces.", because FOREIGN_WRITER, remedy Rebuild;
    E0506 "instance-reserved", "reserved fields of an instance are not zero",
        "reserved must be {expected}, but {actual}", "55-inst-128-bytes",
        means "Either a writer error, or a use of these fields that a newer version invented without saying so.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0507 "instance-outside", "an instance does not lie inside its leaf's box",
        "the leaf has {expected}, the transformed tree {actual}", "55-inst-128-bytes",
        means "Rays that miss the leaf's box would not find the instance: holes in the picture.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0508 "loose-top-box", "a box of the top level is larger than what it holds",
        "the box must be {expected}, it is {actual}", "51-node-and-tnod-32-bytes",
        means "Rays enter instances in vain, and a renderer that places cameras by the bounds of the scene would show nothing.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0509 "instance-node", "an instance names another node than the parts of its tree",
        "the node must be {expected}, it is {actual}", "55-inst-128-bytes",
        means "A hit leads to two nodes of the model, and readers take the one or the other.", because FOREIGN_WRITER, remedy Rebuild;
    W0501 "empty-tree-instanced", "an instance places an empty tree",
        "a tree with {expected}, but tree {actual} has none", "55-inst-128-bytes",
        means "The instance costs a visit and can never be hit.",
        because "All triangles of the mesh were dropped, or another writer kept an empty mesh.", remedy Rebuild;
    W0502 "unused-tree", "no instance places this tree",
        "each tree has at least {expected} instance, tree {actual} has none", "55-inst-128-bytes",
        means "The tree takes space and can never be hit.",
        because "Another writer kept a mesh that the scene does not use.", remedy Rebuild;
    W0503 "masked-instance", "no renderer that follows masks shows an instance",
        "the mask should have {expected}, it is {actual}", "55-inst-128-bytes",
        means "The instance takes space, and is hit by readers that do not follow masks alone.",
        because "Another writer hid the instance in place of leaving it out.", remedy Rebuild;
}
