use super::descend::{Hierarchy, Step};
use super::gap::Gap;
use crate::tree::node::{Child, Node};

/// The nodes of a binary tree.
pub struct Binary<'a, N>(pub &'a [N]);

impl<N: Gap> Hierarchy for Binary<'_, N> {
    type Box = N;

    fn top(&self) -> Step {
        Step::Open { first: 0, step: 1, count: 1 }
    }

    fn boxed(&self, at: u32) -> N {
        self.0[at as usize]
    }

    fn below(&self, at: u32) -> Step {
        match Node::link(&self.0[at as usize]).child() {
            Child::Leaf { rank } => Step::Triangles { first: rank, count: 1 },
            Child::Inner { right } => Step::Open { first: at + 1, step: right - 1, count: 2 },
        }
    }
}
