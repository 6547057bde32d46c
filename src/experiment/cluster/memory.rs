//! How full the memory of each node gets.

use super::machine::Node;
use super::outcome::MemoryUse;

#[derive(Debug)]
pub struct Memory {
    /// Bytes in use now, and the most so far.
    nodes: Vec<[f64; 2]>,
}

impl Memory {
    pub fn new(nodes: usize) -> Self {
        Self { nodes: vec![[0.0; 2]; nodes] }
    }

    pub fn take(&mut self, node: usize, bytes: f64) {
        let [used, most] = &mut self.nodes[node];
        *used += bytes;
        *most = most.max(*used);
    }

    pub fn give_back(&mut self, node: usize, bytes: f64) {
        self.nodes[node][0] -= bytes;
    }

    /// `nodes` are those that it was made for.
    pub fn most(&self, nodes: &[Node]) -> MemoryUse {
        let fill =
            |(number, node): (usize, &Node)| (self.nodes[number][1] / node.memory_bytes, number);
        let fullest = nodes.iter().enumerate().map(fill);
        let (fullest, fullest_node) =
            fullest.max_by(|a, b| a.0.total_cmp(&b.0)).expect("there are nodes");
        MemoryUse { fullest, fullest_node, bytes: self.nodes.iter().map(|[_, most]| most).sum() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_that_was_in_use_at_a_time_counts() {
        let mut memory = Memory::new(2);
        memory.take(0, 60.0);
        memory.give_back(0, 50.0);
        memory.take(0, 70.0);
        memory.take(1, 30.0);
        let node = |memory_bytes| Node { cores: 1, speed: 1.0, memory_bytes };
        let most = memory.most(&[node(100.0), node(20.0)]);
        assert_eq!(most, MemoryUse { fullest: 1.5, fullest_node: 1, bytes: 110.0 });
        assert!(most.is_exceeded());
    }
}
