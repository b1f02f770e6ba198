//! Many rays at once.

use super::hit::{BatchError, Hit, Malformed};
use crate::exec::Executor;

/// Rays of one task: enough to outweigh its start, few enough that threads end together.
const CHUNK: usize = 1 << 10;

/// Ask for each of `rays`, shared among the threads of `exec`; `hits[i]` becomes the answer to `rays[i]`.
pub fn answer_all<R: Sync>(
    rays: &[R],
    hits: &mut [Option<Hit>],
    exec: &Executor,
    ask: impl Fn(&R) -> Result<Option<Hit>, Malformed> + Sync,
) -> Result<(), BatchError> {
    if rays.len() != hits.len() {
        return Err(BatchError::Lengths { rays: rays.len(), hits: hits.len() });
    }
    let chunks = exec.map_chunks_mut(hits, CHUNK, |chunk, some| {
        some.iter_mut().zip(&rays[chunk * CHUNK..]).try_for_each(|(hit, ray)| {
            *hit = ask(ray)?;
            Ok(())
        })
    });
    chunks.into_iter().collect()
}
