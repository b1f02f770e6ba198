//! Outputs that are written take their places.

use crate::cache::{self, Staged};
use crate::cli::caches;
use crate::cli::exit::Exit;
use crate::cli::failure::Failure;
use crate::cli::interrupt;
use crate::cli::names;
use crate::exec::Executor;
use clap::ValueEnum;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What an output that is reported as built can be relied on to survive. Whatever is chosen, a program that is killed leaves the old file or the
/// new one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SyncMode {
    /// A power cut at any time leaves the old file or the new one, and the new one once it is reported: each file waits for the disk
    Each,
    /// The same promise, kept for many files together, which are reported when all of them are on the disk
    Batch,
    /// No waiting for the disk: a power cut may leave files that are damaged, which opening and `bvhc check` find
    None,
}

/// Put outputs in their places; what became of each, in order.
pub fn put_all(staged: Vec<Staged>, sync: SyncMode, exec: &Executor) -> Vec<Result<(), Failure>> {
    let synced = |staged: Staged| staged.sync().map_err(|e| caches::failure(&e)).map(|()| staged);
    match sync {
        SyncMode::None => staged.into_iter().map(|staged| put(staged).map(drop)).collect(),
        SyncMode::Each => {
            exec.map_waits(staged, |staged| put(synced(staged)?)?.map_or(Ok(()), |folder| sync_folder(&folder)))
        }
        SyncMode::Batch => {
            let synced = exec.map_waits(staged, synced);
            let put: Vec<Result<Option<PathBuf>, Failure>> = synced.into_iter().map(|staged| put(staged?)).collect();
            let mut folders = BTreeMap::new();
            for folder in put.iter().flatten().flatten() {
                if !folders.contains_key(folder) {
                    folders.insert(folder.clone(), sync_folder(folder));
                }
            }
            let settled = |folder: PathBuf| folders.get(&folder).cloned().unwrap_or(Ok(()));
            put.into_iter().map(|put| put?.map_or(Ok(()), settled)).collect()
        }
    }
}

/// The folder that the output is in now.
fn put(staged: Staged) -> Result<Option<PathBuf>, Failure> {
    let _publishing = interrupt::publish()?;
    let temporary = staged.temporary().map(Path::to_owned);
    let put = staged.put().map_err(|e| caches::failure(&e));
    temporary.iter().for_each(|path| interrupt::unstage(path));
    put
}

fn sync_folder(folder: &Path) -> Result<(), Failure> {
    cache::sync_folder(folder).map_err(|e| {
        Failure::new(Exit::Io, format!("cannot sync the folder {}", names::path(folder))).fact(e.to_string())
    })
}
