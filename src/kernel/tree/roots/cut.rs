//! A tree and the roots it is cut at.

use std::borrow::Cow;

use super::top::top_of;
use crate::tree::wide::Part;
use crate::tree::{TreeKind, TreeView};

/// Where a tree is cut. The roots are numbered from left to right, and every leaf is below one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cut {
    /// At this depth, and at leaves above it.
    Depth(u32),
    /// At the highest nodes with at most so many triangles, or at leaves: those of a wide tree have
    /// up to eight.
    Triangles(u32),
}

/// No tree that is built here is as deep. One from elsewhere is cut here, whatever is below.
const DEEPEST: u32 = 96;

impl Cut {
    /// Whether a node is a root if none above it is.
    pub(in crate::tree) fn is_at(self, depth: u32, triangles: u32) -> bool {
        depth >= DEEPEST
            || match self {
                Self::Depth(d) => depth >= d,
                Self::Triangles(most) => triangles <= most,
            }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DistributedRoot {
    /// Index of the node in the image; its subtree is the `2 * triangles - 1` nodes from there. Of
    /// a wide tree the first lane, eight times the node and the lane in it.
    pub node: u32,
    /// Lanes of a wide tree's node; of the other kinds 1.
    pub lanes: u32,
    /// Rank of the first triangle below it.
    pub first: u32,
    /// Triangles below it, which follow each other.
    pub triangles: u32,
}

impl DistributedRoot {
    /// Of the triangles below it.
    pub fn ranks(&self) -> std::ops::Range<u32> {
        self.first..self.first + self.triangles
    }
}

pub fn distributed_roots(tree: &TreeView<'_>, cut: Cut) -> Vec<DistributedRoot> {
    top_of(tree, cut).roots
}

/// Numbers of a root of the fixed tree and of a root of the moving tree.
pub type RootPair = [u32; 2];

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RootError {
    #[error("there is no distributed root {root}: the tree is cut into {roots}")]
    Unknown { root: u32, roots: usize },
    #[error("the subtree below distributed root {root} is not here: it has to be sent first")]
    NotHeld { root: u32 },
}

/// A tree with its distributed roots, from which a descent can start.
#[derive(Clone, Debug)]
pub struct CutTree<'a> {
    tree: TreeView<'a>,
    roots: Cow<'a, [DistributedRoot]>,
    /// Whether the subtree below each is here; if absent, all are.
    held: Option<&'a [bool]>,
}

impl<'a> CutTree<'a> {
    pub fn new(tree: TreeView<'a>, cut: Cut) -> Self {
        Self::from_roots(tree, distributed_roots(&tree, cut))
    }

    pub(super) fn from_roots(tree: TreeView<'a>, roots: Vec<DistributedRoot>) -> Self {
        Self { tree, roots: roots.into(), held: None }
    }

    /// `roots` are those of the tree.
    pub(in crate::tree) fn of_roots(tree: TreeView<'a>, roots: &'a [DistributedRoot]) -> Self {
        Self { tree, roots: roots.into(), held: None }
    }

    /// Of a tree that is here in part.
    pub(in crate::tree) fn partial(
        tree: TreeView<'a>,
        roots: &'a [DistributedRoot],
        held: &'a [bool],
    ) -> Self {
        Self { tree, roots: roots.into(), held: Some(held) }
    }

    pub fn roots(&self) -> &[DistributedRoot] {
        &self.roots
    }

    pub(super) fn into_roots(self) -> Vec<DistributedRoot> {
        self.roots.into_owned()
    }

    pub(in crate::tree) fn tree(&self) -> &TreeView<'a> {
        &self.tree
    }

    /// The lanes of the root with this number, if a descent can start there.
    pub(in crate::tree) fn part(&self, number: u32) -> Result<Part, RootError> {
        let unknown = || RootError::Unknown { root: number, roots: self.roots.len() };
        let root = self.roots.get(number as usize).ok_or_else(unknown)?;
        if self.held.is_some_and(|held| !held[number as usize]) {
            return Err(RootError::NotHeld { root: number });
        }
        Ok(match self.tree.kind() {
            TreeKind::Wide => Part::new(root.node, root.lanes),
            TreeKind::Obb | TreeKind::Aabb => Part { node: root.node, ..Part::FIRST },
        })
    }
}
