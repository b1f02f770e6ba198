//! The file of an earlier build, from which the poses of frames are taken whose model is what it was then.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::cache::keys::Recipe;
use crate::cache::{
    CacheError, Dependency, FrameRecord, Head, InstanceRecord, Meta, OpenOptions, PoseRecord, SectionKind, Sequence,
    TopologyRecord, hash_file, sound_sequence, tree_flags,
};
use crate::exec::Executor;
use crate::geom::Point;
use crate::scene::InputFile;
use crate::tree::Node;
use bytemuck::{Pod, pod_collect_to_vec, try_cast_slice};

/// A frame that is a file.
#[derive(Clone, Debug)]
pub struct FrameModel {
    /// Its number.
    pub number: i32,
    /// The model.
    pub path: PathBuf,
}

/// An earlier build of a sequence of files. Its frames have one mesh each, as those of OBJ models have.
pub struct Prior {
    file: Sequence,
    /// For each block its entries `NODE` and `VPOS`, for each placement `TNOD` and `INST`.
    blocks: Vec<[usize; 2]>,
    placements: Vec<[usize; 2]>,
    /// For each frame of the file the pose that it shows; `None` where it shows nothing.
    pub(super) shows: Vec<Option<u32>>,
    /// For each frame of the file the topology that it shows first, if it is the first to show one.
    pub(super) introduces: Vec<Option<u32>>,
    /// For each frame to be built the frame of the file that was made from the same bytes.
    pub(super) same: Vec<Option<usize>>,
    /// For each frame to be built its model.
    inputs: Vec<InputFile>,
    read_counts: Vec<(String, u64)>,
}

/// The nodes and vertices of a pose.
type Content<'p> = (Cow<'p, [Node]>, Cow<'p, [Point]>);

impl Prior {
    /// The file at `path`, if frames of it can be taken: it is whole and sound, it says that this version of the program built it by the same recipe, the option
    /// `choice` of which says which frames and may be another, and some frame's model has the same name and the same bytes.
    ///
    /// `surveyed` names the frames of so many that trees are made for beforehand. These depend on all of them, so that nothing is taken where they are not what
    /// they were.
    pub fn find(
        path: &Path,
        models: &[FrameModel],
        recipe: &Recipe,
        choice: &str,
        surveyed: impl Fn(usize) -> Vec<usize>,
        open: &OpenOptions,
        exec: &Executor,
    ) -> Option<Prior> {
        let head = Head::read(path, open).ok().filter(|head| head.header.has(tree_flags::SEQUENCE))?;
        let meta = head.meta.as_ref().filter(|meta| is_of(meta, recipe, choice))?;
        if meta.build_key() != head.header.build_key {
            return None;
        }
        let hashes = exec
            .map(models.iter().collect(), |_, model: &FrameModel| hash_file(&model.path, &Executor::sequential()).ok());
        let inputs: Option<Vec<InputFile>> =
            models.iter().zip(hashes).map(|(model, hash)| input(model, hash?)).collect();
        let inputs = inputs?;
        sound_sequence(path, open, exec).ok()?;
        let file = Sequence::open_on(path, open, exec).ok()?;
        if file.header().file_id != head.header.file_id {
            return None;
        }

        let before = models_of(file.frames(), &meta.dependencies)?;
        let is_model =
            |input: &InputFile, d: &Dependency| (&input.name, input.len, input.blake3) == (&d.name, d.len, d.blake3);
        let same: Vec<Option<usize>> = models
            .iter()
            .zip(&inputs)
            .map(|(model, input)| file.numbered(model.number).filter(|old| is_model(input, before[*old])))
            .collect();
        let looked_at = |i: &usize| (inputs[*i].len, inputs[*i].blake3);
        let looked_at: Vec<_> = surveyed(models.len()).iter().map(looked_at).collect();
        let then = surveyed(before.len());
        if same.iter().all(Option::is_none)
            || !then.iter().map(|old| (before[*old].len, before[*old].blake3)).eq(looked_at)
        {
            return None;
        }
        let read_counts = meta.read_counts.clone();
        let pairs = |a, b| Some(entries(&file, a).into_iter().zip(entries(&file, b)).map(|(a, b)| [a, b]).collect());
        let blocks = pairs(SectionKind::NODE, SectionKind::VPOS)?;
        let placements = pairs(SectionKind::TNOD, SectionKind::INST)?;
        let (shows, introduces) = (Vec::new(), Vec::new());
        let prior = Prior { file, blocks, placements, shows, introduces, same, inputs, read_counts };
        prior.with_rows(exec)
    }

