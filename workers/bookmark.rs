//! Which scenario a worker is at, in memory that outlives it: when it has died, the master knows
//! what it died at.

use std::fs::File;
use std::io;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering};

/// A page that a worker and its master share.
#[derive(Debug)]
pub struct Bookmark {
    /// The scenario's number and one more, or zero.
    cell: NonNull<AtomicU32>,
}

// SAFETY: the cell is atomic, and its page stays where it is as long as this lives.
unsafe impl Send for Bookmark {}
// SAFETY: as above.
unsafe impl Sync for Bookmark {}

const BYTES: usize = size_of::<AtomicU32>();
const FLAGS: libc::c_uint = libc::MFD_CLOEXEC | libc::MFD_ALLOW_SEALING;

impl Bookmark {
    /// At nothing; and what the other end is [opened](Self::open) from.
    pub fn new() -> io::Result<(Self, OwnedFd)> {
        // SAFETY: the name is a string that ends with a zero.
        let fd = unsafe { libc::memfd_create(c"bumper-bookmark".as_ptr(), FLAGS) };
        if fd < 0 {
            return Err(io::Error::last_os_error());
        }
        // SAFETY: the call has just made this descriptor, and nobody else has it.
        let file = unsafe { File::from_raw_fd(fd) };
        file.set_len(BYTES as u64)?;
        // Whatever a worker does to it, there will be memory where the master looks.
        let seals = libc::F_SEAL_SHRINK | libc::F_SEAL_GROW | libc::F_SEAL_SEAL;
        // SAFETY: the descriptor is open, and this request takes a number.
        if unsafe { libc::fcntl(file.as_raw_fd(), libc::F_ADD_SEALS, seals) } != 0 {
            return Err(io::Error::last_os_error());
        }
        Ok((Self::map(&file)?, file.into()))
    }

    pub fn open(file: OwnedFd) -> io::Result<Self> {
        let file = File::from(file);
        // Beyond the end of a file there is no memory, and looking there would end the process.
        match file.metadata()?.len() {
            length if length == BYTES as u64 => Self::map(&file),
            length => Err(io::Error::other(format!("a bookmark has {BYTES} bytes, not {length}"))),
        }
    }

    fn map(file: &File) -> io::Result<Self> {
        let (protection, fd) = (libc::PROT_READ | libc::PROT_WRITE, file.as_raw_fd());
        // SAFETY: asks for new pages of a file that is open and long enough.
        let page =
            unsafe { libc::mmap(std::ptr::null_mut(), BYTES, protection, libc::MAP_SHARED, fd, 0) };
        if page == libc::MAP_FAILED {
            return Err(io::Error::last_os_error());
        }
        Ok(Self { cell: NonNull::new(page.cast()).expect("nothing is mapped at zero") })
    }

    pub fn put(&self, scenario: u32) {
        self.cell().store(scenario.wrapping_add(1), Ordering::Relaxed);
    }

    pub fn take_out(&self) {
        self.cell().store(0, Ordering::Relaxed);
    }

    pub fn scenario(&self) -> Option<u32> {
        self.cell().load(Ordering::Relaxed).checked_sub(1)
    }

    fn cell(&self) -> &AtomicU32 {
        // SAFETY: the page is mapped until this is dropped, holds a number at its beginning, and is
        // only ever looked at as this atomic one.
        unsafe { self.cell.as_ref() }
    }
}

impl Drop for Bookmark {
    fn drop(&mut self) {
        // SAFETY: this is what was mapped, and nobody has a reference into it any more.
        unsafe { libc::munmap(self.cell.as_ptr().cast(), BYTES) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_worker_was_at_is_seen_at_the_other_end_and_outlives_it() {
        let (masters, handed_down) = Bookmark::new().unwrap();
        assert_eq!(masters.scenario(), None);
        let workers = Bookmark::open(handed_down).unwrap();
        workers.put(7);
        assert_eq!(masters.scenario(), Some(7));
        workers.put(0);
        drop(workers);
        assert_eq!(masters.scenario(), Some(0));
        masters.take_out();
        assert_eq!(masters.scenario(), None);
    }

    #[test]
    fn a_worker_cannot_take_the_memory_away_that_the_master_looks_at() {
        let (masters, handed_down) = Bookmark::new().unwrap();
        let file = File::from(handed_down);
        assert!(file.set_len(0).is_err() && file.set_len(1 << 20).is_err());
        assert_eq!(masters.scenario(), None);
    }

    #[test]
    fn a_file_that_is_no_bookmark_is_refused() {
        let refused = Bookmark::open(tempfile::tempfile().unwrap().into()).unwrap_err();
        assert!(refused.to_string().contains("4 bytes, not 0"), "{refused}");
    }
}
