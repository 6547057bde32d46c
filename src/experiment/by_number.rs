//! A tree's triangles by their numbers in the mesh file.

use crate::geometry::Triangle;
use crate::tree::TreeView;

pub struct ByNumber<'a> {
    tree: TreeView<'a>,
    ranks: Vec<u32>,
}

impl<'a> ByNumber<'a> {
    pub fn new(tree: TreeView<'a>) -> Self {
        let mut ranks = vec![0; tree.triangles().len()];
        for (rank, triangle) in (0..).zip(tree.triangles()) {
            ranks[triangle.id as usize] = rank;
        }
        Self { tree, ranks }
    }

    pub fn rank(&self, number: u32) -> u32 {
        self.ranks[number as usize]
    }

    pub fn triangle(&self, number: u32) -> Triangle {
        self.tree.corners(self.rank(number))
    }
}
