//! How the geometry of a run gets to the workers: they see it where it was published, or are sent
//! what they lack of it.

use std::borrow::Cow;
use std::time::Instant;

use rayon::prelude::*;

use super::EngineError;
use super::engine::TreeKey;
use crate::scene::{Compression, StartFrom};
use crate::scheduler::engine_report::TransferReport;
use crate::scheduler::local_client::SubtreeBytes;
use crate::transport::MasterEnd;
use crate::tree::TreeView;
use crate::tree::roots::Cut;
use crate::tree::subtree::{Subtrees, compressed};
use crate::wire::InPlaceTree;

pub(super) enum Supply<'a> {
    InPlace {
        keys: [TreeKey; 2],
        start_from: StartFrom,
    },
    Sent(Box<[SentTree<'a>; 2]>),
    /// In place on this machine; elsewhere subtrees are sent, once to each node.
    Nodes {
        keys: [TreeKey; 2],
        trees: Box<[SentTree<'a>; 2]>,
    },
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

/// Where what is published is seen: nowhere, by workers everywhere, or by those in this node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Published {
    Nowhere,
    Everywhere,
    InThisNode,
}

impl Published {
    pub(super) fn of(transport: &mut impl MasterEnd) -> Self {
        match (transport.shared_geometry().is_some(), transport.other_nodes().is_some()) {
            (false, _) => Self::Nowhere,
            (true, false) => Self::Everywhere,
            (true, true) => Self::InThisNode,
        }
    }
}

impl<'a> Supply<'a> {
    /// Where workers see the geometry, what they can find themselves is neither computed for them
    /// nor sent. With what compressing all subtrees took and saved, if they are sent.
    pub(super) fn new(
        published: Published,
        keys: [TreeKey; 2],
        start_from: Option<StartFrom>,
        trees: [TreeView<'a>; 2],
        compress: Compression,
    ) -> Result<(Self, TransferReport), EngineError> {
        if published == Published::Everywhere {
            let start_from = start_from.unwrap_or(StartFrom::Top);
            return Ok((Self::InPlace { keys, start_from }, TransferReport::default()));
        }
        if start_from == Some(StartFrom::Top) {
            return Err(EngineError::TopNotShared);
        }
        let begin = Instant::now();
        let trees = [0, 1].map(|side: usize| SentTree::new(trees[side], keys[side].cut, compress));
        let compress_s = match compress {
            Compression::None => 0.0,
            Compression::Lz4 => begin.elapsed().as_secs_f64(),
        };
        let lengths = trees.each_ref().map(SentTree::lengths);
        let report = TransferReport {
            compress,
            compress_s,
            bytes_plain: lengths.iter().map(|(plain, _)| plain).sum(),
            bytes_packed: lengths.iter().map(|(_, packed)| packed).sum(),
            ..TransferReport::default()
        };
        let trees = Box::new(trees);
        let supply = match published {
            Published::InThisNode => Self::Nodes { keys, trees },
            _ => Self::Sent(trees),
        };
        Ok((supply, report))
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

    /// Body of the message that adds a tree to who is sent it.
    pub(super) fn outline(&self, side: usize) -> Vec<u8> {
        self.sent(side).outline()
    }

    /// Body of the message that adds a subtree.
    pub(super) fn subtree(&self, side: usize, root: u32) -> Cow<'_, [u8]> {
        self.sent(side).message(root)
    }

    /// Of a subtree, as it is sent.
    pub(super) fn length(&self, side: usize, root: u32) -> u64 {
        self.trees().map_or(0, |trees| trees[side].length(root))
    }

    pub(super) fn subtree_bytes(&self) -> SubtreeBytes {
        let Some(trees) = self.trees() else { return SubtreeBytes::default() };
        trees.each_ref().map(|tree| (0..tree.count()).map(|root| tree.length(root)).collect())
    }

    /// What is sent, if anything is.
    fn trees(&self) -> Option<&[SentTree<'a>; 2]> {
        match self {
            Self::InPlace { .. } => None,
            Self::Sent(trees) | Self::Nodes { trees, .. } => Some(trees),
        }
    }

    fn sent(&self, side: usize) -> &SentTree<'a> {
        &self.trees().expect("subtrees without bytes are not asked for")[side]
    }
}

/// A tree that is sent subtree by subtree.
pub(super) struct SentTree<'a> {
    subtrees: Subtrees<'a>,
    /// Of each root, if that is smaller than the subtree as it is. Empty: nothing is compressed.
    compressed: Vec<Option<Vec<u8>>>,
}

impl<'a> SentTree<'a> {
    /// Compresses on all cores.
    pub(super) fn new(tree: TreeView<'a>, cut: Cut, compress: Compression) -> Self {
        let subtrees = Subtrees::new(tree, cut);
        let message = |root| subtrees.message(root).expect("a root of this tree");
        let compressed = match compress {
            Compression::None => Vec::new(),
            Compression::Lz4 => (0..subtrees.count())
                .into_par_iter()
                .map(|root| compressed(&message(root)))
                .collect(),
        };
        Self { subtrees, compressed }
    }

    pub(super) fn outline(&self) -> Vec<u8> {
        self.subtrees.outline()
    }

    /// Of one of its roots, as are the following.
    pub(super) fn message(&self, root: u32) -> Cow<'_, [u8]> {
        match self.compressed_message(root) {
            Some(message) => Cow::Borrowed(message),
            None => Cow::Owned(self.subtrees.message(root).expect("a root of this tree")),
        }
    }

    fn compressed_message(&self, root: u32) -> Option<&[u8]> {
        self.compressed.get(root as usize)?.as_deref()
    }

    /// Of all subtrees: as they are, and as they are sent.
    fn lengths(&self) -> (u64, u64) {
        let roots = || 0..self.count();
        (roots().map(|r| self.plain_length(r)).sum(), roots().map(|r| self.length(r)).sum())
    }

    fn count(&self) -> u32 {
        self.subtrees.count()
    }

    fn plain_length(&self, root: u32) -> u64 {
        self.subtrees.message_length(root).expect("a root of this tree") as u64
    }

    /// Of what is sent.
    fn length(&self, root: u32) -> u64 {
        match self.compressed_message(root) {
            Some(message) => message.len() as u64,
            None => self.plain_length(root),
        }
    }
}
