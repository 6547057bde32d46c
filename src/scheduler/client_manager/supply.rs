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
use crate::tree::TreeView;
use crate::tree::roots::Cut;
use crate::tree::subtree::{Subtrees, compressed};
use crate::wire::InPlaceTree;

pub(super) enum Supply<'a> {
    InPlace { keys: [TreeKey; 2], start_from: StartFrom },
    Sent(Box<[SentTree<'a>; 2]>),
}

impl<'a> Supply<'a> {
    /// Where workers see the geometry, what they can find themselves is neither computed for them
    /// nor sent.
    pub(super) fn in_place(keys: [TreeKey; 2], start_from: Option<StartFrom>) -> Self {
        Self::InPlace { keys, start_from: start_from.unwrap_or(StartFrom::Top) }
    }

    /// With what compressing all subtrees took and saved.
    pub(super) fn sent(
        keys: [TreeKey; 2],
        start_from: Option<StartFrom>,
        trees: [TreeView<'a>; 2],
        compress: Compression,
    ) -> Result<(Self, TransferReport), EngineError> {
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
        Ok((Self::Sent(Box::new(trees)), report))
    }

    pub(super) fn start_from(&self) -> StartFrom {
        match self {
            Self::InPlace { start_from, .. } => *start_from,
            Self::Sent(_) => StartFrom::RootPairs,
        }
    }

    pub(super) fn is_in_place(&self) -> bool {
        matches!(self, Self::InPlace { .. })
    }

    /// Body of the message that adds a tree.
    pub(super) fn tree(&self, side: usize) -> Vec<u8> {
        match self {
            Self::InPlace { keys, .. } => {
                let TreeKey { mesh, cut, .. } = keys[side];
                InPlaceTree { mesh: mesh.0, cut }.to_bytes().to_vec()
            }
            Self::Sent(trees) => trees[side].outline(),
        }
    }

    /// Body of the message that adds a subtree.
    pub(super) fn subtree(&self, side: usize, root: u32) -> Cow<'_, [u8]> {
        match self {
            Self::InPlace { .. } => unreachable!("subtrees without bytes are not asked for"),
            Self::Sent(trees) => trees[side].message(root),
        }
    }

    /// Of a subtree, as it is sent.
    pub(super) fn length(&self, side: usize, root: u32) -> u64 {
        match self {
            Self::InPlace { .. } => 0,
            Self::Sent(trees) => trees[side].length(root),
        }
    }

    pub(super) fn subtree_bytes(&self) -> SubtreeBytes {
        match self {
            Self::InPlace { .. } => SubtreeBytes::default(),
            Self::Sent(trees) => [0, 1].map(|side: usize| {
                let tree = &trees[side];
                (0..tree.count()).map(|root| tree.length(root)).collect()
            }),
        }
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
