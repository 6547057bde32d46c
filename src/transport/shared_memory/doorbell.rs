//! Wakes a sleeping process: a FIFO in the run's directory, and a page in shared memory that says
//! whether anybody sleeps there. A side that is awake is not rung, which saves a system call a
//! message.
//!
//! Not an iceoryx2 event, which can leave its listener asleep for good. In 0.10
//! (`cal/event/common.rs`) a notifier sends no datagram while the listener's state says `notified`,
//! and a listener that empties its socket between a notifier's datagram and that notifier's change
//! of state is left with that state and an empty socket: every later notification counts as
//! already sent. Seen with one notifier, whose later notifications woke nobody: with a listener in
//! a `WaitSet` after 14,000 and after 370,000 of them, in `poll` after 1,150,000; other runs of a
//! minute lost none. `blocking_wait`, which looks at the state first, is not concerned; but the
//! master sleeps on its workers' deaths too. A byte in a pipe wakes its reader, whenever it was
//! written.

use std::ffi::CString;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use super::room;
use crate::transport::descriptors::{Interest, poll};
use crate::transport::wake_up::Asleep;

/// Of one sleeper. Both sides have the page; who sleeps reads the FIFO, who rings writes to it.
#[derive(Debug)]
pub struct Doorbell {
    fifo: File,
    page: Page,
}

/// Where a bell's FIFO and its page are.
#[derive(Clone, Debug)]
pub struct Place {
    pub fifo: PathBuf,
    pub page: PathBuf,
}

impl Place {
    pub fn remove(&self) -> io::Result<()> {
        std::fs::remove_file(&self.fifo)?;
        std::fs::remove_file(&self.page)
    }
}

impl Doorbell {
    /// The master makes all bells, and opens each for both, so that ringing one whose worker has
    /// gone is no error, and its own never comes to an end.
    pub fn create(place: &Place) -> io::Result<Self> {
        let name = CString::new(place.fifo.as_os_str().as_bytes())?;
        // SAFETY: `name` ends with a zero byte.
        if unsafe { libc::mkfifo(name.as_ptr(), 0o600) } != 0 {
            return Err(io::Error::last_os_error());
        }
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true).mode(0o600);
        let page = options.open(&place.page)?;
        page.set_len(size_of::<Flags>() as u64)?;
        room::reserve_file(&place.page)?;
        let fifo = open(&place.fifo, OpenOptions::new().read(true).write(true))?;
        Ok(Self { fifo, page: Page::map(&page)? })
    }

    /// The bell comes to its end when the master closes it.
    pub fn open_to_sleep(place: &Place) -> io::Result<Self> {
        Self::open(place, OpenOptions::new().read(true))
    }

    /// Fails when the master has gone.
    pub fn open_to_ring(place: &Place) -> io::Result<Self> {
        Self::open(place, OpenOptions::new().write(true))
    }

    fn open(place: &Place, options: &mut OpenOptions) -> io::Result<Self> {
        let page = OpenOptions::new().read(true).write(true).open(&place.page)?;
        Ok(Self { fifo: open(&place.fifo, options)?, page: Page::map(&page)? })
    }

    /// To be called after a message was left.
    pub fn ring_if_asleep(&self) -> io::Result<()> {
        if !self.page.flags().asleep.has_to_be_rung() {
            return Ok(());
        }
        match (&self.fifo).write(&[1]) {
            // Full of rings that nobody has answered yet.
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(()),
            other => other.map(|_| ()),
        }
    }

    /// Tells the sleeper of a port that it has to connect to.
    pub fn add_port(&self) -> io::Result<()> {
        self.page.flags().ports.fetch_add(1, Ordering::Release);
        self.ring_if_asleep()
    }

    /// How often there was a new port.
    pub fn ports(&self) -> u32 {
        self.page.flags().ports.load(Ordering::Acquire)
    }

    /// Sleeps until it is rung, comes to its end, a watched descriptor can be read, or the
    /// `deadline`; but not at all if `look`, which looks for what nobody may have rung for, finds
    /// something. Returns what it found, or else whether a watched descriptor can be read.
    pub fn sleep(
        &self,
        watched: &[BorrowedFd<'_>],
        deadline: Option<Instant>,
        look: impl FnOnce() -> bool,
    ) -> io::Result<bool> {
        let asleep = &self.page.flags().asleep;
        asleep.fall();
        let found = look();
        let woken = match found {
            true => Ok(Vec::new()),
            false => {
                let descriptors = watched.iter().copied().chain([self.fifo.as_fd()]);
                poll(descriptors.map(|fd| (fd, Interest::Read)), deadline)
            }
        };
        asleep.wake();
        Ok(found || woken?[..watched.len()].contains(&true))
    }

    /// Forgets all rings. Returns whether the bell has come to its end.
    pub fn has_ended(&self) -> io::Result<bool> {
        let mut rings = [0; 1024];
        loop {
            match (&self.fifo).read(&mut rings) {
                Ok(0) => return Ok(true),
                Ok(_) => {}
                Err(error) => match error.kind() {
                    io::ErrorKind::WouldBlock => return Ok(false),
                    io::ErrorKind::Interrupted => {}
                    _ => return Err(error),
                },
            }
        }
    }
}

