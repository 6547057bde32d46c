//! Open files: how many there may be, which of them a child inherits, which of them are ready.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Write};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, FromRawFd, OwnedFd};
use std::time::{Duration, Instant};

use super::TransportError;

/// What a descriptor is looked at for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interest {
    /// That there is something to read, or never will be again.
    Read,
    /// That there is room to write, or never will be again.
    Write,
}

/// Sleeps until one of them is ready, a signal comes, or the `deadline` (`None`: never). Returns
/// which ones are ready.
pub fn poll<'a>(
    watched: impl Iterator<Item = (BorrowedFd<'a>, Interest)>,
    deadline: Option<Instant>,
) -> io::Result<Vec<bool>> {
    let mut polled: Vec<_> = watched
        .map(|(fd, interest)| libc::pollfd {
            fd: fd.as_raw_fd(),
            events: match interest {
                Interest::Read => libc::POLLIN,
                Interest::Write => libc::POLLOUT,
            },
            revents: 0,
        })
        .collect();
    let left = deadline.map(|deadline| deadline.saturating_duration_since(Instant::now()));
    let timeout = left.map(|left| libc::timespec {
        tv_sec: libc::time_t::try_from(left.as_secs()).unwrap_or(libc::time_t::MAX),
        tv_nsec: left.subsec_nanos().into(),
    });
    let timeout = timeout.as_ref().map_or(std::ptr::null(), std::ptr::from_ref);
    let count = polled.len() as libc::nfds_t;
    // SAFETY: `polled` holds that many entries, whose descriptors are open; `timeout` is null or
    // points to a whole timespec; the signal mask may be null.
    let ready = unsafe { libc::ppoll(polled.as_mut_ptr(), count, timeout, std::ptr::null()) };
    if ready < 0 {
        let error = io::Error::last_os_error();
        if error.kind() != io::ErrorKind::Interrupted {
            return Err(error);
        }
    }
    Ok(polled.iter().map(|entry| ready > 0 && entry.revents != 0).collect())
}

