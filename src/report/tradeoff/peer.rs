//! Builders of other people beside ours: each a program behind a pipe, so that what it links excludes nothing here, and nothing of it runs beside our builds.
//!
//! A worker is told the triangles once: their number and nine floats each. A byte asks for a build by one of its settings. The answer is the build's own
//! milliseconds (f64), the number of nodes and the nodes as 32-byte records `min, first, max, count`, siblings in pairs, and the number of triangles in leaves
//! and their indices. Everything is in the machine's byte order.

use crate::scene::Mesh;
use crate::tree::{Node, Tree};
use std::io::{Error, Read, Result, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Peers that there are workers for, with their settings in the order of the bytes that ask for them.
pub const PEERS: [(&str, &[&str]); 4] = [
    ("embree", &["low", "medium", "high"]),
    ("obvhs", &["fastest", "very_fast", "fast", "medium", "slow", "very_slow"]),
    ("bvh", &["default"]),
    ("tinybvh", &["binned", "sweep", "hq_8", "hq_32", "hq_32_optimized_25", "hq_32_extreme_50"]),
];

/// A worker's program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Worker {
    /// One of [`PEERS`].
    pub name: &'static str,
    /// Of that row.
    pub settings: &'static [&'static str],
    /// What is started.
    pub program: PathBuf,
    /// And with which words.
    pub arguments: Vec<String>,
}

impl Worker {
    /// Of a peer that there is a row for, whatever the case of its name.
    pub fn of(name: &str, program: &Path, arguments: &[&str]) -> Option<Worker> {
        let (name, settings) = PEERS.iter().find(|(of, _)| of.eq_ignore_ascii_case(name))?;
        let arguments = arguments.iter().map(|word| (*word).to_string()).collect();
        Some(Worker { name, settings, program: program.to_path_buf(), arguments })
    }
}

/// A worker at work on one mesh.
#[derive(Debug)]
pub struct Pipe {
    child: Child,
    /// Nothing once it is closed.
    input: Option<ChildStdin>,
    output: ChildStdout,
    triangles: u32,
}

impl Pipe {
    /// Start it, on so many threads where it asks the environment, and tell it the mesh. A worker that takes longer than `goes_on` lasts is killed.
    ///
    /// # Errors
    /// Where it does not start, or does not listen.
    pub fn open(worker: &Worker, threads: usize, mesh: &Mesh, goes_on: &(dyn Fn() -> bool + Sync)) -> Result<Pipe> {
        let mut command = Command::new(&worker.program);
        command.args(&worker.arguments).env("RAYON_NUM_THREADS", threads.to_string());
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
        let input = child.stdin.take();
        let output = child.stdout.take().ok_or_else(closed)?;
        let corners: Vec<[[f32; 3]; 3]> = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
        let mut pipe = Pipe { child, input, output, triangles: corners.len() as u32 };
        pipe.watched(goes_on, |input, _| {
            input.write_all(&(corners.len() as u32).to_ne_bytes())?;
            input.write_all(bytemuck::cast_slice(&corners))?;
            input.flush()
        })?;
        Ok(pipe)
    }

    /// Milliseconds, and the tree in our order of nodes. A worker that takes longer than `goes_on` lasts is killed.
    ///
    /// # Errors
    /// Where the worker ends, or answers with what is no tree over its triangles.
    pub fn build(&mut self, setting: u8, goes_on: &(dyn Fn() -> bool + Sync)) -> Result<(f64, Tree)> {
        let most = 64 * u64::from(self.triangles) + 64;
        let (milliseconds, nodes, refs) = self.watched(goes_on, |input, output| {
            input.write_all(&[setting])?;
            input.flush()?;
            let mut milliseconds = [0; 8];
            output.read_exact(&mut milliseconds)?;
            let nodes: Vec<Node> = records(output, most)?;
            Ok((milliseconds, nodes, records::<u32>(output, most)?))
        })?;
        let tree = canonical(&nodes, &refs, self.triangles).ok_or_else(|| Error::other("its answer is no tree"))?;
        Ok((f64::from_ne_bytes(milliseconds), tree))
    }

    /// Speak with the worker, while another thread looks whether that still goes on. Killed, the worker closes its pipes, and nobody waits for it any longer.
    fn watched<T>(
        &mut self,
        goes_on: &(dyn Fn() -> bool + Sync),
        speak: impl FnOnce(&mut ChildStdin, &mut ChildStdout) -> Result<T>,
    ) -> Result<T> {
        let Pipe { child, input, output, .. } = self;
        let input = input.as_mut().ok_or_else(closed)?;
        let done = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let watcher = scope.spawn(|| {
                while !done.load(Ordering::Acquire) {
                    if !goes_on() {
                        _ = child.kill();
                        return;
                    }
                    std::thread::park_timeout(WATCHED);
                }
            });
            let said = speak(input, output);
            done.store(true, Ordering::Release);
            watcher.thread().unpark();
            said
        })
    }
}

