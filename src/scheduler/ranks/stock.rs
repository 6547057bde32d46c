//! What the leader of a node keeps for all of its workers.

use std::collections::{BTreeMap, BTreeSet};
use std::io;

use crate::transport::shared_memory::{Growing, SharedMemory};
use crate::transport::{SharedGeometry, TransportError};
use crate::tree::subtree::{CommonTree, Region, SubtreeError};
use crate::wire::{Job, SubtreeRequest, WireError};

/// Trees, plans, and jobs that are too long for a queue, by their numbers.
#[derive(Debug, Default)]
pub struct Stock {
    items: BTreeMap<u32, Item>,
    /// Trees that were here.
    gone: BTreeSet<u32>,
    /// Others can ask for subtrees.
    serves: bool,
}

#[derive(Debug)]
enum Item {
    Tree(Box<Tree>),
    Published,
}

#[derive(Debug)]
struct Tree {
    common: CommonTree<Growing>,
    /// Of subtrees by their roots, as they came, if others can ask for them.
    messages: BTreeMap<u32, Box<[u8]>>,
}

/// What a node has of what another asks for.
#[derive(Debug, PartialEq)]
pub enum Found<'a> {
    Message(&'a [u8]),
    /// It was sent, or asked for, and has yet to come.
    NotYet,
    /// Its tree was removed.
    Gone,
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
    #[error("subtree {found} came where {asked} was asked for")]
    AnotherSubtree { found: u32, asked: u32 },
    #[error("another node asks for subtrees, and none are kept here")]
    NotServing,
    #[error("a message for a worker came to its node")]
    NotForNodes,
}

impl Region for Growing {
    fn write(&self, at: usize, bytes: &[u8]) -> io::Result<()> {
        Growing::write(self, at, bytes)
    }
}

impl Stock {
    /// Does what a message to the node asks for. When it is done, workers can be told of it. Returns
    /// the subtree that has come with it.
    pub fn take(
        &mut self,
        memory: &mut SharedMemory,
        message: &[u8],
    ) -> Result<Option<SubtreeRequest>, StockError> {
        match Job::parse(message)? {
            Job::AddSubtree { tree, body } => {
                let root = self.put(tree, body)?;
                return Ok(Some(SubtreeRequest { tree, root }));
            }
            Job::Serve => {
                self.serves = true;
                Ok(())
            }
            Job::AddTree { tree, body } => {
                let grow = |bytes| memory.grow(tree, bytes).map_err(io::Error::other);
                let common = CommonTree::new(body, grow);
                let common = common.map_err(|source| StockError::Subtree { tree, source })?;
                let added = Box::new(Tree { common, messages: BTreeMap::new() });
                self.add(tree, Item::Tree(added))
            }
            Job::Plan { number, body } => {
                memory.publish(number, body)?;
                self.add(number, Item::Published)
            }
            Job::RemoveTree { tree } => match self.items.remove(&tree) {
                Some(Item::Tree(_)) => {
                    self.gone.insert(tree);
                    Ok(())
                }
                Some(Item::Published) => Ok(memory.withdraw(tree)?),
                None => Err(StockError::Tree(tree)),
            },
            _ => Err(StockError::NotForNodes),
        }?;
        Ok(None)
    }

    /// Takes the subtree that another node was asked for.
    pub fn take_given(&mut self, asked: SubtreeRequest, message: &[u8]) -> Result<(), StockError> {
        match self.put(asked.tree, message)? {
            root if root == asked.root => Ok(()),
            found => Err(StockError::AnotherSubtree { found, asked: asked.root }),
        }
    }

    /// Of what was sent to this node, or will be: another node may be told of it earlier.
    pub fn find(&self, asked: SubtreeRequest) -> Result<Found<'_>, StockError> {
        if !self.serves {
            return Err(StockError::NotServing);
        }
        let found = match self.items.get(&asked.tree) {
            Some(Item::Tree(tree)) => tree.messages.get(&asked.root),
            _ if self.gone.contains(&asked.tree) => return Ok(Found::Gone),
            _ => None,
        };
        Ok(found.map_or(Found::NotYet, |message| Found::Message(message)))
    }

    /// Puts a subtree to its place; its number.
    fn put(&mut self, number: u32, message: &[u8]) -> Result<u32, StockError> {
        let Some(Item::Tree(tree)) = self.items.get_mut(&number) else {
            return Err(StockError::Tree(number));
        };
        let added = tree.common.add(message);
        let root = added.map_err(|source| StockError::Subtree { tree: number, source })?;
        if self.serves {
            tree.messages.insert(root, message.into());
        }
        Ok(root)
    }

    fn add(&mut self, number: u32, item: Item) -> Result<(), StockError> {
        match self.items.insert(number, item) {
            None => Ok(()),
            Some(_) => Err(StockError::Tree(number)),
        }
    }
}
