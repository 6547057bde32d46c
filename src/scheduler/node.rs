//! Where geometry lies that clients were given: in the memory of one worker, or in memory that all
//! workers of a machine have in common.

use super::indicator::ClientIndicator;
use super::local_client::{Indicators, SubtreeBytes};

/// A memory, and what was put into it of the fixed and of the moving tree.
#[derive(Clone, Debug, Default)]
pub struct Node {
    given: [ClientIndicator; 2],
    /// Distributed roots that its next task brings, whichever of its clients gets it.
    added: [Vec<u32>; 2],
    /// Of their subtrees.
    added_bytes: u64,
}

impl Node {
    /// The sum of products of the scenario's and its own vectors, over both trees.
    pub fn score(&self, scenario: &Indicators) -> u64 {
        self.given.iter().zip(scenario).map(|(given, tree)| given.score(tree)).sum()
    }

    /// Whether it was given the subtree, or will be with the next task.
    pub fn has(&self, tree: usize, root: u32) -> bool {
        self.given[tree].has(root)
    }

    /// It will have what the scenario needs.
    pub fn give(&mut self, scenario: &Indicators, bytes: &SubtreeBytes) {
        for (tree, indicator) in scenario.iter().enumerate() {
            let (added, sum) = (&mut self.added[tree], &mut self.added_bytes);
            self.given[tree].give(indicator, |root| {
                if let Some(bytes) = bytes[tree].get(root as usize) {
                    added.push(root);
                    *sum += bytes;
                }
            });
        }
    }

    /// It is given one of the two trees in one piece before any scenario.
    pub fn give_whole(&mut self, tree: usize) {
        self.given[tree].give_whole();
    }

    /// It has both trees, cut into so many subtrees.
    pub fn give_all(&mut self, roots: [usize; 2]) {
        for (given, roots) in self.given.iter_mut().zip(roots) {
            given.give_all(roots);
        }
    }

    pub fn added_bytes(&self) -> u64 {
        self.added_bytes
    }

    /// What is to be sent ahead of a task, of the fixed and of the moving tree.
    pub fn take_added(&mut self) -> [Vec<u32>; 2] {
        self.added_bytes = 0;
        std::mem::take(&mut self.added)
    }

    /// The trees change: what was given of the old ones means nothing for the new ones.
    /// What was to be sent and was not has to be asked for again.
    pub fn exchange_given(&mut self, given: [ClientIndicator; 2]) -> [ClientIndicator; 2] {
        let added = self.take_added();
        for (given, added) in self.given.iter_mut().zip(added) {
            added.into_iter().for_each(|root| given.take_back(root));
        }
        std::mem::replace(&mut self.given, given)
    }
}

/// The nodes of a crew.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    /// Of each client.
    of: Vec<usize>,
    nodes: Vec<Node>,
    /// Whether a node's memory is a process that dies with its client.
    is_private: bool,
}

impl Nodes {
    /// Every client has a memory of its own, which ends with it.
    pub fn private(clients: usize) -> Self {
        Self { of: (0..clients).collect(), nodes: vec![Node::default(); clients], is_private: true }
    }

    /// Clients have memory in common, which outlives them: the number of the node of each client,
    /// from 0 without a gap.
    pub fn shared(of: Vec<usize>) -> Self {
        let count = of.iter().max().map_or(0, |last| last + 1);
        Self { of, nodes: vec![Node::default(); count], is_private: false }
    }

    /// Those of other machines than the master's, whose is the first.
    pub fn others(&self) -> std::ops::Range<usize> {
        1..self.count().max(1)
    }

    pub fn count(&self) -> usize {
        self.nodes.len()
    }

    /// The number of the client's node.
    pub fn of(&self, client: usize) -> usize {
        self.of[client]
    }

    pub fn all(&self) -> &[Node] {
        &self.nodes
    }

    pub fn all_mut(&mut self) -> &mut [Node] {
        &mut self.nodes
    }

    pub fn of_client(&self, client: usize) -> &Node {
        &self.nodes[self.of[client]]
    }

    pub fn of_client_mut(&mut self, client: usize) -> &mut Node {
        &mut self.nodes[self.of[client]]
    }

    /// The number of the node that is lost with the client, if nobody else has that memory.
    pub fn lost_with(&self, client: usize) -> Option<usize> {
        self.is_private.then_some(self.of[client])
    }

    pub fn client_died(&mut self, client: usize) {
        if let Some(node) = self.lost_with(client) {
            self.nodes[node] = Node::default();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::indicator::tests::row;
    use super::*;

    const BYTES: [&[u64]; 2] = [&[1, 20, 300, 4000, 50_000, 600_000], &[2, 10, 140, 60]];

    fn bytes() -> SubtreeBytes {
        BYTES.map(<[u64]>::to_vec)
    }

    #[test]
    fn a_subtree_is_added_once_with_the_first_scenario_that_needs_it_and_its_bytes_are_counted() {
        let mut node = Node::default();
        node.give(&[row(0, &[0, 0, 0, 0, 1, 4]), row(1, &[2, 0, 14, 0])], &bytes());
        assert_eq!(node.added_bytes(), 650_000 + 142);
        node.give(&[row(0, &[0, 11, 0, 0, 1, 0]), row(1, &[2, 0, 14, 6])], &bytes());
        assert_eq!(node.take_added(), [vec![4, 5, 1], vec![0, 2, 3]]);
        assert_eq!(node.added_bytes(), 0);
        node.give(&[row(0, &[1, 11, 0, 0, 0, 0]), row(1, &[2, 0, 0, 0])], &bytes());
        assert_eq!(node.take_added(), [vec![0], vec![]]);
    }

    #[test]
    fn what_was_not_sent_before_the_trees_change_was_not_given() {
        let (first, second) = ([0, 11, 0, 0, 0, 0], [0, 11, 0, 1, 0, 0]);
        let mut node = Node::default();
        node.give(&[row(0, &first), row(1, &[0, 0, 0, 0])], &bytes());
        node.take_added();
        node.give(&[row(0, &second), row(1, &[0, 0, 0, 6])], &bytes());
        let given = node.exchange_given(Default::default());
        node.exchange_given(given);
        assert!(node.has(0, 1) && !node.has(0, 3) && !node.has(1, 3));
        assert!(node.take_added().iter().all(Vec::is_empty));
    }

    #[test]
    fn scores_add_up_over_both_trees() {
        let mut node = Node::default();
        node.give(&[row(0, &[1, 11, 0, 1, 0, 4]), row(1, &[0, 0, 14, 6])], &bytes());
        let second = [row(0, &[0, 11, 0, 1, 1, 0]), row(1, &[2, 1, 14, 6])];
        assert_eq!(node.score(&second), 11 + 1 + 14 + 6);
    }

    #[test]
    fn what_a_worker_was_given_is_lost_with_it_unless_its_memory_is_shared() {
        let scenario = [row(0, &[1, 0, 0, 0, 0, 0]), row(1, &[0, 0, 14, 0])];
        for (mut nodes, left) in [(Nodes::private(2), 0), (Nodes::shared(vec![0, 0, 1]), 15)] {
            nodes.of_client_mut(0).give(&scenario, &bytes());
            assert_eq!(nodes.of_client(0).score(&scenario), 15);
            nodes.client_died(0);
            assert_eq!(nodes.of_client(0).score(&scenario), left);
            assert_eq!(nodes.of_client(1).score(&scenario), left, "the second is on the same node");
        }
    }
}
