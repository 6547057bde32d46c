//! How the geometry of a run gets to the workers: they see it where it was published, or are sent
//! what they lack of it.

use super::EngineError;
use super::engine::TreeKey;
use crate::scene::StartFrom;
use crate::scheduler::local_client::SubtreeBytes;
use crate::tree::TreeImage;
use crate::tree::subtree::Subtrees;
use crate::wire::InPlaceTree;

pub(super) enum Supply<'a> {
    InPlace { keys: [TreeKey; 2], start_from: StartFrom },
    Sent(Box<[Subtrees<'a>; 2]>),
    /// In place on this machine; elsewhere subtrees are sent, once to each node.
    Nodes { keys: [TreeKey; 2], trees: Box<[Subtrees<'a>; 2]> },
}

/// How a client comes to what it needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// It sees what is published.
    InPlace,
    /// It is sent everything itself.
    Sent,
    /// It sees what the leader of its node, another than this, was sent.
    ByNode(usize),
}

/// Where geometry is published: nowhere, where all workers see it, or where those of this node do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Published {
    Nowhere,
    ToAll,
    ToThisNode,
}

impl<'a> Supply<'a> {
    /// Where workers see the geometry, what they can find themselves is neither computed for them
    /// nor sent.
    pub(super) fn new(
        published: Published,
        start_from: Option<StartFrom>,
        keys: [TreeKey; 2],
        images: [&'a TreeImage; 2],
    ) -> Result<Self, EngineError> {
        let trees = || {
            let subtrees = |side: usize| Subtrees::new(images[side].view(), keys[side].cut);
            Box::new([subtrees(0), subtrees(1)])
        };
        match (published, start_from) {
            (Published::ToAll, start_from) => {
                Ok(Self::InPlace { keys, start_from: start_from.unwrap_or(StartFrom::Top) })
            }
            (_, Some(StartFrom::Top)) => Err(EngineError::TopNotShared),
            (Published::Nowhere, _) => Ok(Self::Sent(trees())),
            (Published::ToThisNode, _) => Ok(Self::Nodes { keys, trees: trees() }),
        }
    }

    pub(super) fn start_from(&self) -> StartFrom {
        match self {
            Self::InPlace { start_from, .. } => *start_from,
            Self::Sent(_) | Self::Nodes { .. } => StartFrom::RootPairs,
        }
    }

    /// Of a client of that node.
    pub(super) fn way(&self, node: usize) -> Way {
        match (self, node) {
            (Self::InPlace { .. }, _) | (Self::Nodes { .. }, 0) => Way::InPlace,
            (Self::Sent(_), _) => Way::Sent,
            (Self::Nodes { .. }, node) => Way::ByNode(node),
        }
    }

    /// Body of the message that adds a tree to who sees it where it was published.
    pub(super) fn place(&self, side: usize) -> Vec<u8> {
        match self {
            Self::InPlace { keys, .. } | Self::Nodes { keys, .. } => {
                let TreeKey { mesh, cut, .. } = keys[side];
                InPlaceTree { mesh: mesh.0, cut }.to_bytes().to_vec()
            }
            Self::Sent(_) => unreachable!("nothing is published"),
        }
    }

    /// What is sent, if anything is.
    pub(super) fn trees(&self) -> Option<&[Subtrees<'a>; 2]> {
        match self {
            Self::InPlace { .. } => None,
            Self::Sent(trees) | Self::Nodes { trees, .. } => Some(trees),
        }
    }

    /// Body of the message that adds a tree to who is sent it.
    pub(super) fn outline(&self, side: usize) -> Vec<u8> {
        self.sent(side).outline()
    }

    /// Body of the message that adds a subtree.
    pub(super) fn subtree(&self, side: usize, root: u32) -> Vec<u8> {
        self.sent(side).message(root).expect("a root of this tree")
    }

    fn sent(&self, side: usize) -> &Subtrees<'a> {
        &self.trees().expect("subtrees without bytes are not asked for")[side]
    }

    pub(super) fn subtree_bytes(&self) -> SubtreeBytes {
        let Some(trees) = self.trees() else { return SubtreeBytes::default() };
        [0, 1].map(|side: usize| {
            let tree = &trees[side];
            let length = |root| tree.message_length(root).expect("a root of this tree") as u64;
            (0..tree.count()).map(length).collect()
        })
    }
}