    /// What each frame shows; `None` where one shows several instances.
    fn with_rows(self, exec: &Executor) -> Option<Prior> {
        let mut of_placement: BTreeMap<u32, Option<u32>> = BTreeMap::new();
        let mut seen = BTreeSet::new();
        let (mut shows, mut introduces) = (Vec::new(), Vec::new());
        for frame in self.file.frames() {
            let pose = match of_placement.get(&frame.placement) {
                Some(pose) => *pose,
                None => match self.placement(frame, exec).ok()?.1[..] {
                    [] => None,
                    [one] => Some(one.blas),
                    _ => return None,
                },
            };
            of_placement.insert(frame.placement, pose);
            let topology = pose.map(|pose| self.pose(pose).topology);
            introduces.push(topology.filter(|topology| seen.insert(*topology)));
            shows.push(pose);
        }
        Some(Prior { shows, introduces, ..self })
    }

    /// The files of the frames to be built, in their order.
    pub fn inputs(&self) -> &[InputFile] {
        &self.inputs
    }

    /// The frames to be built whose model is another than that of the file's frame of the same number, or that the file does not have.
    pub fn changed(&self) -> impl Iterator<Item = usize> {
        self.same.iter().enumerate().filter(|(_, old)| old.is_none()).map(|(i, _)| i)
    }

    /// The others.
    pub fn kept(&self) -> impl Iterator<Item = usize> {
        self.same.iter().enumerate().filter(|(_, old)| old.is_some()).map(|(i, _)| i)
    }

    /// What reading dropped or repaired then: for each kind the most of all frames.
    pub fn read_counts(&self) -> &[(String, u64)] {
        &self.read_counts
    }

    /// The frames of the file that no frame to be built is the same as.
    pub(super) fn gone(&self) -> Vec<usize> {
        let kept: BTreeSet<usize> = self.same.iter().flatten().copied().collect();
        (0..self.shows.len()).filter(|old| !kept.contains(old)).collect()
    }

    pub(super) fn file(&self) -> &Sequence {
        &self.file
    }

    pub(super) fn pose(&self, pose: u32) -> PoseRecord {
        // The rules were asked: what is shown is there.
        self.file.poses()[pose as usize]
    }

    pub(super) fn topology(&self, topology: u32) -> TopologyRecord {
        self.file.topologies()[topology as usize]
    }

    /// The topology of what a frame of the file shows.
    pub(super) fn topology_of(&self, old: usize) -> Option<u32> {
        self.shows[old].map(|pose| self.pose(pose).topology)
    }

    /// The tree over a frame's instances, and these.
    pub(super) fn placement(
        &self,
        frame: &FrameRecord,
        exec: &Executor,
    ) -> Result<(Vec<Node>, Vec<InstanceRecord>), CacheError> {
        let [tnod, inst] = self.placements[frame.placement as usize];
        Ok((self.records(tnod, exec)?.into_owned(), self.records(inst, exec)?.into_owned()))
    }

    /// The nodes and vertices of a pose.
    pub(super) fn content(&self, pose: u32, exec: &Executor) -> Result<Content<'_>, CacheError> {
        let record = self.pose(pose);
        let topology = self.topology(record.topology);
        let [node, vpos] = self.blocks[record.block as usize];
        let nodes = piece(self.records(node, exec)?, record.node_offset, topology.node_count);
        let vertices = piece(self.records(vpos, exec)?, record.vertex_offset, topology.vertex_count);
        Ok((nodes, vertices))
    }

    fn records<T: Pod>(&self, entry: usize, exec: &Executor) -> Result<Cow<'_, [T]>, CacheError> {
        Ok(match self.file.section_bytes(entry, exec)?.unwrap_or_default() {
            Cow::Borrowed(bytes) => Cow::Borrowed(try_cast_slice(bytes).unwrap_or_default()),
            // A vector of bytes need not be aligned.
            Cow::Owned(bytes) => Cow::Owned(pod_collect_to_vec(&bytes)),
        })
    }
}

