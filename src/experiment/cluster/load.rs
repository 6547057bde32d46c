//! What is simulated to be computed and sent.

use super::events::Time;
use crate::scheduler::local_client::{Indicators, SubtreeBytes};

/// Costs of scenarios and of geometry on a core of speed 1. Scenarios beyond those that were recorded
/// are these again, from the first.
#[derive(Clone, Debug)]
pub struct Load {
    /// Of each recorded scenario.
    pub scenarios: Vec<ScenarioCost>,
    /// Subtrees of the fixed and of the moving tree.
    pub subtrees: [Vec<SubtreeCost>; 2],
    /// Bytes that tell a worker of each tree, before any of its subtrees.
    pub outline_bytes: [f64; 2],
    /// Of both trees in one piece.
    pub tree_bytes: f64,
    /// Of compressing all subtrees, before anything is sent; on one core.
    pub packing: Time,
}

#[derive(Clone, Debug, Default)]
pub struct ScenarioCost {
    /// On one core, from the top of both trees.
    pub serial: Time,
    /// Of a worker that is told the pairs of subtrees.
    pub below: Time,
    /// Of the master that finds them.
    pub analysis: Time,
    pub indicators: Indicators,
    /// Distributed roots in them.
    pub roots: u32,
    pub root_pairs: u32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SubtreeCost {
    /// In the memory of who has it.
    pub memory_bytes: f64,
    /// As it is sent.
    pub sent_bytes: f64,
    /// Of a compressed message, which the master has ready.
    pub kept_bytes: f64,
    /// Of the master that makes its message.
    pub make: Time,
    /// Of the worker that puts it to its place.
    pub place: Time,
}

impl Load {
    pub fn scenario(&self, scenario: u32) -> &ScenarioCost {
        &self.scenarios[scenario as usize % self.scenarios.len()]
    }

    /// Of the first so many, one after the other on a core of speed 1.
    pub fn serial(&self, scenarios: u32) -> Time {
        (0..scenarios).map(|scenario| self.scenario(scenario).serial).sum()
    }

    pub fn subtree_bytes(&self) -> SubtreeBytes {
        let bytes = |subtrees: &Vec<SubtreeCost>| {
            subtrees.iter().map(|subtree| subtree.sent_bytes.round() as u64).collect()
        };
        [bytes(&self.subtrees[0]), bytes(&self.subtrees[1])]
    }
}
