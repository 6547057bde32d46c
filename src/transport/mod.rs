//! Moves bytes between the master and its workers. What the bytes mean is nobody's business here.
//!
//! # Contract
//!
//! Every transport keeps these promises; `tests/transport_conformance.rs` holds each of them
//! against its number.
//!
//! 1. An image that the master [published](MasterEnd::publish), before or after the worker
//!    attached, is what [`WorkerEnd::geometry`] returns, byte for byte, on a multiple of 64 bytes.
//! 2. A geometry handle stays valid and unchanged as long as the worker keeps it, also when the
//!    master is gone.
//! 3. Messages to one worker arrive at that worker alone, each once, whole and in order; so do
//!    messages from a worker. Their first byte lies on a multiple of 8 bytes.
//! 4. The master may send once the worker's first message has arrived, and then up to
//!    [`QUEUED_JOBS`] messages ahead of the worker. One more is an error; the master never waits
//!    for a worker.
//! 5. A message longer than its limit ([`Needs::job_bytes`], [`REPLY_BYTES`]) is refused when sent.
//! 6. [`WorkerEnd::receive`] sleeps until there is a message; [`MasterEnd::wait`] sleeps until a
//!    worker has sent one, a watched descriptor can be read, or the time is over. A message that
//!    came before the call counts. Neither polls.
//! 7. What a worker sent before it was killed can be received until its channel is closed.
//! 8. Room is made sure of first: too little is an error of [`MasterEnd`]'s creation that says how
//!    much is needed and how much there is, never a signal later.
//! 9. When the master's end is dropped, nothing of it is left in shared memory or in the file
//!    system, whatever state its workers were in. What a killed master left is removed by the
//!    next one of the same user; living runs are never touched.
//! 10. Bytes are counted where they are copied: by [`MasterEnd::publish`], and in [`Traffic`].

use std::ffi::OsString;
use std::ops::Deref;
use std::os::fd::BorrowedFd;
use std::path::PathBuf;
use std::time::Duration;

pub mod shared_memory;

/// Longest message from a worker.
pub const REPLY_BYTES: usize = 64 * 1024;
/// Messages that can lie in the queue to one worker.
pub const QUEUED_JOBS: usize = 4;

/// A worker's place and how often it was filled before. A new incarnation has new channels, so
/// that it never meets what was meant for the one that died.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct WorkerId {
    pub slot: u32,
    pub incarnation: u32,
}

impl std::fmt::Display for WorkerId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.slot, self.incarnation)
    }
}

/// What a run will need at most.
#[derive(Clone, Debug)]
pub struct Needs {
    /// Bytes of each image to be published: multiples of 64.
    pub images: Vec<usize>,
    pub workers: u32,
    /// Longest message to a worker.
    pub job_bytes: usize,
}

/// Bytes that went to and from one worker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Of images, copied for this worker alone: 0 where it maps what was published for all.
    pub geometry_copied: u64,
    pub messages: u64,
}

/// The master's end. See the [contract](self#contract).
pub trait MasterEnd {
    fn name(&self) -> &'static str;

    /// Copies `image` once, to where every worker can read it. Returns the bytes copied.
    fn publish(&mut self, mesh: u32, image: &[u8]) -> Result<u64, TransportError>;

    /// Makes the channels of a worker. The result is what its process passes to its end.
    fn open(&mut self, worker: WorkerId) -> Result<Vec<OsString>, TransportError>;

    /// Sends the parts as one message.
    fn send(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError>;

    fn wait(&mut self, watched: &[BorrowedFd<'_>], limit: Duration) -> Result<(), TransportError>;

    /// Hands every message that has come from `worker` to `take`, without waiting.
    fn receive(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError>;

    /// Gives up the channels of a worker, with all that is still in them.
    fn close(&mut self, worker: WorkerId);

    fn traffic(&self, worker: WorkerId) -> Traffic;
}

/// A worker's end. See the [contract](self#contract).
pub trait WorkerEnd {
    type Geometry: Deref<Target = [u8]>;
    type Message: Deref<Target = [u8]>;

    /// Waits until the mesh is published.
    fn geometry(&mut self, mesh: u32) -> Result<Self::Geometry, TransportError>;

    fn receive(&mut self) -> Result<Self::Message, TransportError>;

    /// Sends the parts as one message; waits while the queue to the master is full.
    fn send(&mut self, parts: &[&[u8]]) -> Result<(), TransportError>;
}

#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    #[error(
        "{directory} has {free} bytes free and this run needs {needed}: free some of it, use fewer \
         workers or smaller meshes, or make it larger (Docker: --shm-size={mebibytes}m)",
        directory = directory.display(), mebibytes = needed.div_ceil(1 << 20)
    )]
    NoRoom { directory: PathBuf, needed: u64, free: u64 },
    #[error("{path}: {reason}", path = path.display())]
    RunDirectory { path: PathBuf, reason: String },
    #[error("cannot {action}: {reason}")]
    Service { action: String, reason: String },
    #[error("a message of {bytes} bytes is too long: at most {limit}")]
    TooLong { bytes: usize, limit: usize },
    #[error("worker {0} does not take messages: its queue is full or it has gone")]
    NotDelivered(WorkerId),
    #[error("the master has gone")]
    MasterGone,
    #[error("the arguments do not describe a channel: {0}")]
    Arguments(String),
}
