use super::{InputFile, ReadOptions, SceneError};
use crate::exec::Executor;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Called with bytes done and bytes known to be needed so far; the second may grow while a glTF names more files.
pub type Progress<'a> = &'a mut (dyn FnMut(u64, u64) + Send);

/// One read in progress: which model, what it may hold, and which files its bytes came from.
pub(super) struct Source<'a> {
    /// The model's path, as errors name it.
    pub path: &'a Path,
    /// The folder that relative references start from; `None` where there is none (standard input).
    pub folder: Option<PathBuf>,
    pub options: &'a ReadOptions,
    pub inputs: Vec<InputFile>,
    exec: &'a Executor,
    progress: Progress<'a>,
    done: u64,
    total: u64,
    used: u64,
    lasting: u64,
}

impl<'a> Source<'a> {
    pub fn new(
        path: &'a Path,
        folder: Option<PathBuf>,
        options: &'a ReadOptions,
        exec: &'a Executor,
        progress: Progress<'a>,
    ) -> Source<'a> {
        Source { path, folder, options, inputs: Vec::new(), exec, progress, done: 0, total: 0, used: 0, lasting: 0 }
    }

    /// Count `bytes` towards the memory limit, before they are allocated.
    pub fn charge(&mut self, bytes: u64, what: &str) -> Result<(), SceneError> {
        let need = self.used.saturating_add(bytes);
        if need > self.options.max_memory {
            return Err(self.over_limit(need, what));
        }
        self.used = need;
        Ok(())
    }

    /// Give back what was charged and has been freed.
    pub fn release(&mut self, bytes: u64) {
        self.used = self.used.saturating_sub(bytes);
    }

    /// Note that so much of what was charged stays until reading ends, whoever asked for it.
    pub fn keep(&mut self, bytes: u64) {
        self.lasting += bytes;
    }

    /// What is charged and may be released: a step that frees all that it took releases the difference.
    pub fn passing(&self) -> u64 {
        self.used.saturating_sub(self.lasting)
    }

    /// What is left below the memory limit.
    pub fn available(&self) -> u64 {
        self.options.max_memory.saturating_sub(self.used)
    }

    pub fn over_limit(&self, need: u64, what: &str) -> SceneError {
        SceneError::Memory { path: self.path.to_owned(), what: what.to_owned(), need, limit: self.options.max_memory }
    }

    /// The threads that read.
    pub fn exec(&self) -> &'a Executor {
        self.exec
    }

    /// Note that `bytes` more of what was announced are done.
    pub fn advance(&mut self, bytes: u64) {
        self.done = self.done.saturating_add(bytes).min(self.total);
        (self.progress)(self.done, self.total);
    }

    /// Note that everything is done.
    pub fn finish(&mut self) {
        self.advance(u64::MAX);
    }

    /// Read the model file itself and remember it as the first input.
    pub fn read_model(&mut self) -> Result<Vec<u8>, SceneError> {
        let path = self.path;
        let unreadable = |source| SceneError::Unreadable { path: path.to_owned(), source };
        let bytes = self.read_file(path).map_err(unreadable)??;
        self.add_model(&bytes);
        Ok(bytes)
    }

    /// Remember `bytes` as the model's own.
    pub fn add_model(&mut self, bytes: &[u8]) {
        self.add_input(self.path.to_owned(), self.model_name(), bytes);
    }

    /// Hash the bytes that were read, so that what is hashed is what is used even if the file changes meanwhile.
    pub fn add_input(&mut self, path: PathBuf, name: String, bytes: &[u8]) {
        self.add_hashed(path, name, bytes.len() as u64, self.exec.hash(bytes));
    }

    /// Remember a file whose bytes were read and hashed.
    pub fn add_hashed(&mut self, path: PathBuf, name: String, len: u64, blake3: [u8; 32]) {
        self.inputs.push(InputFile { path, name, len, blake3 });
        self.total += len;
    }

    /// What the model itself is called among the inputs.
    pub fn model_name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    /// Read a whole file within the memory limit. A length that the file system states is a hint, not a promise: pipes say 0.
    pub fn read_file(&mut self, path: &Path) -> io::Result<Result<Vec<u8>, SceneError>> {
        // Asked before it is opened: opening a pipe waits for its other end.
        let metadata = path.metadata()?;
        if metadata.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder, not a file"));
        }
        if !metadata.is_file() {
            return Err(io::Error::other("it is not a regular file"));
        }
        let file = File::open(path)?;
        let stated = metadata.len();
        if stated > self.available() {
            return Ok(Err(self.over_limit(self.used.saturating_add(stated), "the file")));
        }
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(stated as usize + 1).map_err(|_| io::ErrorKind::OutOfMemory)?;
        file.take(self.available().saturating_add(1)).read_to_end(&mut bytes)?;
        Ok(self.charge(bytes.len() as u64, "the file").map(|()| bytes))
    }
}
