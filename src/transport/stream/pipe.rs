//! The paper's communication (section 6.4.4): a pipe to each client, a pipe back, and one channel
//! common to all clients, on which each says that it has results. The master samples that one
//! without blocking, or sleeps on it, and then reads from those who have spoken.

use std::ffi::OsString;
use std::fs::File;
use std::io::{self, PipeReader, PipeWriter, Read};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

use super::master::{Ends, Link, Streams};
use super::worker::{Signal, StreamWorker};
use crate::transport::attach::{self, Attach};
use crate::transport::descriptors::{enlarge_pipe, hand_down, inherited, never_block};
use crate::transport::{Needs, TransportError, WorkerId};

pub const NAME: &str = "pipe";

/// The most that everybody may have, unless the administrator has changed it.
const PIPE_BYTES: i32 = 1 << 20;

const KEYS: [&str; 6] = ["--wake-up", "--longest", "--slot", "--jobs", "--replies", "--signal"];

/// The master's end.
pub type Pipes = Streams<CommonSignal>;

/// Common to all workers. The master keeps both ends, so that it never comes to an end.
#[derive(Debug)]
pub struct CommonSignal {
    reader: PipeReader,
    writer: PipeWriter,
}

impl Pipes {
    pub fn create(needs: &Needs) -> Result<Self, TransportError> {
        let signal = || {
            let (reader, writer) = io::pipe()?;
            never_block(&reader)?;
            never_block(&writer)?;
            Ok(CommonSignal { reader, writer })
        };
        let link = signal().map_err(|error: io::Error| TransportError::Service {
            action: "make the channel common to all workers".to_owned(),
            reason: error.to_string(),
        })?;
        Self::over(link, needs)
    }
}

impl Link for CommonSignal {
    const NAME: &'static str = NAME;

    fn open(&self, worker: WorkerId, needs: &Needs) -> io::Result<Ends> {
        let (jobs, to_worker) = io::pipe()?;
        let (from_worker, replies) = io::pipe()?;
        enlarge_pipe(&to_worker, PIPE_BYTES);
        enlarge_pipe(&from_worker, PIPE_BYTES);
        never_block(&to_worker)?;
        never_block(&from_worker)?;
        let inherited: [OwnedFd; 3] =
            [jobs.into(), replies.into(), self.writer.try_clone()?.into()];
        inherited.iter().try_for_each(hand_down)?;
        let [jobs, replies, signal] = inherited.each_ref().map(attach::descriptor);
        let values = [
            needs.wake_up.name().to_owned(),
            needs.job_bytes.to_string(),
            worker.slot.to_string(),
            jobs,
            replies,
            signal,
        ];
        let attach = Attach::new(NAME, KEYS, values.map(OsString::from), inherited.into());
        let file = |fd: OwnedFd| File::from(fd);
        Ok(Ends {
            from_worker: file(from_worker.into()),
            to_worker: file(to_worker.into()),
            attach,
        })
    }

    fn signals(&self) -> Option<BorrowedFd<'_>> {
        Some(self.reader.as_fd())
    }

    fn take_signals(&mut self, mut heard: impl FnMut(u32)) -> io::Result<()> {
        let mut signals = [0; 4096];
        loop {
            match self.reader.read(&mut signals) {
                Ok(count) => {
                    let (slots, _) = signals[..count].as_chunks();
                    slots.iter().for_each(|&slot| heard(u32::from_ne_bytes(slot)));
                    if count < signals.len() {
                        return Ok(());
                    }
                }
                Err(error) => match error.kind() {
                    io::ErrorKind::WouldBlock => return Ok(()),
                    io::ErrorKind::Interrupted => {}
                    _ => return Err(error),
                },
            }
        }
    }
}

pub fn attach(arguments: &[OsString]) -> Result<StreamWorker, TransportError> {
    let [wake_up, longest, slot, jobs, replies, signal] = attach::values(arguments, KEYS)?;
    let stream = |number| inherited(number, libc::S_IFIFO);
    let signal = Signal { slot: attach::number(slot)?, channel: stream(signal)?.into() };
    let wake_up = attach::wake_up(wake_up)?;
    let longest = attach::number(longest)?;
    StreamWorker::new(stream(jobs)?, stream(replies)?, Some(signal), longest, wake_up)
}
