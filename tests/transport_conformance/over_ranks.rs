//! Workers of another node, over ranks that are threads of this process. The master's own node has one
//! worker, which nobody starts: here slot 0 is the first of the other.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::path::Path;
use std::process::Child;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use bumper::scene::Slowdown;
use bumper::scheduler::launch::{Launch, Processes, Worker};
use bumper::scheduler::ranks::{Hybrid, NodeAttach, NodeIs, OnNodes};
use bumper::transport::{
    Attach, MasterEnd, Needs, SharedGeometry, Traffic, TransportError, WorkerId, descriptors,
};
use bumper::workers;

use crate::in_process::{self, Others};
use crate::roles::{FOREVER, Gate, Role};
use crate::transports::{Running, Transport};

pub struct OverRanks;

impl Transport for OverRanks {
    type Master = Remote;
    const AHEAD: Option<usize> = None;

    fn master(base: &Path, needs: &Needs) -> Result<Remote, TransportError> {
        let machines: Vec<_> = (0..=needs.workers).map(|rank| rank.min(1)).collect();
        let theatre = Theatre::default();
        let (command, others) = in_process::start(&machines, &theatre, base);
        let hybrid = Hybrid::create(base, command, NodeIs::Machine, needs)?;
        Ok(Remote { hybrid: Some(hybrid), others: Some(others), theatre })
    }

    fn start(role: Role, gate: &Gate, end: RemoteAttach) -> Running {
        *end.theatre.next.lock().unwrap() = Some((role, gate.clone()));
        let nobody = OnNodes { here: Processes { program: "/nobody/is/started/here".into() } };
        let ignored = workers::Role::Compute(Slowdown::NONE);
        nobody.launch(end.worker, end.attach, ignored).unwrap();
        let begin = Instant::now();
        loop {
            if let Some(child) = end.theatre.started.lock().unwrap().take() {
                return Running::Shared(child);
            }
            assert!(begin.elapsed() < FOREVER, "the leader started nobody");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// The master of workers that are all on the other node.
pub struct Remote {
    hybrid: Option<Hybrid>,
    others: Option<Others>,
    theatre: Theatre,
}

pub struct RemoteAttach {
    worker: WorkerId,
    attach: NodeAttach,
    theatre: Theatre,
}

fn there(worker: WorkerId) -> WorkerId {
    WorkerId { slot: worker.slot + 1, ..worker }
}

fn here(error: TransportError) -> TransportError {
    match error {
        TransportError::NotDelivered(worker) => {
            TransportError::NotDelivered(WorkerId { slot: worker.slot - 1, ..worker })
        }
        other => other,
    }
}

impl Remote {
    fn hybrid(&mut self) -> &mut Hybrid {
        self.hybrid.as_mut().expect("until it is dropped")
    }
}

impl Drop for Remote {
    fn drop(&mut self) {
        self.hybrid = None;
        self.others.take().expect("ended once").end();
    }
}

impl MasterEnd for Remote {
    type Attach = RemoteAttach;

    fn name(&self) -> &'static str {
        "ranks"
    }

    fn shared_geometry(&mut self) -> Option<&mut dyn SharedGeometry> {
        None
    }

    fn open(&mut self, worker: WorkerId) -> Result<RemoteAttach, TransportError> {
        let attach = self.hybrid().open(there(worker)).map_err(here)?;
        Ok(RemoteAttach { worker: there(worker), attach, theatre: self.theatre.clone() })
    }

    fn send(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError> {
        self.hybrid().send(there(worker), parts).map_err(here)
    }

    fn wait(&mut self, watched: &[BorrowedFd<'_>], limit: Duration) -> Result<(), TransportError> {
        self.hybrid().wait(watched, limit)
    }

    fn receive(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        self.hybrid().receive(there(worker), take)
    }

    fn close(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        self.hybrid().close(there(worker), take)
    }

    fn traffic(&self, worker: WorkerId) -> Traffic {
        self.hybrid.as_ref().expect("until it is dropped").traffic(there(worker))
    }
}

/// Where the leader's workers are copies of this test program, in the role that was asked for last.
#[derive(Clone, Default)]
struct Theatre {
    next: Arc<Mutex<Option<(Role, Gate)>>>,
    started: Arc<Mutex<Option<Arc<Mutex<Child>>>>>,
}

impl Launch<Attach> for Theatre {
    type Worker = Actor;

    fn launch(&self, _: WorkerId, attach: Attach, _: workers::Role) -> io::Result<Actor> {
        let (role, gate) = self.next.lock().unwrap().take().expect("a role for this worker");
        let child = Arc::new(Mutex::new(Running::child(role, &gate, attach)));
        *self.started.lock().unwrap() = Some(child.clone());
        Ok(Actor { child, silence: descriptors::event()? })
    }
}

/// Goes on when the leader lets it go, as nobody else's processes do.
struct Actor {
    child: Arc<Mutex<Child>>,
    /// The leader looks often enough.
    silence: File,
}

impl Worker for Actor {
    fn death_notice(&self) -> BorrowedFd<'_> {
        self.silence.as_fd()
    }

    fn ended(&mut self) -> io::Result<Option<String>> {
        Ok(self.child.lock().unwrap().try_wait()?.map(|status| status.to_string()))
    }

    fn kill(&mut self) {
        self.child.lock().unwrap().kill().unwrap();
    }

    fn last_words(&mut self) -> String {
        String::new()
    }

    fn scenario(&self) -> Option<u32> {
        None
    }
}
