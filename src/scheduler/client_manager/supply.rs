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
}

impl<'a> Supply<'a> {
    /// Where workers see the geometry, what they can find themselves is neither computed for them
    /// nor sent.
    pub(super) fn new(
        is_shared: bool,
        start_from: Option<StartFrom>,
        keys: [TreeKey; 2],
        images: [&'a TreeImage; 2],
    ) -> Result<Self, EngineError> {
        match (is_shared, start_from) {
            (true, start_from) => {
                Ok(Self::InPlace { keys, start_from: start_from.unwrap_or(StartFrom::Top) })
            }
            (false, None | Some(StartFrom::RootPairs)) => {
                let subtrees = |side: usize| Subtrees::new(images[side].view(), keys[side].cut);
                Ok(Self::Sent(Box::new([subtrees(0), subtrees(1)])))
            }
            (false, Some(StartFrom::Top)) => Err(EngineError::TopNotShared),
        }
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
    pub(super) fn subtree(&self, side: usize, root: u32) -> Vec<u8> {
        match self {
            Self::InPlace { .. } => unreachable!("subtrees without bytes are not asked for"),
            Self::Sent(trees) => trees[side].message(root).expect("a root of this tree"),
        }
    }

    pub(super) fn subtree_bytes(&self) -> SubtreeBytes {
        match self {
            Self::InPlace { .. } => SubtreeBytes::default(),
            Self::Sent(trees) => [0, 1].map(|side: usize| {
                let tree = &trees[side];
                let length = |root| tree.message_length(root).expect("a root of this tree") as u64;
                (0..tree.count()).map(length).collect()
            }),
        }
    }
}