/// Some of the records of a section, whose rows were asked when the file was opened.
fn piece<T: Clone>(all: Cow<'_, [T]>, offset: u64, count: u32) -> Cow<'_, [T]> {
    let range = offset as usize..offset as usize + count as usize;
    match all {
        Cow::Borrowed(all) => Cow::Borrowed(&all[range]),
        Cow::Owned(all) if all.len() == range.len() => Cow::Owned(all),
        Cow::Owned(all) => Cow::Owned(all[range].to_vec()),
    }
}

/// The entries of a kind by their numbers: a file has them in that order.
fn entries(file: &Sequence, kind: SectionKind) -> Vec<usize> {
    let of_kind = file.sections().iter().enumerate().filter(|(_, entry)| entry.kind == kind);
    let mut all: Vec<(u32, usize)> = of_kind.map(|(i, entry)| (entry.ordinal, i)).collect();
    all.sort_unstable();
    all.into_iter().map(|(_, i)| i).collect()
}

/// Whether a file was made as it would be now, whichever frames it has.
fn is_of(meta: &Meta, recipe: &Recipe, choice: &str) -> bool {
    let others = |options: &[(String, String)]| -> Vec<(String, String)> {
        options.iter().filter(|(name, _)| name != choice).cloned().collect()
    };
    // Another version may build other trees by the same recipe, or lay them out otherwise.
    meta.tool_version == env!("CARGO_PKG_VERSION")
        && (&meta.method, meta.builder_revision) == (&recipe.method, recipe.builder_revision)
        && others(&meta.options) == others(&recipe.options)
}

fn input(model: &FrameModel, (len, blake3): (u64, [u8; 32])) -> Option<InputFile> {
    let name = model.path.file_name()?.to_str()?.to_owned();
    Some(InputFile { path: model.path.clone(), name, len, blake3 })
}

/// For each frame of a file the model that it was made from. META lists files in the order of the frames. `None` where it has others, as those that glTF models
/// name.
fn models_of<'m>(frames: &[FrameRecord], files: &'m [Dependency]) -> Option<Vec<&'m Dependency>> {
    // A frame that is held has the model of the one before it.
    let brings = |frame: &FrameRecord| frame.flags & FrameRecord::HELD == 0;
    if frames.iter().filter(|frame| brings(frame)).count() != files.len() {
        return None;
    }
    let mut brought = 0;
    let model = frames.iter().map(|frame| {
        brought += usize::from(brings(frame));
        files.get(brought.checked_sub(1)?)
    });
    model.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn each_frame_has_the_file_that_was_listed_when_it_was_first_used() {
        let frame = |number, flags| FrameRecord { number, flags, ..FrameRecord::zeroed() };
        let frames = [frame(1, 0), frame(2, 0), frame(3, FrameRecord::HELD), frame(4, 0), frame(9, 0)];
        let files = ["1", "2", "4", "9"].map(|name| Dependency { name: name.into(), ..Dependency::default() });
        let names =
            |found: Option<Vec<&Dependency>>| found.map(|all| all.iter().map(|d| d.name.clone()).collect::<Vec<_>>());
        assert_eq!(names(models_of(&frames, &files)), Some(["1", "2", "2", "4", "9"].map(String::from).to_vec()));
        assert_eq!(names(models_of(&frames, &files[..3])), None, "it has other files than frames");
        let held = [frame(1, FrameRecord::HELD), frame(2, 0)];
        assert_eq!(names(models_of(&held, &files[..1])), None, "the first frame is of no file");
    }
}