/// Whether a descriptor can be read, or is at its end, now.
pub fn is_any_readable(watched: &[BorrowedFd<'_>]) -> io::Result<bool> {
    let entries = watched.iter().map(|&fd| (fd, Interest::Read));
    Ok(poll(entries, Some(Instant::now()))?.contains(&true))
}

/// When a limit from now is over; `None` when it is further away than time goes.
pub fn deadline(limit: Duration) -> Option<Instant> {
    Instant::now().checked_add(limit)
}

/// A counter that can be waited for: readable once 8 bytes with a number were written to it.
pub fn event() -> io::Result<File> {
    // SAFETY: takes two numbers, and touches no memory.
    let fd = unsafe { libc::eventfd(0, libc::EFD_CLOEXEC | libc::EFD_NONBLOCK) };
    if fd < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the call has just made this descriptor, and nobody else has it.
    Ok(unsafe { File::from_raw_fd(fd) })
}

/// Makes an [`event`] readable.
pub fn ring(mut event: &File) {
    // Fails only when the counter is full, and then it was rung.
    let _ = event.write(&1_u64.to_ne_bytes());
}

/// Raises this process's limit of open files to `needed` if it is lower.
pub fn require(needed: u64) -> Result<(), TransportError> {
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

/// Reads and writes return at once from now on, done or not.
pub fn never_block(fd: &impl AsFd) -> io::Result<()> {
    let flags = get(fd, libc::F_GETFL)?;
    set(fd, libc::F_SETFL, flags | libc::O_NONBLOCK)
}

/// A started program gets the descriptor, under the same number.
pub fn hand_down(fd: &impl AsFd) -> io::Result<()> {
    set(fd, libc::F_SETFD, 0)
}

/// Makes a pipe's buffer that large if this user may have so much; it works with less.
pub fn enlarge_pipe(fd: &impl AsFd, bytes: i32) {
    let _ = set(fd, libc::F_SETPIPE_SZ, bytes);
}

fn get(fd: &impl AsFd, what: libc::c_int) -> io::Result<libc::c_int> {
    // SAFETY: the descriptor is open, and these requests take no argument.
    match unsafe { libc::fcntl(fd.as_fd().as_raw_fd(), what) } {
        -1 => Err(io::Error::last_os_error()),
        value => Ok(value),
    }
}

fn set(fd: &impl AsFd, what: libc::c_int, value: libc::c_int) -> io::Result<()> {
    // SAFETY: the descriptor is open, and these requests take a number.
    match unsafe { libc::fcntl(fd.as_fd().as_raw_fd(), what, value) } {
        -1 => Err(io::Error::last_os_error()),
        _ => Ok(()),
    }
}

/// Takes over the inherited descriptor of that number, if it is of that kind (`S_IFIFO`,
/// `S_IFSOCK` or `S_IFREG`) and nobody has taken it over before.
pub fn inherited(number: &OsStr, kind: libc::mode_t) -> Result<OwnedFd, TransportError> {
    let refuse = |why: &str| TransportError::Arguments(format!("descriptor {number:?} {why}"));
    let fd: i32 = number
        .to_str()
        .and_then(|number| number.parse().ok())
        .filter(|&fd| fd > libc::STDERR_FILENO)
        .ok_or_else(|| refuse("is no number above 2"))?;
    let mut found = std::mem::MaybeUninit::<libc::stat>::uninit();
    // SAFETY: any number may be asked about, and `found` has room for one stat.
    if unsafe { libc::fstat(fd, found.as_mut_ptr()) } != 0 {
        return Err(refuse("is not open"));
    }
    // SAFETY: the call succeeded, so it filled `found`.
    if unsafe { found.assume_init() }.st_mode & libc::S_IFMT != kind {
        return Err(refuse("is of another kind"));
    }
    // SAFETY: asks about a descriptor that is open.
    if unsafe { libc::fcntl(fd, libc::F_GETFD) } & libc::FD_CLOEXEC != 0 {
        return Err(refuse("was not inherited, or belongs to somebody"));
    }
    // SAFETY: it is open, and nobody owns it: everything that this process opened itself would be
    // closed in a child, and the check above is what the next line makes fail from now on.
    let fd = unsafe { OwnedFd::from_raw_fd(fd) };
    set(&fd, libc::F_SETFD, libc::FD_CLOEXEC).map_err(|error| refuse(&error.to_string()))?;
    Ok(fd)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_files_than_allowed_is_an_error_and_fewer_are_granted() {
        assert!(require(64).is_ok());
        let refused = require(u64::MAX - 1).unwrap_err().to_string();
        assert!(refused.contains("fewer workers"), "{refused}");
    }

    #[test]
    fn a_descriptor_is_taken_over_once_and_only_if_it_is_what_it_should_be() {
        let refused = |number: &str, kind| inherited(OsStr::new(number), kind).unwrap_err();
        for number in ["", "x", "-1", "0", "2", "1000000"] {
            refused(number, libc::S_IFIFO);
        }
        let (reader, _writer) = io::pipe().unwrap();
        let number = reader.as_raw_fd().to_string();
        refused(&number, libc::S_IFIFO); // ours: made to be closed in a child
        hand_down(&reader).unwrap();
        refused(&number, libc::S_IFSOCK);
        let _given_away = std::mem::ManuallyDrop::new(reader);
        let taken = inherited(OsStr::new(&number), libc::S_IFIFO).unwrap();
        refused(&number, libc::S_IFIFO);
        drop(taken);
    }

    #[test]
    fn what_is_ready_is_told_apart_from_what_is_not() {
        let (reader, writer) = io::pipe().unwrap();
        let both = || [(reader.as_fd(), Interest::Read), (writer.as_fd(), Interest::Write)];
        assert_eq!(poll(both().into_iter(), None).unwrap(), [false, true]);
        assert!(!is_any_readable(&[reader.as_fd()]).unwrap());
        drop(writer);
        assert!(is_any_readable(&[reader.as_fd()]).unwrap(), "its end is something to read");
    }
}
