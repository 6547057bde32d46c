//! The descent for poses and trees that 32 bits are not made for: matrices far from a rotation,
//! units far apart, distances beyond all extents. Slow and simple.

use super::leaf_pairs::Leaves;
use super::node::{Below, Part, Slot, WIDTH, WideChild, WideNode};
use super::outcome::ByRank;
use crate::tree::node::AabbNode;
use crate::tree::node::Link;
use crate::tree::placement::{BoxNode, Placement};
use crate::tree::sink::Sink;

/// Two trees in a pose, down to their leaves.
pub struct Boxes<'a> {
    pub fixed: &'a [WideNode],
    pub moving: &'a [WideNode],
    pub placement: Placement,
}

/// What becomes of the leaves that meet.
pub trait Meet {
    fn boxes(&mut self, tests: usize);
    /// Whether the descent may end.
    fn leaves(&mut self, fixed: u32, moving: u32) -> bool;
}

impl Boxes<'_> {
    pub fn descend(&self, seeds: &[[Part; 2]], meet: &mut impl Meet) {
        let mut stack: Vec<[Slot; 2]> = Vec::new();
        for [a, b] in seeds {
            for a in a.lanes().map(|lane| a.slot(lane)) {
                for b in b.lanes().map(|lane| b.slot(lane)) {
                    self.push_if_met(&mut stack, a, b, meet);
                }
            }
        }
        while let Some([a, b]) = stack.pop() {
            match (child(self.fixed, a).below(), child(self.moving, b).below()) {
                (Below::Leaf(a), Below::Leaf(b)) => {
                    if meet.leaves(a, b) {
                        return;
                    }
                }
                (Below::Node(node), Below::Leaf(_)) => {
                    lanes(self.fixed, node).for_each(|a| self.push_if_met(&mut stack, a, b, meet));
                }
                (Below::Leaf(_), Below::Node(node)) => {
                    lanes(self.moving, node).for_each(|b| self.push_if_met(&mut stack, a, b, meet));
                }
                (Below::Node(a), Below::Node(b)) => {
                    for a in lanes(self.fixed, a) {
                        lanes(self.moving, b)
                            .for_each(|b| self.push_if_met(&mut stack, a, b, meet));
                    }
                }
            }
        }
    }

    fn push_if_met(&self, stack: &mut Vec<[Slot; 2]>, a: Slot, b: Slot, meet: &mut impl Meet) {
        meet.boxes(1);
        if !boxed(self.fixed, a).apart(&boxed(self.moving, b), &self.placement) {
            stack.push([a, b]);
        }
    }
}

/// To the triangles of leaves, which are tested one by one.
pub struct ToTriangles<'a, K> {
    pub fixed: Leaves<'a>,
    pub moving: Leaves<'a>,
    /// How many each tree has.
    pub triangles: [u32; 2],
    pub by_rank: ByRank<'a>,
    pub sink: &'a mut K,
}

impl<K: Sink> Meet for ToTriangles<'_, K> {
    fn boxes(&mut self, tests: usize) {
        self.sink.boxes(tests);
    }

    fn leaves(&mut self, a: u32, b: u32) -> bool {
        for (rank_a, id_a) in ranks(&self.fixed, self.triangles[0], a) {
            for (rank_b, id_b) in ranks(&self.moving, self.triangles[1], b) {
                self.sink.triangles(1);
                self.sink.exact(1);
                if self.by_rank.intersect(rank_a, rank_b) {
                    self.sink.take([id_a, id_b]);
                }
            }
        }
        self.sink.has_enough()
    }
}

/// To pairs of leaves.
pub struct LeafPairsOnly<'a> {
    pub pairs: &'a mut Vec<[u32; 2]>,
    pub tests: u64,
}

impl Meet for LeafPairsOnly<'_> {
    fn boxes(&mut self, tests: usize) {
        self.tests += tests as u64;
    }

    fn leaves(&mut self, fixed: u32, moving: u32) -> bool {
        self.pairs.push([fixed, moving]);
        false
    }
}

fn lanes(nodes: &[WideNode], node: u32) -> impl Iterator<Item = Slot> {
    (0..nodes[node as usize].lanes() as u32).map(move |lane| node * WIDTH as u32 + lane)
}

fn child(nodes: &[WideNode], slot: Slot) -> WideChild {
    nodes[slot as usize / WIDTH].child[slot as usize % WIDTH]
}

/// A slot's box as a node of a binary tree.
pub fn boxed(nodes: &[WideNode], slot: Slot) -> AabbNode {
    let (node, lane) = (&nodes[slot as usize / WIDTH], slot as usize % WIDTH);
    AabbNode {
        center: node.center.map(|row| row[lane]),
        half: node.half.map(|row| row[lane]),
        link: Link::leaf(0),
        reserved: 0,
    }
}

/// Ranks and numbers in the file.
fn ranks<'a>(
    leaves: &Leaves<'a>,
    triangles: u32,
    leaf: u32,
) -> impl Iterator<Item = (u32, u32)> + use<'a> {
    let first = leaves.boxes[leaf as usize].first;
    let end = leaves.boxes.get(leaf as usize + 1).map_or(triangles, |next| next.first);
    (first..end).zip(leaves.rows[leaf as usize].ids)
}
