//! How a worker comes to life: as a process, or as a thread of this one.

use std::io;
use std::os::fd::BorrowedFd;
use std::path::PathBuf;

use super::worker_process::WorkerProcess;
use super::worker_thread::WorkerThread;
use crate::transport::threads::ThreadWorker;
use crate::transport::{Attach, WorkerId};
use crate::workers::Role;

/// A worker as the client manager holds it. A process is ended when this is dropped; a thread ends
/// when its channel is closed.
pub trait Worker {
    /// Readable once it has ended.
    fn death_notice(&self) -> BorrowedFd<'_>;

    /// How it ended, if it has.
    fn ended(&mut self) -> io::Result<Option<String>>;

    /// Its end is seen at its death notice, like any other.
    fn kill(&mut self);

    /// The end of what it said of itself, in one line.
    fn last_words(&mut self) -> String;

    /// The scenario it is at, or was when it died.
    fn scenario(&self) -> Option<u32>;
}

/// Starts workers from what a transport has made for them.
pub trait Launch<A> {
    type Worker: Worker;

    fn launch(&self, id: WorkerId, attach: A, role: Role) -> io::Result<Self::Worker>;
}

/// Starts `PROGRAM worker …`.
#[derive(Clone, Debug)]
pub struct Processes {
    pub program: PathBuf,
}

impl Launch<Attach> for Processes {
    type Worker = WorkerProcess;

    fn launch(&self, id: WorkerId, attach: Attach, role: Role) -> io::Result<WorkerProcess> {
        let process = WorkerProcess::start(&self.program, attach, role);
        let process = process.map_err(|source| {
            let program = self.program.display();
            io::Error::new(source.kind(), format!("cannot start a worker as {program}: {source}"))
        })?;
        tracing::debug!("worker {id} is process {}", process.pid());
        Ok(process)
    }
}

/// Starts a thread.
#[derive(Clone, Copy, Debug)]
pub struct InThreads;

impl Launch<ThreadWorker> for InThreads {
    type Worker = WorkerThread;

    fn launch(&self, id: WorkerId, end: ThreadWorker, role: Role) -> io::Result<WorkerThread> {
        WorkerThread::start(format!("worker {id}"), end, role)
    }
}
