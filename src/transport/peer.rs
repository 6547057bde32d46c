//! Streams between workers, which know nothing of each other but a name that the master passes on.
//!
//! A worker that others can reach listens on a Unix socket in the abstract namespace, so that
//! nothing of it is in the file system and nothing stays behind. The name cannot be guessed, and
//! whoever has it all the same has to be of the same user: each end asks the kernel who the other is.

use std::fmt::{Debug, Formatter};
use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd};
use std::os::linux::net::SocketAddrExt;
use std::os::unix::net::{SocketAddr, UnixListener, UnixStream};
use std::time::Instant;

use super::descriptors::{Interest, poll};

/// By which a worker is reached.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct PeerName([u8; PeerName::BYTES]);

impl PeerName {
    pub const BYTES: usize = 16;

    pub fn from_bytes(bytes: [u8; Self::BYTES]) -> Self {
        Self(bytes)
    }

    pub fn to_bytes(self) -> [u8; Self::BYTES] {
        self.0
    }

    fn random() -> io::Result<Self> {
        let mut name = [0; Self::BYTES];
        getrandom::fill(&mut name).map_err(io::Error::other)?;
        Ok(Self(name))
    }

    fn address(self) -> io::Result<SocketAddr> {
        SocketAddr::from_abstract_name(format!("bumper-{self:?}"))
    }
}

impl Debug for PeerName {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// Where others reach this process. Never waits for anybody.
#[derive(Debug)]
pub struct PeerListener {
    socket: UnixListener,
    name: PeerName,
}

impl PeerListener {
    pub fn open() -> io::Result<Self> {
        let name = PeerName::random()?;
        let socket = UnixListener::bind_addr(&name.address()?)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, name })
    }

    pub fn name(&self) -> PeerName {
        self.name
    }

    /// A stream that does not block, if anybody of the same user has come. Others are sent away.
    pub fn accept(&self) -> io::Result<Option<UnixStream>> {
        loop {
            match self.socket.accept() {
                Ok((stream, _)) if is_of_same_user(&stream)? => {
                    stream.set_nonblocking(true)?;
                    return Ok(Some(stream));
                }
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(None),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

impl AsFd for PeerListener {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

/// A stream to another worker, on which nothing takes longer than to a deadline.
#[derive(Debug)]
pub struct PeerStream(UnixStream);

impl PeerStream {
    pub fn connect(name: PeerName) -> io::Result<Self> {
        let stream = UnixStream::connect_addr(&name.address()?)?;
        if !is_of_same_user(&stream)? {
            return Err(io::Error::new(ErrorKind::PermissionDenied, "it is another user's"));
        }
        stream.set_nonblocking(true)?;
        Ok(Self(stream))
    }

    pub fn write_all(&mut self, mut bytes: &[u8], deadline: Instant) -> io::Result<()> {
        while !bytes.is_empty() {
            let count = self.in_time(Interest::Write, deadline, |mut s| s.write(bytes))?;
            bytes = &bytes[count..];
        }
        Ok(())
    }

    pub fn read_exact(&mut self, mut room: &mut [u8], deadline: Instant) -> io::Result<()> {
        while !room.is_empty() {
            match self.in_time(Interest::Read, deadline, |mut s| s.read(room))? {
                0 => return Err(ErrorKind::UnexpectedEof.into()),
                count => room = &mut room[count..],
            }
        }
        Ok(())
    }

    fn in_time(
        &self,
        interest: Interest,
        deadline: Instant,
        mut attempt: impl FnMut(&UnixStream) -> io::Result<usize>,
    ) -> io::Result<usize> {
        loop {
            match attempt(&self.0) {
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                done => return done,
            }
            if Instant::now() >= deadline {
                return Err(ErrorKind::TimedOut.into());
            }
            poll([(self.0.as_fd(), interest)].into_iter(), Some(deadline))?;
        }
    }
}

fn is_of_same_user(stream: &UnixStream) -> io::Result<bool> {
    let mut peer = libc::ucred { pid: 0, uid: 0, gid: 0 };
    let mut length = size_of::<libc::ucred>() as libc::socklen_t;
    // SAFETY: the descriptor is open; `peer` has room for `length` bytes, any of which make one.
    let failed = unsafe {
        libc::getsockopt(
            stream.as_raw_fd(),
            libc::SOL_SOCKET,
            libc::SO_PEERCRED,
            (&raw mut peer).cast(),
            &raw mut length,
        )
    };
    if failed != 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: asks for a number.
    Ok(peer.uid == unsafe { libc::geteuid() })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    fn soon() -> Instant {
        Instant::now() + Duration::from_secs(60)
    }

    #[test]
    fn what_one_end_writes_the_other_reads() {
        let listener = PeerListener::open().unwrap();
        assert!(listener.accept().unwrap().is_none());
        let mut one = PeerStream::connect(listener.name()).unwrap();
        let mut other = PeerStream(listener.accept().unwrap().unwrap());
        let long = vec![7; 3 << 20];
        std::thread::scope(|scope| {
            scope.spawn(|| one.write_all(&long, soon()).unwrap());
            let mut read = vec![0; long.len()];
            other.read_exact(&mut read, soon()).unwrap();
            assert!(read == long);
        });
        drop(one);
        let ended = other.read_exact(&mut [0], soon()).unwrap_err();
        assert_eq!(ended.kind(), ErrorKind::UnexpectedEof);
    }

    /// As with one that is stopped: the kernel takes the connection, and nobody answers.
    #[test]
    fn nobody_is_waited_for_beyond_the_deadline() {
        let listener = PeerListener::open().unwrap();
        let mut stream = PeerStream::connect(listener.name()).unwrap();
        let deadline = Instant::now() + Duration::from_millis(20);
        let late = stream.read_exact(&mut [0; 8], deadline).unwrap_err();
        assert_eq!(late.kind(), ErrorKind::TimedOut);
        let late = stream.write_all(&vec![0; 64 << 20], deadline).unwrap_err();
        assert_eq!(late.kind(), ErrorKind::TimedOut);
        assert!(Instant::now() >= deadline);
    }

    #[test]
    fn names_differ_and_one_that_nobody_has_is_refused() {
        let [one, other] = [0, 1].map(|_| PeerListener::open().unwrap());
        assert_ne!(one.name(), other.name());
        let gone = one.name();
        drop(one);
        assert!(PeerStream::connect(gone).is_err());
        assert_eq!(PeerName::from_bytes(gone.to_bytes()), gone);
    }

    /// The process of another user, if this one may become it.
    #[test]
    fn another_user_is_sent_away() {
        let (stream, _other) = UnixStream::pair().unwrap();
        assert!(is_of_same_user(&stream).unwrap());
        let as_another = || {
            let listener = PeerListener::open().unwrap();
            let _stream = PeerStream::connect(listener.name()).unwrap();
            // SAFETY: changes the user of this thread alone, as a raw call does.
            if unsafe { libc::syscall(libc::SYS_setresuid, -1, 65_534, -1) } != 0 {
                eprintln!("skipped: no right to be another user here");
                return;
            }
            assert!(listener.accept().unwrap().is_none(), "it is not of this user");
        };
        std::thread::scope(|scope| scope.spawn(as_another).join().unwrap());
    }
}
