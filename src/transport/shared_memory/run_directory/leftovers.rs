//! What dead runs left, and its removal.

use std::collections::BTreeSet;
use std::fs::{DirEntry, File, TryLockError};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::{
    LOCK, RUN, TransportError, home_of_this_user, lock_within, prefix, prefix_of_this_user,
};
use crate::transport::shared_memory::room::SHARED_MEMORY_DIRECTORY;

/// Runs that were found, and what became of them.
#[derive(Debug, Default)]
pub struct Leftovers {
    /// Runs that died, of which something was removed.
    pub runs: u32,
    pub files: u32,
    /// Memory and disk that are free again.
    pub bytes: u64,
    /// Their masters are alive: nothing of them was touched.
    pub living: Vec<LivingRun>,
    pub failures: Vec<NotRemoved>,
}

#[derive(Debug)]
pub struct LivingRun {
    /// Its directory; or, if that is below another base, what its files in `/dev/shm` begin with.
    pub path: PathBuf,
    /// In shared memory.
    pub files: u32,
    pub bytes: u64,
}

#[derive(Debug)]
pub struct NotRemoved {
    pub path: PathBuf,
    pub reason: io::Error,
}

/// Removes what dead runs of this user left below `base`, and in shared memory also those that
/// were started with another base.
pub fn remove_leftovers(base: &Path) -> Result<Leftovers, TransportError> {
    let mut found = Leftovers::default();
    let home = home_of_this_user(base)?;
    if let Some(home) = &home {
        let _guard = lock_within(&home.join(LOCK), super::PATIENCE)?;
        found.remove_runs_below(home).map_err(super::refuse(home))?;
    }
    found
        .remove_runs_without_directory(home.as_deref())
        .map_err(super::refuse(Path::new(SHARED_MEMORY_DIRECTORY)))?;
    Ok(found)
}

impl Leftovers {
    /// Only while nobody else begins or removes a run there.
    pub(super) fn remove_runs_below(&mut self, home: &Path) -> io::Result<()> {
        for entry in std::fs::read_dir(home)? {
            let run = entry?.path();
            let Some(prefix) = prefix(&run) else { continue };
            if let Some(true) = self.is_dead(&run, &run.join(LOCK), &prefix)? {
                let files = self.files;
                self.remove_files(&prefix)?;
                self.remove_tree(&run);
                self.runs += u32::from(self.files > files);
            }
        }
        Ok(())
    }

    /// A run holds its lock in shared memory before it has any other file there.
    fn remove_runs_without_directory(&mut self, home: Option<&Path>) -> io::Result<()> {
        let user = prefix_of_this_user();
        let mut runs = BTreeSet::new();
        for file in files_of_this_user(&user)? {
            let name = file.file_name();
            let name = name.to_str().and_then(|name| name.strip_prefix(&user));
            runs.extend(name.and_then(|name| Some(name.split_once('_')?.0.to_owned())));
        }
        runs.retain(|run| !home.is_some_and(|home| home.join(format!("{RUN}{run}")).exists()));
        for run in runs {
            let prefix = format!("{user}{run}_");
            let start = Path::new(SHARED_MEMORY_DIRECTORY).join(&prefix);
            if let Some(true) = self.is_dead(&start, &shared_lock(&prefix), &prefix)? {
                let files = self.files;
                self.remove_files(&prefix)?;
                self.runs += u32::from(self.files > files);
            }
        }
        Ok(())
    }

    /// Takes note of a run that lives. `None`: it cannot be told.
    fn is_dead(&mut self, run: &Path, lock: &Path, prefix: &str) -> io::Result<Option<bool>> {
        match is_held(lock) {
            Ok(false) => Ok(Some(true)),
            Ok(true) => {
                let mut living = LivingRun { path: run.to_owned(), files: 0, bytes: 0 };
                for file in files_of_this_user(prefix)? {
                    living.files += 1;
                    living.bytes += file.metadata().map_or(0, |found| found.blocks() * 512);
                }
                self.living.push(living);
                Ok(Some(false))
            }
            Err(reason) => {
                self.failures.push(NotRemoved { path: lock.to_owned(), reason });
                Ok(None)
            }
        }
    }

    /// Those in shared memory.
    pub(super) fn remove_files(&mut self, prefix: &str) -> io::Result<()> {
        let mut files = files_of_this_user(prefix)?;
        files.sort_by_key(is_lock);
        files.iter().for_each(|file| self.remove_file(&file.path()));
        Ok(())
    }

    pub(super) fn remove_tree(&mut self, directory: &Path) {
        let mut entries = match std::fs::read_dir(directory).and_then(Iterator::collect) {
            Ok::<Vec<DirEntry>, _>(entries) => entries,
            Err(reason) => return self.not_removed(directory, reason),
        };
        entries.sort_by_key(is_lock);
        for entry in entries {
            // Of a link itself, not of what it leads to.
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                self.remove_tree(&entry.path());
            } else {
                self.remove_file(&entry.path());
            }
        }
        if let Err(reason) = std::fs::remove_dir(directory) {
            self.not_removed(directory, reason);
        }
    }

    fn remove_file(&mut self, path: &Path) {
        let bytes = path.symlink_metadata().map_or(0, |found| found.blocks() * 512);
        match std::fs::remove_file(path) {
            Ok(()) => {
                self.files += 1;
                self.bytes += bytes;
            }
            Err(reason) => self.not_removed(path, reason),
        }
    }

    fn not_removed(&mut self, path: &Path, reason: io::Error) {
        // What has gone meanwhile needs no removal.
        if reason.kind() != io::ErrorKind::NotFound {
            self.failures.push(NotRemoved { path: path.to_owned(), reason });
        }
    }
}

/// The file in shared memory that tells whether a run lives, wherever its directory is.
pub(super) fn shared_lock(prefix: &str) -> PathBuf {
    Path::new(SHARED_MEMORY_DIRECTORY).join(format!("{prefix}{LOCK}"))
}

/// Those in shared memory; what others have put there under such a name is their business.
fn files_of_this_user(prefix: &str) -> io::Result<Vec<DirEntry>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(SHARED_MEMORY_DIRECTORY)? {
        let entry = entry?;
        let is_ours = || entry.metadata().is_ok_and(|found| found.uid() == super::user());
        if entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()) && is_ours() {
            files.push(entry);
        }
    }
    Ok(files)
}

/// Locks are removed last, so that a run that removes its own files is not taken for dead by others.
fn is_lock(entry: &DirEntry) -> bool {
    entry.file_name().as_encoded_bytes().ends_with(LOCK.as_bytes())
}

/// Whether a living process holds the lock. One that is not there was never held, or is no more.
fn is_held(lock: &Path) -> io::Result<bool> {
    let lock = match File::open(lock) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        other => other?,
    };
    match lock.try_lock() {
        Ok(()) => Ok(false),
        Err(TryLockError::WouldBlock) => Ok(true),
        Err(TryLockError::Error(error)) => Err(error),
    }
}