fn open(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    options.custom_flags(libc::O_NONBLOCK).open(path)
}

/// What both sides of a bell see.
#[derive(Debug)]
#[repr(C)]
struct Flags {
    asleep: Asleep,
    ports: AtomicU32,
}

#[derive(Debug)]
struct Page(NonNull<Flags>);

// SAFETY: nothing but atomics behind the pointer, which stays valid until it is dropped.
unsafe impl Send for Page {}
// SAFETY: as above.
unsafe impl Sync for Page {}

impl Page {
    fn map(file: &File) -> io::Result<Self> {
        let (length, fd) = (size_of::<Flags>(), file.as_raw_fd());
        if file.metadata()?.len() < length as u64 {
            return Err(io::Error::other("a doorbell's page is too short"));
        }
        let (access, shared) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_SHARED);
        // SAFETY: a new mapping, where the kernel wants it, of a file that is long enough.
        let page = unsafe { libc::mmap(std::ptr::null_mut(), length, access, shared, fd, 0) };
        if page == libc::MAP_FAILED {
            return Err(io::Error::last_os_error());
        }
        Ok(Self(NonNull::new(page.cast()).expect("the kernel maps nothing at zero")))
    }

    fn flags(&self) -> &Flags {
        // SAFETY: the mapping is that long, on a page's boundary, and lives as long as `self`; any
        // bits are a valid value, and all access to them is atomic, in other processes too.
        unsafe { self.0.as_ref() }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // SAFETY: exactly what `map` has mapped, and nobody borrows it any more.
        unsafe { libc::munmap(self.0.as_ptr().cast(), size_of::<Flags>()) };
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn place(directory: &Path) -> Place {
        Place { fifo: directory.join("fifo"), page: directory.join("page") }
    }

    #[test]
    fn a_ring_during_the_last_look_ends_the_sleep_and_is_forgotten() {
        let directory = tempfile::tempdir().unwrap();
        let place = place(directory.path());
        let bell = Doorbell::create(&place).unwrap();
        let ringer = Doorbell::open_to_ring(&place).unwrap();
        let ring = || {
            ringer.ring_if_asleep().unwrap();
            false
        };
        assert!(!bell.sleep(&[], None, ring).unwrap());
        assert!(!bell.has_ended().unwrap());

        ringer.ring_if_asleep().unwrap(); // nobody sleeps: nothing is written
        let limit = Duration::from_millis(5);
        let begin = Instant::now();
        assert!(!bell.sleep(&[], Some(begin + limit), || false).unwrap());
        assert!(begin.elapsed() >= limit);
        assert!(bell.sleep(&[], None, || true).unwrap(), "found before sleeping");
    }

    #[test]
    fn a_bell_ends_with_its_master_on_either_side() {
        let directory = tempfile::tempdir().unwrap();
        let place = place(directory.path());
        let masters = Doorbell::create(&place).unwrap();
        let sleeper = Doorbell::open_to_sleep(&place).unwrap();
        let ringer = Doorbell::open_to_ring(&place).unwrap();
        assert!(!sleeper.has_ended().unwrap());
        ringer.add_port().unwrap();
        assert_eq!(masters.ports(), 1);
        drop((masters, ringer));
        sleeper.sleep(&[], None, || false).unwrap();
        assert!(sleeper.has_ended().unwrap());
        drop(sleeper);
        assert!(Doorbell::open_to_ring(&place).is_err());
    }

    /// Each waits for the other's turn: one lost wake-up and the test never ends.
    #[test]
    fn no_wake_up_is_lost_however_the_two_sides_meet() {
        use std::sync::Arc;
        let directory = tempfile::tempdir().unwrap();
        let places = ["a", "b"].map(|name| directory.path().join(name));
        places.iter().for_each(|place| std::fs::create_dir(place).unwrap());
        let bells = places.map(|path| Arc::new(Doorbell::create(&place(&path)).unwrap()));
        let turn = Arc::new(AtomicU32::new(0));
        const TURNS: u32 = 20_000;
        let threads = [0, 1].map(|side: u32| {
            let (bells, turn) = (bells.clone(), turn.clone());
            std::thread::spawn(move || {
                let (own, other) = (&bells[side as usize], &bells[1 - side as usize]);
                for mine in (side..TURNS).step_by(2) {
                    while turn.load(Ordering::Relaxed) != mine {
                        let look = || turn.load(Ordering::Relaxed) == mine;
                        own.sleep(&[], None, look).unwrap();
                        own.has_ended().unwrap();
                    }
                    turn.store(mine + 1, Ordering::Relaxed);
                    other.ring_if_asleep().unwrap();
                }
            })
        });
        threads.into_iter().for_each(|thread| thread.join().unwrap());
        assert_eq!(turn.load(Ordering::Relaxed), TURNS);
    }
}
