//! Makes sure of memory before it is written: a full `/dev/shm` is a signal (SIGBUS) to whoever
//! touches a new page first, not an error.

use std::ffi::CString;
use std::fs::OpenOptions;
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::time::Duration;

use crate::transport::TransportError;

pub const SHARED_MEMORY_DIRECTORY: &str = "/dev/shm";

/// Refuses to begin when `directory` cannot hold `needed` bytes more.
pub fn require_room(directory: &Path, needed: u64) -> Result<(), TransportError> {
    let free = free_bytes(directory).map_err(|error| TransportError::RunDirectory {
        path: directory.to_owned(),
        reason: error.to_string(),
    })?;
    if free < needed {
        return Err(TransportError::NoRoom { directory: directory.to_owned(), needed, free });
    }
    Ok(())
}

fn free_bytes(directory: &Path) -> io::Result<u64> {
    let path = CString::new(directory.as_os_str().as_bytes())?;
    let mut found = std::mem::MaybeUninit::<libc::statvfs>::uninit();
    // SAFETY: `path` ends with a zero byte and `found` has room for one statvfs.
    if unsafe { libc::statvfs(path.as_ptr(), found.as_mut_ptr()) } != 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the call succeeded, so it filled `found`.
    let found = unsafe { found.assume_init() };
    if found.f_blocks == 0 {
        return Ok(u64::MAX); // a tmpfs without a limit of its own reports no size at all
    }
    Ok(found.f_bavail.saturating_mul(found.f_frsize))
}

/// Raises this process's limit of open files to `needed` if it is lower.
pub fn require_descriptors(needed: u64) -> Result<(), TransportError> {
    let refuse = |reason: String| TransportError::Service {
        action: format!("open {needed} files at once"),
        reason,
    };
    let mut limit = libc::rlimit { rlim_cur: 0, rlim_max: 0 };
    // SAFETY: `limit` is a whole rlimit, which the call fills.
    if unsafe { libc::getrlimit(libc::RLIMIT_NOFILE, &mut limit) } != 0 {
        return Err(refuse(io::Error::last_os_error().to_string()));
    }
    if limit.rlim_cur >= needed {
        return Ok(());
    }
    if limit.rlim_max < needed {
        let most = limit.rlim_max;
        return Err(refuse(format!("at most {most} are allowed (ulimit -Hn): use fewer workers")));
    }
    limit.rlim_cur = needed;
    // SAFETY: `limit` is a whole rlimit, which the call reads.
    match unsafe { libc::setrlimit(libc::RLIMIT_NOFILE, &limit) } {
        0 => Ok(()),
        _ => Err(refuse(io::Error::last_os_error().to_string())),
    }
}

/// Gives every file of this run its pages now, so that no later write can fail.
pub fn reserve(prefix: &str) -> Result<(), TransportError> {
    let refuse = |error: io::Error| TransportError::Service {
        action: format!("reserve memory in {SHARED_MEMORY_DIRECTORY}"),
        reason: error.to_string(),
    };
    for entry in std::fs::read_dir(SHARED_MEMORY_DIRECTORY).map_err(refuse)? {
        let entry = entry.map_err(refuse)?;
        if entry.file_name().as_encoded_bytes().starts_with(prefix.as_bytes()) {
            reserve_file(&entry.path()).map_err(refuse)?;
        }
    }
    Ok(())
}

fn reserve_file(path: &Path) -> io::Result<()> {
    let file = match OpenOptions::new().write(true).open(path) {
        Ok(file) => file,
        // Another process of the run is still making this file, or has just removed it.
        Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied) => {
            return Ok(());
        }
        Err(error) => return Err(error),
    };
    let found = file.metadata()?;
    if found.blocks() * 512 >= found.len() {
        return Ok(());
    }
    let length = libc::off_t::try_from(found.len()).map_err(io::Error::other)?;
    // SAFETY: the descriptor is open for writing, and the range is the file's own.
    while unsafe { libc::fallocate(file.as_raw_fd(), 0, 0, length) } != 0 {
        let error = io::Error::last_os_error();
        if error.kind() != io::ErrorKind::Interrupted {
            return Err(error);
        }
    }
    Ok(())
}

