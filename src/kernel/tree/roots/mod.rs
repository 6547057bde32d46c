//! Distributed roots: where a tree is cut into the subtrees that are sent (figure 2 of the paper),
//! and the pairs of them that a scenario needs (section 6.6).
//!
//! A wide tree is a binary tree with levels left out of its nodes; depth is counted in the levels
//! of that, and a root may be several lanes of one node.

mod box_tests;
mod boxes;
mod cut;
mod pre_analysis;
mod top;

pub use box_tests::box_tests;
pub use boxes::{NodeBox, boxes};
pub use cut::{Cut, CutTree, DistributedRoot, RootError, RootPair, distributed_roots};
pub use pre_analysis::{Detached, PreAnalysis};
pub(super) use top::Top;
