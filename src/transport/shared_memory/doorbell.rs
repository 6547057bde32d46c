//! Wakes a sleeping process: a FIFO in the run's directory.
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
use std::path::Path;
use std::time::Duration;

#[derive(Debug)]
pub struct Doorbell(File);

/// What a ring says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ring {
    Message = 1,
    /// A port was made that the other side has to connect to.
    NewPort = 2,
}

impl Doorbell {
    pub fn create(path: &Path) -> io::Result<Self> {
        let name = CString::new(path.as_os_str().as_bytes())?;
        // SAFETY: `name` ends with a zero byte.
        match unsafe { libc::mkfifo(name.as_ptr(), 0o600) } {
            0 => Self::open(path),
            _ => Err(io::Error::last_os_error()),
        }
    }

    /// Either side opens both ends, so that it sees neither an end of file nor a broken pipe.
    pub fn open(path: &Path) -> io::Result<Self> {
        let mut options = OpenOptions::new();
        options.read(true).write(true).custom_flags(libc::O_NONBLOCK);
        options.open(path).map(Self)
    }

    pub fn ring(&self, ring: Ring) -> io::Result<()> {
        match (&self.0).write(&[ring as u8]) {
            // Full of rings that nobody has answered yet.
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(()),
            other => other.map(|_| ()),
        }
    }

    /// Sleeps until it was rung, a watched descriptor can be read, a signal came, or the time is
    /// over; rings that came before count. `None` waits without limit. Returns whether there are
    /// new ports, or may be: when there was no room for a ring, it may have been about one.
    pub fn wait(&self, watched: &[BorrowedFd<'_>], limit: Option<Duration>) -> io::Result<bool> {
        let fds = std::iter::once(self.0.as_fd()).chain(watched.iter().copied());
        let mut polled: Vec<libc::pollfd> = fds
            .map(|fd| libc::pollfd { fd: fd.as_raw_fd(), events: libc::POLLIN, revents: 0 })
            .collect();
        let milliseconds = limit.map_or(-1, |limit| {
            i32::try_from(limit.as_micros().div_ceil(1000)).unwrap_or(i32::MAX)
        });
        // SAFETY: `polled` holds exactly that many entries, and their descriptors are open.
        let ready = unsafe { libc::poll(polled.as_mut_ptr(), polled.len() as _, milliseconds) };
        if ready < 0 {
            let error = io::Error::last_os_error();
            return if error.kind() == io::ErrorKind::Interrupted { Ok(false) } else { Err(error) };
        }
        self.take_rings()
    }

    fn take_rings(&self) -> io::Result<bool> {
        let mut rings = [0; 1024];
        let mut new_port = false;
        loop {
            let count = match (&self.0).read(&mut rings) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(new_port),
                other => other?,
            };
            new_port |= count == rings.len() || rings[..count].contains(&(Ring::NewPort as u8));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_before_the_wait_end_it_and_are_forgotten_together() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("bell");
        let bell = Doorbell::create(&path).unwrap();
        let ringer = Doorbell::open(&path).unwrap();
        for _ in 0..100_000 {
            ringer.ring(Ring::Message).unwrap(); // more than a pipe holds
        }
        assert!(bell.wait(&[], None).unwrap(), "one that did not fit may have been about a port");
        let begin = std::time::Instant::now();
        assert!(!bell.wait(&[], Some(Duration::from_millis(5))).unwrap());
        assert!(begin.elapsed() >= Duration::from_millis(5));
    }

    #[test]
    fn a_new_port_is_heard_among_messages() {
        let directory = tempfile::tempdir().unwrap();
        let bell = Doorbell::create(&directory.path().join("bell")).unwrap();
        for ring in [Ring::Message, Ring::NewPort, Ring::Message] {
            bell.ring(ring).unwrap();
        }
        assert!(bell.wait(&[], None).unwrap());
    }
}
