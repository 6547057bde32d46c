//! What is timed: kinds of trees, each with what it is descended with, and the peer.

use anyhow::Result;
use bumper::geometry::Pose;
use bumper::geometry::simd::SimdLevel;
use bumper::tree::descent::{Descent, Pair};
use bumper::tree::{Counts, TreeImage, TreeKind};

use crate::parry;

/// Both vehicles, ready to be queried.
pub enum Index {
    Peer(Box<parry::Peer>),
    /// The fixed tree, the moving one.
    Ours([TreeImage; 2]),
}

pub struct Contender {
    pub name: String,
    /// Position of its index among those of a pair of vehicles.
    pub index: usize,
    descent: Descent,
}

/// The peer first: it is what the others are compared with.
pub fn all() -> Vec<Contender> {
    let peer = Contender { name: "parry3d-f64".to_owned(), index: 0, descent: Descent::default() };
    let mut contenders = vec![peer];
    for (kind, index) in TreeKind::ALL.into_iter().zip(1..) {
        let levels = match kind {
            TreeKind::Wide => SimdLevel::available(),
            TreeKind::Obb | TreeKind::Aabb => vec![SimdLevel::Portable],
        };
        contenders.extend(levels.into_iter().map(|level| Contender {
            name: format!("{kind} {level}"),
            index,
            descent: Descent::with_simd(level),
        }));
    }
    contenders
}

impl Index {
    pub fn name(&self) -> String {
        match self {
            Self::Peer(_) => "parry3d-f64".to_owned(),
            Self::Ours([fixed, _]) => fixed.view().kind().to_string(),
        }
    }

    pub fn bytes(&self) -> Option<usize> {
        match self {
            Self::Peer(_) => None,
            Self::Ours(images) => {
                Some(images.iter().map(|image| size_of_val(image.blocks())).sum())
            }
        }
    }
}

impl Contender {
    /// Replaces `pairs`.
    pub fn all_pairs(&mut self, on: &Index, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<()> {
        pairs.clear();
        match on {
            Index::Peer(peer) => peer.all_pairs(pose, pairs),
            Index::Ours([a, b]) => self.descent.all_pairs(&a.view(), &b.view(), pose, pairs)?,
        }
        Ok(())
    }

    pub fn any_pair(&mut self, on: &Index, pose: &Pose) -> Result<bool> {
        Ok(match on {
            Index::Peer(peer) => peer.any_pair(pose),
            Index::Ours([a, b]) => self.descent.any_pair(&a.view(), &b.view(), pose)?,
        })
    }

    /// The peer does not count.
    pub fn count(&mut self, on: &Index, pose: &Pose, pairs: &mut Vec<Pair>) -> Result<Counts> {
        pairs.clear();
        match on {
            Index::Peer(_) => Ok(Counts::default()),
            Index::Ours([a, b]) => {
                Ok(self.descent.counted_pairs(&a.view(), &b.view(), pose, pairs)?)
            }
        }
    }
}
