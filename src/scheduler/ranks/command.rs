//! The master's side of all other ranks.

use std::cell::OnceCell;
use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::rc::Rc;

use super::messages::{FromNode, Header, Lead, Obituary};
use crate::transport::descriptors::ring;
use crate::transport::ranks::{Rank, Ranks};
use crate::transport::{Message, Traffic, TransportError, WorkerId};

/// Messages that are taken before anything else is looked at.
const AT_ONCE: usize = 256;

/// Rank 0's. All others end when this is dropped.
pub struct Command {
    ranks: Box<dyn Ranks>,
    /// The first is the master's own.
    nodes: Vec<Node>,
    workers: BTreeMap<WorkerId, Remote>,
}

/// Ranks that share memory.
#[derive(Clone, Debug)]
pub struct Node {
    pub leader: Rank,
    /// As many as it has ranks.
    pub workers: u32,
    /// Once its leader has said so.
    pub host: String,
}

/// A worker of another node.
struct Remote {
    leader: Rank,
    /// That nobody has taken yet.
    replies: VecDeque<Message>,
    end: Rc<End>,
}

/// How a worker ended, once it has.
#[derive(Debug)]
pub struct End {
    /// Readable from then on.
    pub notice: File,
    pub obituary: OnceCell<Obituary>,
}

/// Which ranks are a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NodeIs {
    /// All ranks of a machine: they have its memory in common.
    Machine,
    /// Each rank: as if it had a machine of its own.
    Rank,
}

impl Command {
    /// Takes command of all ranks that are not this one, which is rank 0.
    pub fn new(ranks: Box<dyn Ranks>) -> Self {
        Self { ranks, nodes: Vec::new(), workers: BTreeMap::new() }
    }

    /// Of all nodes together.
    pub fn ranks(&self) -> u32 {
        self.ranks.machines().len() as u32
    }

    pub fn nodes_of(&self, node: NodeIs) -> usize {
        self.workers_of_leaders(node).len()
    }

    fn workers_of_leaders(&self, node: NodeIs) -> BTreeMap<Rank, u32> {
        let mut workers = BTreeMap::new();
        for (rank, &machine) in (0..).zip(self.ranks.machines()) {
            let leader = if node == NodeIs::Machine { machine } else { rank };
            *workers.entry(leader).or_default() += 1;
        }
        workers
    }

    /// Makes leaders.
    pub(super) fn divide(&mut self, node: NodeIs, job_bytes: usize) -> Result<(), TransportError> {
        let workers = self.workers_of_leaders(node);
        let host = || crate::scheduler::ranks::leader::host();
        let of_leader = |(leader, workers): (Rank, u32)| {
            let host = if leader == 0 { host() } else { String::new() };
            Node { leader, workers, host }
        };
        self.nodes = workers.into_iter().map(of_leader).collect();
        for node in self.nodes.clone().iter().skip(1) {
            let lead = Lead { job_bytes: job_bytes as u64, workers: node.workers.into() };
            self.send(node.leader, &[Header::lead().bytes(), bytemuck::bytes_of(&lead)])?;
        }
        Ok(())
    }

    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    pub(super) fn send(&mut self, to: Rank, parts: &[&[u8]]) -> Result<(), TransportError> {
        self.ranks.send(to, parts)
    }

    pub(super) fn traffic(&self, node: usize) -> Traffic {
        self.ranks.traffic(self.nodes[node].leader)
    }

    pub(super) fn is_busy(&self) -> bool {
        self.ranks.is_busy()
    }

    pub(super) fn expect(&mut self, worker: WorkerId, leader: Rank, end: Rc<End>) {
        self.workers.insert(worker, Remote { leader, replies: VecDeque::new(), end });
    }

    pub(super) fn leader_of(&self, worker: WorkerId) -> Option<Rank> {
        self.workers.get(&worker).map(|remote| remote.leader)
    }

    pub(super) fn replies(&mut self, worker: WorkerId) -> VecDeque<Message> {
        let replies = self.workers.get_mut(&worker).map(|remote| &mut remote.replies);
        replies.map(std::mem::take).unwrap_or_default()
    }

    /// Also one that is not known.
    pub(super) fn has_ended(&self, worker: WorkerId) -> bool {
        let remote = self.workers.get(&worker);
        remote.is_none_or(|remote| remote.end.obituary.get().is_some())
    }

    pub(super) fn forget(&mut self, worker: WorkerId) {
        self.workers.remove(&worker);
    }

    /// Takes what has come from other ranks, but not without end; how many messages there were.
    pub(super) fn listen(&mut self) -> Result<usize, TransportError> {
        for heard in 0..AT_ONCE {
            let Some((rank, message)) = self.ranks.receive()? else { return Ok(heard) };
            self.hear(rank, &message)?;
        }
        Ok(AT_ONCE)
    }

    /// That nobody has taken.
    pub(super) fn has_replies(&self) -> bool {
        self.workers.values().any(|remote| !remote.replies.is_empty())
    }

    fn hear(&mut self, rank: Rank, message: &[u8]) -> Result<(), TransportError> {
        let failed = |host: &str, reason: String| TransportError::Service {
            action: format!("use the node of rank {rank} ({host})"),
            reason,
        };
        let node = self.nodes.iter_mut().find(|node| node.leader == rank);
        let node = node.ok_or_else(|| failed("not a leader", "it speaks".to_owned()))?;
        match FromNode::parse(message).map_err(|error| failed(&node.host, error.to_string()))? {
            FromNode::Host(host) => host.clone_into(&mut node.host),
            FromNode::Failed(reason) => return Err(failed(&node.host, reason.to_owned())),
            // Of those that are forgotten, nobody wants to know.
            FromNode::FromWorker { worker, reply } => {
                if let Some(remote) = self.workers.get_mut(&worker) {
                    remote.replies.push_back(Message::from(reply));
                }
            }
            FromNode::Died { worker, obituary } => {
                if let Some(remote) = self.workers.get(&worker) {
                    // Said once for each worker.
                    let _ = remote.end.obituary.set(obituary);
                    ring(&remote.end.notice);
                }
            }
        }
        Ok(())
    }
}

impl Drop for Command {
    fn drop(&mut self) {
        for rank in 1..self.ranks() {
            // Who cannot be told has gone.
            let _ = self.ranks.send(rank, &[Header::end().bytes()]);
        }
    }
}

impl std::fmt::Debug for Command {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Command").field("nodes", &self.nodes).finish_non_exhaustive()
    }
}
