//! `E07xx`: do the rows of a sequence lead where they say, and do its poses share their topology?

use super::{FOREIGN_WRITER, rules};

rules! {
    E0701 "topology-range", "the topologies do not tile the TRIX section in order",
        "the topology must start at record {expected}, TOPO states {actual}", "56-sequences",
        means "Two topologies would share triangles, or triangles would belong to none.", because FOREIGN_WRITER, remedy Rebuild;
    E0702 "pose-range", "a pose names a topology that is not there, or the poses do not tile their blocks in order",
        "the pose must name {expected}, POSE states {actual}", "56-sequences",
        means "A frame would show another pose's boxes and vertices, or none.", because FOREIGN_WRITER, remedy Rebuild;
    E0703 "frame-row", "a frame is out of order, shows a placement that is not there or not the one that it holds, or has no proper time",
        "the frame must have {expected}, FRAM states {actual}", "56-sequences",
        means "A frame could not be found by its number, or would show nothing.", because FOREIGN_WRITER, remedy Rebuild;
    E0704 "corner-number", "a triangle has a corner that its topology does not have",
        "the corner must be < {expected}, TRIX states {actual}", "56-sequences",
        means "A reader that does not check would read memory that is not a vertex.", because FOREIGN_WRITER, remedy Rebuild;
    E0705 "pose-shape", "the tree of a pose has another shape than that of its topology's first pose",
        "first and count must be {expected}, they are {actual}", "56-sequences",
        means "Boxes of two moments could not be interpolated, and a refit would put triangles into foreign leaves.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0706 "sequence-reserved", "reserved fields or flags of a sequence's row are not zero",
        "they must be {expected}, but {actual}", "56-sequences",
        means "Either a writer error, or a use of these fields that a newer version invented without saying so.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0707 "topology-without-pose", "a topology has no pose",
        "each topology has at least {expected} pose, topology {actual} has none", "56-sequences",
        means "The shape of its tree is nowhere, and its triangles can never be hit.",
        because FOREIGN_WRITER, remedy Rebuild;
    E0708 "topology-size", "a topology is empty, or has more triangles or parts than its leaves can hold",
        "the topology must have {expected}, it has {actual}", "56-sequences",
        means "A few bytes for each pose could make a frame that fills memory.", because FOREIGN_WRITER, remedy Rebuild;
    E0709 "vertex-unused", "a topology has a vertex that is no corner",
        "each vertex must be a corner of at least {expected} triangle, vertex {actual} is of none", "56-sequences",
        means "It takes space in every pose, and nothing that is asked of corners is asked of it.",
        because FOREIGN_WRITER, remedy Rebuild;
    W0701 "unshown-placement", "no frame shows a placement",
        "each placement is shown by at least {expected} frame, placement {actual} by none", "56-sequences",
        means "It takes space and can never be hit.", because "Another writer kept what no frame needs.", remedy Rebuild;
    W0702 "frame-times", "the times of frames fall, or only some frames have one",
        "the frame should have {expected}, it has {actual}", "564-fram-32-bytes",
        means "Whoever looks for the frame of a moment by halves finds a wrong one.",
        because "Another writer, or a source with times out of order.", remedy Rebuild;
}
