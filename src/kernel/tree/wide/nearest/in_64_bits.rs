//! A wide tree for poses that 32 bits are not made for.

use crate::tree::TreeView;
use crate::tree::nearest::{Hierarchy, Step};
use crate::tree::node::AabbNode;
use crate::tree::wide::in_64_bits::boxed;
use crate::tree::wide::leaf_pairs::Leaves;
use crate::tree::wide::node::{Below, Slot, WIDTH, WideNode};

/// Boxes by their slots.
pub struct Slots<'a> {
    nodes: &'a [WideNode],
    leaves: Leaves<'a>,
    triangles: u32,
}

impl<'a> Slots<'a> {
    pub fn of(tree: &TreeView<'a>) -> Self {
        Self {
            nodes: tree.wide_nodes(),
            leaves: Leaves::of(tree),
            triangles: tree.triangle_count(),
        }
    }

    fn lanes_of(&self, node: u32) -> Step {
        let count = self.nodes[node as usize].lanes() as u32;
        Step::Open { first: node * WIDTH as u32, step: 1, count }
    }
}

impl Hierarchy for Slots<'_> {
    type Box = AabbNode;

    fn top(&self) -> Step {
        self.lanes_of(0)
    }

    fn boxed(&self, at: Slot) -> AabbNode {
        boxed(self.nodes, at)
    }

    fn below(&self, at: Slot) -> Step {
        match self.nodes[at as usize / WIDTH].child[at as usize % WIDTH].below() {
            Below::Node(node) => self.lanes_of(node),
            Below::Leaf(leaf) => {
                let boxes = self.leaves.boxes;
                let first = boxes[leaf as usize].first;
                let end = boxes.get(leaf as usize + 1).map_or(self.triangles, |next| next.first);
                Step::Triangles { first, count: end - first }
            }
        }
    }
}
