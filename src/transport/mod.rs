//! Moves bytes between the master and its workers. What the bytes mean is nobody's business here.
//!
//! # Contract
//!
//! Every transport keeps these promises; `tests/transport_conformance` holds each of them against
//! its number. Workers are processes, except those of [`threads`]. Promises 1 and 2 are of the
//! transports with [`SharedGeometry`], [`shared_memory`] and [`threads`]; the others send geometry
//! as messages.
//!
//! 1. An image that the master [published](SharedGeometry::publish), before or after the worker
//!    attached, is what [`GeometryInPlace::geometry`] returns, byte for byte, on a multiple of 64
//!    bytes. A number is published once in a run.
//! 2. A geometry handle stays valid and unchanged as long as the worker keeps it, also when the
//!    mesh was [withdrawn](SharedGeometry::withdraw) or the master is gone. The memory of a
//!    withdrawn mesh is given back when no worker has a handle.
//! 3. Messages to one worker arrive at that worker alone, each once, whole and in order; so do
//!    messages from a worker. Their first byte lies on a multiple of 8 bytes. What is
//!    [sent ahead](MasterEnd::send_ahead) may wait for what follows, up to the next
//!    [`MasterEnd::wait`].
//! 4. The master may send once the worker's first message has arrived, and never waits for a
//!    worker. In [`shared_memory`] up to [`QUEUED_JOBS`] messages can be ahead of the worker, and
//!    one more is an error; elsewhere any number, which wait in the master's memory.
//! 5. A message longer than its limit ([`Needs::job_bytes`], [`REPLY_BYTES`]) is refused when
//!    sent; in a stream, a length beyond the limit is refused when it comes.
//! 6. [`WorkerEnd::receive`] looks for a message as its [`WakeUp`] says, then sleeps until there is
//!    one; [`MasterEnd::wait`] until a worker has sent one, a watched descriptor can be read, or
//!    the time is over. A message that came before the call counts. Only
//!    [`WakeUp::BusyPoll`] never sleeps.
//! 7. What a worker sent before it was killed is handed over, by [`MasterEnd::close`] at the
//!    latest. (A thread cannot be killed; what it sent before it ended counts.)
//! 8. In [`shared_memory`], room is made sure of first: too little is an error, of the creation of
//!    the master's end for all channels and of [`SharedGeometry::publish`] for an image, that says
//!    how much is needed and how much there is, never a signal later. Elsewhere messages and images
//!    are memory like any other, and nothing is set aside.
//! 9. Two runs never see each other. When the master's end is dropped, nothing of it is left in
//!    shared memory or in the file system, whatever state its workers were in; closing a dead
//!    worker's channels gives back what they took. What a killed master left is removed by the
//!    next one of the same user; living runs are never touched. (Only [`shared_memory`] has files.)
//! 10. Bytes are counted where they are copied: by [`SharedGeometry::publish`], and in [`Traffic`].
//! 11. A worker notices that the master, or its own channel, has gone: whatever it waits for is
//!     [`TransportError::MasterGone`]. A dead worker is at most [`TransportError::NotDelivered`] to
//!     the master, never a signal or a wait.

use std::ops::Deref;
use std::os::fd::BorrowedFd;
use std::path::PathBuf;
use std::time::Duration;

mod attach;
pub mod descriptors;
mod message;
#[cfg(feature = "mpi")]
pub mod mpi;
pub mod peer;
pub mod ranks;
pub mod shared_memory;
pub mod stream;
pub mod threads;
mod wake_up;

pub use attach::{Attach, Attached, attach};
pub use message::Message;
pub use wake_up::{SPIN, WakeUp};

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

impl WorkerId {
    const FIRST: Self = Self { slot: 0, incarnation: 0 };
    const LAST: Self = Self { slot: u32::MAX, incarnation: u32::MAX };
}

impl std::fmt::Display for WorkerId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}.{}", self.slot, self.incarnation)
    }
}

/// What a run will need at most.
#[derive(Clone, Debug)]
pub struct Needs {
    /// At the same time.
    pub workers: u32,
    /// Longest message to a worker.
    pub job_bytes: usize,
    /// Of the master and of every worker.
    pub wake_up: WakeUp,
}

/// Bytes of messages that went to and from one worker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    pub to_worker: u64,
    pub from_worker: u64,
}

/// The master's end. See the [contract](self#contract).
pub trait MasterEnd {
    /// What a worker's end is made from: [`Attach`], or where workers are threads, the end itself.
    type Attach;