/// Removes connections that a worker was killed over while it made them. iceoryx2 0.10 waits for
/// ever for such a file to grow; one that is being made grows within microseconds.
pub fn remove_half_made_connections(prefix: &str) -> io::Result<()> {
    let half_made = |path: &Path| path.metadata().is_ok_and(|found| found.len() == 0);
    let mut suspects = Vec::new();
    for entry in std::fs::read_dir(SHARED_MEMORY_DIRECTORY)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.as_bytes();
        if name.starts_with(prefix.as_bytes()) && name.ends_with(b".connection") {
            suspects.push(entry.path());
        }
    }
    suspects.retain(|path| half_made(path));
    if suspects.is_empty() {
        return Ok(());
    }
    std::thread::sleep(TIME_TO_GROW);
    for path in suspects.iter().filter(|path| half_made(path)) {
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    Ok(())
}

const TIME_TO_GROW: Duration = Duration::from_millis(20);

/// Makes the pages under `bytes` writable, or says that there are none left.
pub fn populate(start: *mut u8, bytes: usize) -> io::Result<()> {
    // SAFETY: takes a name and cannot fail for this one.
    let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) } as usize;
    let offset = start.addr() % page;
    let first = start.wrapping_sub(offset);
    // SAFETY: the pages around `bytes` belong to one mapping of this process, and populating
    // them changes no byte of them.
    match unsafe { libc::madvise(first.cast(), bytes + offset, libc::MADV_POPULATE_WRITE) } {
        0 => Ok(()),
        _ => match io::Error::last_os_error() {
            // Older kernels cannot; the reservation of the file has to do.
            error if error.raw_os_error() == Some(libc::EINVAL) => Ok(()),
            error => Err(error),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_little_room_names_both_numbers_and_a_remedy() {
        let refused = require_room(Path::new("/dev/shm"), u64::MAX - 1).unwrap_err().to_string();
        assert!(refused.contains(&(u64::MAX - 1).to_string()), "{refused}");
        assert!(refused.contains("--shm-size"), "{refused}");
        assert!(require_room(Path::new("/dev/shm"), 0).is_ok());
    }

    #[test]
    fn more_files_than_allowed_is_an_error_and_fewer_are_granted() {
        assert!(require_descriptors(64).is_ok());
        let refused = require_descriptors(u64::MAX - 1).unwrap_err().to_string();
        assert!(refused.contains("fewer workers"), "{refused}");
    }

    #[test]
    fn a_missing_directory_is_an_error_that_names_it() {
        let refused = require_room(Path::new("/no/such/place"), 1).unwrap_err().to_string();
        assert!(refused.starts_with("/no/such/place"), "{refused}");
    }

    #[test]
    fn a_reserved_file_owns_all_its_pages() {
        let prefix = format!("bumper_room_test_{}_", std::process::id());
        let path = Path::new(SHARED_MEMORY_DIRECTORY).join(format!("{prefix}file"));
        let file = std::fs::File::create(&path).unwrap();
        file.set_len(1 << 20).unwrap();
        let before = file.metadata().unwrap().blocks();
        let reserved = reserve(&prefix);
        let after = file.metadata().unwrap().blocks();
        std::fs::remove_file(&path).unwrap();
        reserved.unwrap();
        assert_eq!((before, after), (0, (1 << 20) / 512));
    }

    #[test]
    fn only_connections_that_stay_empty_are_removed() {
        let prefix = format!("bumper_half_made_test_{}_", std::process::id());
        let path = |name| Path::new(SHARED_MEMORY_DIRECTORY).join(format!("{prefix}{name}"));
        let files = ["dead.connection", "whole.connection", "other.data"].map(path);
        std::fs::write(&files[0], "").unwrap();
        std::fs::write(&files[1], "x").unwrap();
        std::fs::write(&files[2], "").unwrap();
        let removed = remove_half_made_connections(&prefix);
        let left = files.each_ref().map(|file| std::fs::remove_file(file).is_ok());
        removed.unwrap();
        assert_eq!(left, [false, true, true]);
    }
}
