//! Workers of this node and of others, started and watched alike.

use std::cell::RefCell;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::rc::Rc;

use super::command::{Command, End};
use super::messages::Header;
use crate::scheduler::launch::{Launch, Processes, Worker};
use crate::scheduler::worker_process::WorkerProcess;
use crate::transport::ranks::Rank;
use crate::transport::{Attach, WorkerId};
use crate::workers::Role;

/// Starts workers on the node that their end was made for.
#[derive(Clone, Debug)]
pub struct OnNodes {
    pub here: Processes,
}

/// What a worker is made from.
#[derive(Debug)]
pub enum NodeAttach {
    Here(Attach),
    There(RemoteWorker),
}

/// A worker of this node, or the leader's word for one of another.
#[derive(Debug)]
pub enum NodeWorker {
    Here(WorkerProcess),
    There(RemoteWorker),
}

/// Ended when its channels are closed, if it has not by then.
#[derive(Debug)]
pub struct RemoteWorker {
    pub(super) id: WorkerId,
    pub(super) leader: Rank,
    pub(super) command: Rc<RefCell<Command>>,
    pub(super) end: Rc<End>,
}

impl Launch<NodeAttach> for OnNodes {
    type Worker = NodeWorker;

    fn launch(&self, id: WorkerId, attach: NodeAttach, role: Role) -> io::Result<NodeWorker> {
        match attach {
            NodeAttach::Here(attach) => self.here.launch(id, attach, role).map(NodeWorker::Here),
            NodeAttach::There(worker) => {
                let role = role.to_string();
                worker.tell(&Header::start(id), role.as_bytes()).map(|()| NodeWorker::There(worker))
            }
        }
    }
}

impl RemoteWorker {
    fn tell(&self, header: &Header, body: &[u8]) -> io::Result<()> {
        let mut command = self.command.borrow_mut();
        command.send(self.leader, &[header.bytes(), body]).map_err(io::Error::other)
    }
}

impl Worker for RemoteWorker {
    fn death_notice(&self) -> BorrowedFd<'_> {
        self.end.notice.as_fd()
    }

    fn ended(&mut self) -> io::Result<Option<String>> {
        Ok(self.end.obituary.get().map(|obituary| obituary.how.clone()))
    }

    fn kill(&mut self) {
        // If its leader cannot be told, its whole node has gone.
        let _ = self.tell(&Header::kill(self.id), &[]);
    }

    fn last_words(&mut self) -> String {
        let obituary = self.end.obituary.get();
        obituary.map(|obituary| obituary.last_words.clone()).unwrap_or_default()
    }

    fn scenario(&self) -> Option<u32> {
        self.end.obituary.get().and_then(|obituary| obituary.scenario)
    }
}

impl NodeWorker {
    fn worker(&mut self) -> &mut dyn Worker {
        match self {
            Self::Here(worker) => worker,
            Self::There(worker) => worker,
        }
    }
}

impl Worker for NodeWorker {
    fn death_notice(&self) -> BorrowedFd<'_> {
        match self {
            Self::Here(worker) => worker.death_notice(),
            Self::There(worker) => worker.death_notice(),
        }
    }

    fn ended(&mut self) -> io::Result<Option<String>> {
        self.worker().ended()
    }

    fn kill(&mut self) {
        self.worker().kill();
    }

    fn last_words(&mut self) -> String {
        self.worker().last_words()
    }

    fn scenario(&self) -> Option<u32> {
        match self {
            Self::Here(worker) => worker.scenario(),
            Self::There(worker) => worker.scenario(),
        }
    }
}