    fn name(&self) -> &'static str;

    /// `None` where there is no memory in common: geometry has to be sent.
    fn shared_geometry(&mut self) -> Option<&mut dyn SharedGeometry>;

    /// `None` where all workers see what is in [`shared_geometry`](Self::shared_geometry), or none.
    fn other_nodes(&mut self) -> Option<&mut dyn OtherNodes> {
        None
    }

    /// Makes the channels of a worker.
    fn open(&mut self, worker: WorkerId) -> Result<Self::Attach, TransportError>;

    /// Sends the parts as one message.
    fn send(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError>;

    /// As [`send`](Self::send), of a message that others to the worker follow at once: it may wait for
    /// these, so as to go with them, but not beyond the next [`wait`](Self::wait).
    fn send_ahead(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError> {
        self.send(worker, parts)
    }

    fn wait(&mut self, watched: &[BorrowedFd<'_>], limit: Duration) -> Result<(), TransportError>;

    /// Hands every message from `worker` that the last [`wait`](Self::wait) knew of to `take`, and
    /// maybe later ones, without waiting.
    fn receive(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError>;

    /// Hands what has come from `worker` and was not received to `take`, then gives up its
    /// channels. They are given up also when this is an error.
    fn close(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError>;

    /// Of a worker that was opened, closed or not.
    fn traffic(&self, worker: WorkerId) -> Traffic;
}

/// Geometry that every worker can read where the master put it.
pub trait SharedGeometry {
    /// Copies `image` once, to where every worker can read it. Returns the bytes copied. A number
    /// is published once in a run.
    fn publish(&mut self, mesh: u32, image: &[u8]) -> Result<u64, TransportError>;

    /// Nobody gets `mesh` any more. Its memory is given back when no worker has it.
    fn withdraw(&mut self, mesh: u32) -> Result<(), TransportError>;
}

/// Workers of other machines, who do not see what is published here. Those of one node have memory in
/// common, into which its leader puts what is sent to the node.
pub trait OtherNodes {
    /// Of a worker's slot; 0 is this machine.
    fn node_of(&self, slot: u32) -> usize;

    /// Sends the parts as one message to a node's leader. What is sent afterwards to workers of the
    /// node reaches them when the leader has dealt with it.
    fn send_to_node(&mut self, node: usize, parts: &[&[u8]]) -> Result<(), TransportError>;

    /// Has a node's leader send the `request` to the leader of another, who answers it from what was
    /// sent to that node. What is sent afterwards to workers of the node reaches them when the answer
    /// has come.
    fn send_to_fetch(
        &mut self,
        node: usize,
        from: usize,
        request: &[u8],
    ) -> Result<(), TransportError>;

    /// The name of its machine.
    fn host(&self, node: usize) -> String;

    /// All that went from the master to its leader and came back, and thereby to its workers. What
    /// leaders have from each other is not here.
    fn traffic_of_node(&self, node: usize) -> Traffic;
}

/// A worker's end. See the [contract](self#contract).
pub trait WorkerEnd {
    type Message: Deref<Target = [u8]>;

    /// The next message. [`TransportError::MasterGone`] when there will be none.
    fn receive(&mut self) -> Result<Self::Message, TransportError>;

    /// Sends the parts as one message; waits while there is no room for it.
    fn send(&mut self, parts: &[&[u8]]) -> Result<(), TransportError>;
}

/// A worker's end that has the geometry that the master [published](SharedGeometry::publish).
pub trait GeometryInPlace: WorkerEnd {
    type Geometry: Deref<Target = [u8]>;

    /// Waits until the mesh is published.
    fn geometry(&mut self, mesh: u32) -> Result<Self::Geometry, TransportError>;
}

/// A worker's end that has geometry of which it sees more and more.
pub trait GrowingGeometry: GeometryInPlace {
    type Growing: Deref<Target = [u8]>;

    /// What was made before this worker was told of it.
    fn growing(&mut self, number: u32) -> Result<Self::Growing, TransportError>;
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
    #[error("a frame in a stream says that it is {bytes} bytes long: at most {limit} can be right")]
    Frame { bytes: u64, limit: usize },
    #[error("worker {0} does not take messages: its queue is full or it has gone")]
    NotDelivered(WorkerId),
    #[error("the master has gone")]
    MasterGone,
    #[error("mesh {0} was published before: a mesh gets a new number each time")]
    PublishedBefore(u32),
    #[error("the arguments do not describe a channel: {0}")]
    Arguments(String),
}
