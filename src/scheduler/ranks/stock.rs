//! What the leader of a node keeps for all of its workers.

use std::collections::BTreeMap;
use std::io;

use crate::transport::shared_memory::{Growing, SharedMemory};
use crate::transport::{SharedGeometry, TransportError};
use crate::tree::subtree::{CommonTree, Region, SubtreeError};
use crate::wire::{Job, WireError};

/// Trees, plans, and jobs that are too long for a queue, by their numbers.
#[derive(Debug, Default)]
pub struct Stock(BTreeMap<u32, Item>);

#[derive(Debug)]
enum Item {
    Tree(CommonTree<Growing>),
    Published,
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
                self.add(number, Item::Published)
            }
            Job::RemoveTree { tree } => match self.0.remove(&tree) {
                Some(Item::Tree(_)) => Ok(()),
                Some(Item::Published) => Ok(memory.withdraw(tree)?),
                None => Err(StockError::Tree(tree)),
            },
            _ => Err(StockError::NotForNodes),
        }
    }

    fn add(&mut self, number: u32, item: Item) -> Result<(), StockError> {
        match self.0.insert(number, item) {
            None => Ok(()),
            Some(_) => Err(StockError::Tree(number)),
        }
    }
}
