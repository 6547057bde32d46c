//! Memory that one process goes on writing while workers read what it has told them of.

use std::fs::{File, OpenOptions};
use std::io;
use std::ops::Deref;
use std::os::fd::AsRawFd;
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::ptr::NonNull;

use super::channel::service_error;
use super::room::SHARED_MEMORY_DIRECTORY;
use super::run_directory;
use crate::transport::TransportError;

/// Ends the name of such a file: it takes pages as it is written, not before.
pub(super) const GROWING: &str = ".growing";

/// The writer's. Zeroes, which take no memory until something is written. Workers keep what they
/// have when this is dropped, and no other gets it.
#[derive(Debug)]
pub struct Growing {
    file: File,
    path: PathBuf,
    mapped: Grown,
}

/// A reader's. What it was told of stays as it is; nothing else is to be looked at.
#[derive(Debug)]
pub struct Grown {
    start: NonNull<u8>,
    bytes: usize,
}

impl Growing {
    pub(super) fn create(run: &Path, number: u32, bytes: usize) -> Result<Self, TransportError> {
        let path = path(run, number);
        let failed = || service_error(format!("make {bytes} bytes of shared memory"));
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true).mode(0o600);
        let file = options.open(&path).map_err(failed())?;
        file.set_len(bytes as u64).map_err(failed())?;
        let mapped = Grown::map(&file).map_err(failed())?;
        Ok(Self { file, path, mapped })
    }

    /// Not through the mapping: where no memory is left, this is an error and not a signal.
    pub fn write(&self, at: usize, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all_at(bytes, at as u64)
    }
}

impl Deref for Growing {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.mapped
    }
}

impl Drop for Growing {
    fn drop(&mut self) {
        // If it fails, the run's directory takes it along.
        let _ = std::fs::remove_file(&self.path);
    }
}

impl Grown {
    pub(super) fn open(run: &Path, number: u32) -> Result<Self, TransportError> {
        let file = File::open(path(run, number));
        let map = file.and_then(|file| Self::map(&file));
        map.map_err(service_error(format!("map what the leader has of tree {number}")))
    }

    fn map(file: &File) -> io::Result<Self> {
        let bytes = usize::try_from(file.metadata()?.len()).map_err(io::Error::other)?;
        let (access, shared) = (libc::PROT_READ, libc::MAP_SHARED);
        // SAFETY: a new mapping, where the kernel wants it, of a file that is that long and that
        // nobody makes shorter.
        let start =
            unsafe { libc::mmap(std::ptr::null_mut(), bytes, access, shared, file.as_raw_fd(), 0) };
        if start == libc::MAP_FAILED {
            return Err(io::Error::last_os_error());
        }
        Ok(Self { start: NonNull::new(start.cast()).expect("nothing is mapped at zero"), bytes })
    }
}

impl Deref for Grown {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        // SAFETY: that many bytes are mapped until this is dropped. Their writer is the leader alone,
        // which changes only what it has told nobody of. A reader looks only at what it was told of,
        // by a message that was sent after the writing was done: sending and receiving it (a release
        // and an acquire of the queue's index, or one process's own order) puts every such write
        // before every such read.
        unsafe { std::slice::from_raw_parts(self.start.as_ptr(), self.bytes) }
    }
}

impl Drop for Grown {
    fn drop(&mut self) {
        // SAFETY: exactly what was mapped, and nobody borrows it any more.
        unsafe { libc::munmap(self.start.as_ptr().cast(), self.bytes) };
    }
}

fn path(run: &Path, number: u32) -> PathBuf {
    let prefix = run_directory::prefix(run).unwrap_or_default();
    Path::new(SHARED_MEMORY_DIRECTORY).join(format!("{prefix}tree-{number}{GROWING}"))
}
