//! A Unix stream socket to each worker. The master looks at all of them.

use std::ffi::OsString;
use std::fs::File;
use std::io;
use std::os::fd::{BorrowedFd, OwnedFd};
use std::os::unix::net::UnixStream;

use super::master::{Ends, Link, Streams};
use super::worker::StreamWorker;
use crate::transport::attach::{self, Attach};
use crate::transport::descriptors::{hand_down, inherited, never_block};
use crate::transport::{Needs, TransportError, WorkerId};

pub const NAME: &str = "socket";

const KEYS: [&str; 3] = ["--wake-up", "--longest", "--stream"];

/// The master's end.
pub type Sockets = Streams<NoSignal>;

/// Each worker's own stream is looked at.
#[derive(Debug)]
pub struct NoSignal;

impl Sockets {
    pub fn create(needs: &Needs) -> Result<Self, TransportError> {
        Self::over(NoSignal, needs)
    }
}

impl Link for NoSignal {
    const NAME: &'static str = NAME;

    fn open(&self, _worker: WorkerId, needs: &Needs) -> io::Result<Ends> {
        let (ours, theirs) = UnixStream::pair()?;
        never_block(&ours)?;
        let theirs: OwnedFd = theirs.into();
        hand_down(&theirs)?;
        let stream = attach::descriptor(&theirs);
        let values = [needs.wake_up.name().to_owned(), needs.job_bytes.to_string(), stream];
        let attach = Attach::new(NAME, KEYS, values.map(OsString::from), vec![theirs]);
        let to_worker = File::from(OwnedFd::from(ours.try_clone()?));
        Ok(Ends { from_worker: File::from(OwnedFd::from(ours)), to_worker, attach })
    }

    fn signals(&self) -> Option<BorrowedFd<'_>> {
        None
    }

    fn take_signals(&mut self, _heard: impl FnMut(u32)) -> io::Result<()> {
        Ok(())
    }
}

pub fn attach(arguments: &[OsString]) -> Result<StreamWorker, TransportError> {
    let [wake_up, longest, stream] = attach::values(arguments, KEYS)?;
    let from_master = inherited(stream, libc::S_IFSOCK)?;
    let to_master = from_master.try_clone().map_err(|error| TransportError::Service {
        action: "use the inherited socket".to_owned(),
        reason: error.to_string(),
    })?;
    let longest = attach::number(longest)?;
    StreamWorker::new(from_master, to_master, None, longest, attach::wake_up(wake_up)?)
}
