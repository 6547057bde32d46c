//! Shared memory inside the master's node, messages to the leaders of all others.

use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::os::fd::BorrowedFd;
use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use super::command::{Command, End, NodeIs};
use super::messages::Header;
use super::pause::Pause;
use super::remote_worker::{NodeAttach, RemoteWorker};
use crate::transport::shared_memory::SharedMemory;
use crate::transport::{
    MasterEnd, Needs, OtherNodes, SharedGeometry, Traffic, TransportError, WorkerId, descriptors,
};

/// The master's end.
#[derive(Debug)]
pub struct Hybrid {
    own: SharedMemory,
    command: Rc<RefCell<Command>>,
    /// Of each worker's slot.
    nodes: Vec<usize>,
    /// Of workers of other nodes.
    traffic: BTreeMap<WorkerId, Traffic>,
    job_bytes: usize,
}

impl Hybrid {
    /// Makes leaders, and a run below `base` for the master's own node. A worker for each rank: those
    /// of a node follow each other.
    pub fn create(
        base: &Path,
        mut command: Command,
        node: NodeIs,
        needs: &Needs,
    ) -> Result<Self, TransportError> {
        command.divide(node, needs.job_bytes)?;
        let of_node = |(number, workers): (usize, u32)| (0..workers).map(move |_| number);
        let workers = command.nodes().iter().map(|node| node.workers);
        let nodes: Vec<_> = workers.enumerate().flat_map(of_node).collect();
        let here = nodes.iter().filter(|&&node| node == 0).count();
        let needs = Needs { workers: here as u32, ..needs.clone() };
        descriptors::require(DESCRIPTORS + nodes.len() as u64)?;
        let own = SharedMemory::create(base, &needs)?;
        let command = Rc::new(RefCell::new(command));
        Ok(Self { own, command, nodes, traffic: BTreeMap::new(), job_bytes: needs.job_bytes })
    }

    /// Waits for the leader of its node to say that nothing comes from it any more.
    fn hear_the_last_of(&mut self, worker: WorkerId) -> Result<(), TransportError> {
        let mut command = self.command.borrow_mut();
        if command.has_ended(worker) {
            return Ok(());
        }
        let leader = command.leader_of(worker).expect("one that has not ended");
        command.send(leader, &[Header::close(worker).bytes()])?;
        let (begin, mut pause) = (Instant::now(), Pause::default());
        while !command.has_ended(worker) {
            if begin.elapsed() > PATIENCE {
                return Err(TransportError::NotDelivered(worker));
            }
            if command.listen()? == 0 {
                std::thread::sleep(pause.next(false));
            }
        }
        Ok(())
    }

    fn node(&self, worker: WorkerId) -> usize {
        self.nodes[worker.slot as usize]
    }
}

/// A leader answers within milliseconds, unless its machine is in trouble.
const PATIENCE: Duration = Duration::from_secs(10);

/// Open files beside a notice for each worker: the program's, those of ranks, a margin.
const DESCRIPTORS: u64 = 512;

impl MasterEnd for Hybrid {
    type Attach = NodeAttach;

