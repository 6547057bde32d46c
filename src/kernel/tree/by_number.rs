//! A tree's triangles by their numbers in the mesh file.

use std::borrow::Cow;

use super::TreeView;
use crate::geometry::Triangle;

/// Where the triangles of a tree lie, by number; made when it is first asked for.
#[derive(Debug, Default)]
pub struct Ranks {
    tree: Option<u64>,
    ranks: Vec<u32>,
}

impl Ranks {
    /// Of this tree, made anew if it is another than before.
    pub fn of<'a>(&'a mut self, tree: &TreeView<'a>) -> ByNumber<'a> {
        if self.tree.replace(tree.hash()) != Some(tree.hash()) {
            self.ranks = ranks(tree);
        }
        ByNumber { tree: *tree, ranks: Cow::Borrowed(&self.ranks) }
    }
}

pub struct ByNumber<'a> {
    tree: TreeView<'a>,
    ranks: Cow<'a, [u32]>,
}

impl<'a> ByNumber<'a> {
    pub fn new(tree: TreeView<'a>) -> Self {
        Self { tree, ranks: Cow::Owned(ranks(&tree)) }
    }

    pub fn rank(&self, number: u32) -> u32 {
        self.ranks[number as usize]
    }

    pub fn triangle(&self, number: u32) -> Triangle {
        self.tree.corners(self.rank(number))
    }

    /// Its vertices as the tree numbers them.
    pub fn vertices(&self, number: u32) -> [u32; 3] {
        self.tree.triangles()[self.rank(number) as usize].vertices
    }
}

fn ranks(tree: &TreeView<'_>) -> Vec<u32> {
    let mut ranks = vec![0; tree.triangles().len()];
    for (rank, triangle) in (0..).zip(tree.triangles()) {
        ranks[triangle.id as usize] = rank;
    }
    ranks
}
