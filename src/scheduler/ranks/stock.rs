//! What the leader of a node keeps for all of its workers.

use std::collections::{BTreeMap, VecDeque};
use std::io;

use crate::scheduler::local_client::OUTSTANDING_TASKS;
use crate::transport::shared_memory::{Growing, SharedMemory};
use crate::transport::{SharedGeometry, TransportError, WorkerId};
use crate::tree::subtree::{CommonTree, Region, SubtreeError};
use crate::wire::{Job, JobHeader, WireError, published_at};

/// Jobs that are too long for a worker's queue, by who they are for: with very many pairs of roots.
/// Numbered downwards, away from plans.
#[derive(Debug, Default)]
pub struct LongJobs {
    of: BTreeMap<WorkerId, VecDeque<u32>>,
    count: u32,
}

impl LongJobs {
    /// Publishes it; the message that says where it is.
    pub fn publish(
        &mut self,
        memory: &mut SharedMemory,
        worker: WorkerId,
        job: &[u8],
    ) -> Result<Vec<u8>, TransportError> {
        let number = u32::MAX - self.count;
        self.count += 1;
        memory.publish(number, job)?;
        let published = self.of.entry(worker).or_default();
        published.push_back(number);
        // No worker has more tasks: it has answered those before.
        if published.len() > OUTSTANDING_TASKS {
            memory.withdraw(published.pop_front().expect("there are some"))?;
        }
        Ok([bytemuck::bytes_of(&JobHeader::elsewhere()), &published_at(number)].concat())
    }

    /// Of a worker that has gone.
    pub fn withdraw(
        &mut self,
        memory: &mut SharedMemory,
        worker: WorkerId,
    ) -> Result<(), TransportError> {
        let published = self.of.remove(&worker).unwrap_or_default();
        published.into_iter().try_for_each(|number| memory.withdraw(number))
    }
}

/// Trees and plans, by their numbers.
#[derive(Debug, Default)]
pub struct Stock(BTreeMap<u32, Item>);

#[derive(Debug)]
enum Item {
    Tree(CommonTree<Growing>),
    Plan,
}

#[derive(Debug, thiserror::Error)]
pub enum StockError {
    #[error(transparent)]
    Wire(#[from] WireError),
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("tree {tree}: {source}")]
    Subtree { tree: u32, source: SubtreeError },
    #[error("tree {0} is not here, or was added before")]
    Tree(u32),
    #[error("a message for a worker came to its node")]
    NotForNodes,
}

impl Region for Growing {
    fn write(&self, at: usize, bytes: &[u8]) -> io::Result<()> {
        Growing::write(self, at, bytes)
    }
}

impl Stock {
    /// Does what a message to the node asks for. When it is done, workers can be told of it.
    pub fn take(&mut self, memory: &mut SharedMemory, message: &[u8]) -> Result<(), StockError> {
        match Job::parse(message)? {
            Job::AddTree { tree, body } => {
                let grow = |bytes| memory.grow(tree, bytes).map_err(io::Error::other);
                let common = CommonTree::new(body, grow);
                let common = common.map_err(|source| StockError::Subtree { tree, source })?;
                self.add(tree, Item::Tree(common))
            }
            Job::AddSubtree { tree, body } => match self.0.get_mut(&tree) {
                Some(Item::Tree(common)) => {
                    let added = common.add(body).map(drop);
                    added.map_err(|source| StockError::Subtree { tree, source })
                }
                _ => Err(StockError::Tree(tree)),
            },
            Job::Plan { number, body } => {
                memory.publish(number, body)?;
                self.add(number, Item::Plan)
            }
            Job::RemoveTree { tree } => match self.0.remove(&tree) {
                Some(Item::Tree(_)) => Ok(()),
                Some(Item::Plan) => Ok(memory.withdraw(tree)?),
                None => Err(StockError::Tree(tree)),
            },
            Job::Scenarios(_) | Job::Elsewhere { .. } | Job::Terminate => Err(StockError::NotForNodes),
        }
    }

    fn add(&mut self, number: u32, item: Item) -> Result<(), StockError> {
        match self.0.insert(number, item) {
            None => Ok(()),
            Some(_) => Err(StockError::Tree(number)),
        }
    }
}
