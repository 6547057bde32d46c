//! Workers on several machines: ranks of one job, with shared memory inside each node.
//!
//! Rank 0 is the master. The ranks that share a machine's memory are a node, and the lowest of them
//! its leader: it starts as many worker processes as the node has ranks, reaches them over shared
//! memory, and passes on what the master and they say. It keeps one copy of what the node has been
//! sent of each tree, where all of its workers use it in place, and if it is to serve others what the
//! messages were, which it gives to leaders that ask for them. All other ranks wait for the end.
//! Workers are no ranks, so that their deaths are the business of their node and of the client
//! manager, as on one machine; a rank that is lost ends the job.

mod command;
mod hybrid;
mod leader;
mod messages;
mod pause;
mod remote_worker;
mod stock;
mod waiting;

pub use command::{Command, NodeIs};
pub use hybrid::Hybrid;
pub use leader::serve;
pub use remote_worker::{NodeAttach, NodeWorker, OnNodes, RemoteWorker};