    fn name(&self) -> &'static str {
        "mpi"
    }

    fn shared_geometry(&mut self) -> Option<&mut dyn SharedGeometry> {
        self.own.shared_geometry()
    }

    fn other_nodes(&mut self) -> Option<&mut dyn OtherNodes> {
        let has_others = self.command.borrow().nodes().len() > 1;
        has_others.then_some(self as &mut dyn OtherNodes)
    }

    fn open(&mut self, worker: WorkerId) -> Result<NodeAttach, TransportError> {
        let node = self.node(worker);
        if node == 0 {
            return self.own.open(worker).map(NodeAttach::Here);
        }
        let notice = descriptors::event().map_err(|error| TransportError::Service {
            action: format!("watch worker {worker}"),
            reason: error.to_string(),
        })?;
        let end = Rc::new(End { notice, obituary: OnceCell::new() });
        let leader = self.command.borrow().nodes()[node].leader;
        self.command.borrow_mut().expect(worker, leader, end.clone());
        self.traffic.insert(worker, Traffic::default());
        let command = self.command.clone();
        Ok(NodeAttach::There(RemoteWorker { id: worker, leader, command, end }))
    }

    fn send(&mut self, worker: WorkerId, parts: &[&[u8]]) -> Result<(), TransportError> {
        if self.node(worker) == 0 {
            return self.own.send(worker, parts);
        }
        let bytes: usize = parts.iter().map(|part| part.len()).sum();
        if bytes > self.job_bytes {
            return Err(TransportError::TooLong { bytes, limit: self.job_bytes });
        }
        let mut command = self.command.borrow_mut();
        let leader = command.leader_of(worker).expect("a channel that was opened");
        command.send(leader, &[&[Header::to_worker(worker).bytes()], parts].concat())?;
        self.traffic.entry(worker).or_default().to_worker += bytes as u64;
        Ok(())
    }

    fn wait(&mut self, watched: &[BorrowedFd<'_>], limit: Duration) -> Result<(), TransportError> {
        let deadline = descriptors::deadline(limit);
        let mut pause = Pause::default();
        loop {
            self.command.borrow_mut().listen()?;
            let has_heard = self.command.borrow().has_replies();
            let left = deadline.map(|end| end.saturating_duration_since(Instant::now()));
            let is_over = left.is_some_and(|left| left.is_zero());
            let next = pause.next(self.command.borrow().is_busy());
            let sleep = match has_heard || is_over {
                true => Duration::ZERO,
                false => left.map_or(next, |left| next.min(left)),
            };
            // Also where there is no time to sleep: it connects workers that have just begun.
            if self.own.has_woken(watched, sleep)? || has_heard || is_over {
                return Ok(());
            }
        }
    }

    fn receive(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        if self.node(worker) == 0 {
            return self.own.receive(worker, take);
        }
        for reply in self.command.borrow_mut().replies(worker) {
            self.traffic.entry(worker).or_default().from_worker += reply.len() as u64;
            take(&reply);
        }
        Ok(())
    }

    fn close(
        &mut self,
        worker: WorkerId,
        take: &mut dyn FnMut(&[u8]),
    ) -> Result<(), TransportError> {
        if self.node(worker) == 0 {
            return self.own.close(worker, take);
        }
        let closed = self.hear_the_last_of(worker);
        self.receive(worker, take)?;
        self.command.borrow_mut().forget(worker);
        closed
    }

    fn traffic(&self, worker: WorkerId) -> Traffic {
        match self.node(worker) {
            0 => self.own.traffic(worker),
            _ => self.traffic.get(&worker).copied().unwrap_or_default(),
        }
    }
}

impl OtherNodes for Hybrid {
    fn node_of(&self, slot: u32) -> usize {
        self.nodes[slot as usize]
    }

    fn send_to_node(&mut self, node: usize, parts: &[&[u8]]) -> Result<(), TransportError> {
        let mut command = self.command.borrow_mut();
        let leader = command.nodes()[node].leader;
        command.send(leader, &[&[Header::to_node().bytes()], parts].concat())
    }

    fn send_to_fetch(
        &mut self,
        node: usize,
        from: usize,
        request: &[u8],
    ) -> Result<(), TransportError> {
        let mut command = self.command.borrow_mut();
        let [to, from] = [node, from].map(|node| command.nodes()[node].leader);
        command.send(to, &[Header::fetch(from).bytes(), request])
    }

    fn host(&self, node: usize) -> String {
        self.command.borrow().nodes()[node].host.clone()
    }

    fn traffic_of_node(&self, node: usize) -> Traffic {
        match node {
            0 => Traffic::default(),
            node => self.command.borrow().traffic(node),
        }
    }
}