/// How often it is asked whether a worker may go on.
const WATCHED: Duration = Duration::from_millis(20);

fn closed() -> Error {
    Error::other("its pipe is closed")
}

/// A number and so many records, at most so many.
fn records<T: bytemuck::Pod>(from: &mut impl Read, most: u64) -> Result<Vec<T>> {
    let mut count = [0; 4];
    from.read_exact(&mut count)?;
    let count = u32::from_ne_bytes(count);
    if u64::from(count) > most {
        return Err(Error::other(format!("it answers with {count} records, more than {most}")));
    }
    let mut all = vec![T::zeroed(); count as usize];
    from.read_exact(bytemuck::cast_slice_mut(&mut all))?;
    Ok(all)
}

impl Drop for Pipe {
    /// A worker keeps nothing, so nobody waits until it ends by itself.
    fn drop(&mut self) {
        drop(self.input.take());
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

/// Any tree of sibling pairs in our order: pairs in depth-first preorder, leaves likewise. `None` where nodes lead out of the records or back.
fn canonical(nodes: &[Node], refs: &[u32], triangles: u32) -> Option<Tree> {
    let Some(root) = nodes.first() else { return Some(Tree::default()) };
    let mut tree = Tree { nodes: vec![*root; 2], refs: Vec::with_capacity(refs.len()) };
    tree.nodes[1] = Node { min: [0.0; 3], first: 0, max: [0.0; 3], count: 0 };
    let mut stack = vec![0usize];
    while let Some(at) = stack.pop() {
        let node = tree.nodes[at];
        let first = node.first as usize;
        if node.is_leaf() {
            tree.nodes[at].first = tree.refs.len() as u32;
            let own = refs.get(first..first.checked_add(node.count as usize)?)?;
            if own.iter().any(|triangle| *triangle >= triangles) || tree.refs.len() + own.len() > refs.len() {
                return None;
            }
            tree.refs.extend(own);
        } else {
            let pair = tree.nodes.len();
            // A walk that comes back makes more nodes than there are.
            if pair > nodes.len() + 2 {
                return None;
            }
            tree.nodes[at].first = pair as u32;
            tree.nodes.extend_from_slice(nodes.get(first..first.checked_add(2)?)?);
            stack.extend([pair + 1, pair]);
        }
    }
    Some(tree)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(first: u32, count: u32) -> Node {
        Node { min: [0.0; 3], first, max: [1.0; 3], count }
    }

    #[test]
    fn trees_are_put_in_our_order_and_what_is_none_is_refused() {
        let nodes = [node(3, 0), node(0, 0), node(0, 0), node(1, 1), node(0, 1)];
        let tree = canonical(&nodes, &[7, 8], 9).unwrap();
        assert_eq!((tree.nodes.len(), tree.nodes[0].first, &tree.refs[..]), (4, 2, &[8, 7][..]));
        assert!(canonical(&[], &[], 0).unwrap().nodes.is_empty());
        // A triangle that is not there, a leaf that ends behind the list, a child behind the nodes, a circle, and one leaf below two.
        assert!(canonical(&nodes, &[7, 9], 9).is_none() && canonical(&nodes, &[7], 9).is_none());
        assert!(canonical(&[node(5, 0), node(0, 0)], &[], 9).is_none());
        assert!(canonical(&[node(0, 0), node(0, 1)], &[], 9).is_none());
        assert!(canonical(&[node(2, 0), node(0, 0), node(0, 1), node(0, 1)], &[7], 9).is_none());
    }

    #[test]
    fn a_worker_that_is_none_is_an_error() {
        let mesh = Mesh::new("", vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        assert!(Worker::of("nobody", Path::new("x"), &[]).is_none());
        let worker = Worker::of("bvh", Path::new("/nowhere/worker"), &[]).unwrap();
        assert_eq!(Worker::of("BVH", Path::new("/nowhere/worker"), &[]).as_ref(), Some(&worker));
        assert!(Pipe::open(&worker, 1, &mesh, &|| true).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_worker_that_never_answers_is_killed() {
        let mesh = Mesh::new("", vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
        let worker = Worker::of("bvh", Path::new("sleep"), &["3600"]).unwrap();
        let mut pipe = Pipe::open(&worker, 1, &mesh, &|| true).unwrap();
        let asked = std::sync::atomic::AtomicU32::new(0);
        let goes_on = || asked.fetch_add(1, Ordering::SeqCst) < 3;
        // It would take an hour.
        assert!(pipe.build(0, &goes_on).is_err());
        assert_eq!(asked.into_inner(), 4);
    }
}
