//! Makes sure of memory before it is written: a full `/dev/shm` is a signal (SIGBUS) to whoever
//! touches a new page first, not an error.

use std::ffi::CString;
use std::fs::OpenOptions;
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use std::sync::Once;

use super::growing::GROWING;
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

/// What iceoryx2 makes it touches before anybody can [`reserve`] it. If others fill `/dev/shm` at
/// that moment, this process ends with this sentence; what it leaves behind, the next run removes.
const RAN_FULL: &[u8] =
    b"error: /dev/shm has just run full: free some of it, use fewer workers or \
smaller meshes, or make it larger (Docker: --shm-size)\n";

/// From now on a page that cannot be had ends this process with an error, not with a signal.
pub fn explain_missing_pages() {
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(|| {
        let handler: extern "C" fn(libc::c_int, *mut libc::siginfo_t, *mut libc::c_void) =
            page_missing;
        // SAFETY: all zeros is a sigaction without flags and with an empty mask.
        let mut action: libc::sigaction = unsafe { std::mem::zeroed() };
        action.sa_sigaction = handler as usize;
        action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK | libc::SA_RESETHAND;
        // SAFETY: `action` is whole, and its handler does only what one may. It cannot fail for
        // this signal.
        unsafe { libc::sigaction(libc::SIGBUS, &action, std::ptr::null_mut()) };
    });
}

extern "C" fn page_missing(_: libc::c_int, info: *mut libc::siginfo_t, _: *mut libc::c_void) {
    // SAFETY: the kernel passes a whole siginfo; both calls may be made in a signal handler.
    unsafe {
        if (*info).si_code == libc::BUS_ADRERR {
            libc::write(libc::STDERR_FILENO, RAN_FULL.as_ptr().cast(), RAN_FULL.len());
            libc::_exit(1);
        }
    }
    // Anything else comes again at once, and is what it would be without this handler.
}

/// Gives every file of this run its pages now, so that no later write can fail, and closes to other
/// users what iceoryx2 leaves open to them: its file that counts the nodes.
pub fn reserve(prefix: &str) -> Result<(), TransportError> {
    let refuse = |error: io::Error| TransportError::Service {
        action: format!("reserve memory in {SHARED_MEMORY_DIRECTORY}"),
        reason: error.to_string(),
    };
    for entry in std::fs::read_dir(SHARED_MEMORY_DIRECTORY).map_err(refuse)? {
        let entry = entry.map_err(refuse)?;
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        if name.starts_with(prefix.as_bytes()) && !name.ends_with(GROWING.as_bytes()) {
            reserve_file(&entry.path()).map_err(refuse)?;
        }
    }
    Ok(())
}

pub fn reserve_file(path: &Path) -> io::Result<()> {
    let file = match OpenOptions::new().write(true).open(path) {
        Ok(file) => file,
        // Another process of the run is still making this file, or has just removed it.
        Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied) => {
            return Ok(());
        }
        Err(error) => return Err(error),
    };
    let found = file.metadata()?;
    if found.mode() & 0o077 != 0 {
        file.set_permissions(std::fs::Permissions::from_mode(0o600))?;
    }
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

/// Removes what a worker that was killed left of its message queues, given the ports of the
/// master's side. In iceoryx2 0.10 a connection is named `…_<publisher>_<subscriber>.connection`,
/// and the memory of a publisher's samples `…_<publisher>.data`.
pub fn remove_queues(prefix: &str, publisher: u128, subscriber: u128) -> io::Result<()> {
    let (publisher, subscriber) = (publisher.to_string(), subscriber.to_string());
    let names = std::fs::read_dir(SHARED_MEMORY_DIRECTORY)?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.starts_with(prefix))
        .collect::<Vec<_>>();
    let remove =
        |name: &str| match std::fs::remove_file(Path::new(SHARED_MEMORY_DIRECTORY).join(name)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        };
    for connection in &names {
        let Some(ports) = connection.strip_suffix(".connection") else { continue };
        let Some((ports, to)) = ports.rsplit_once('_') else { continue };
        let from = ports.rsplit_once('_').map_or(ports, |(_, from)| from);
        if to == subscriber || from == publisher {
            remove(connection)?;
            let samples = format!("_{from}.data");
            names
                .iter()
                .filter(|name| name.ends_with(&samples))
                .try_for_each(|name| remove(name))?;
        }
    }
    Ok(())
}

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
}
