//! The descent for poses and trees that 32 bits are not made for: matrices far from a rotation,
//! units far apart, distances beyond all extents. Slow and simple.

use super::leaf_pairs::{Exact, Leaves};
use super::node::{Below, Slot, WIDTH, WideChild, WideNode};
use crate::tree::node::AabbNode;
use crate::tree::node::Link;
use crate::tree::placement::{BoxNode, Placement};
use crate::tree::sink::Sink;

pub struct Trees<'a> {
    pub fixed: &'a [WideNode],
    pub moving: &'a [WideNode],
    pub fixed_leaves: Leaves<'a>,
    pub moving_leaves: Leaves<'a>,
    /// How many each tree has.
    pub triangles: [u32; 2],
    pub exact: Exact<'a>,
    pub placement: Placement,
}

impl Trees<'_> {
    pub fn descend<K: Sink>(&self, sink: &mut K) {
        let mut stack: Vec<[Slot; 2]> = Vec::new();
        for a in lanes(self.fixed, 0) {
            for b in lanes(self.moving, 0) {
                self.push_if_met(&mut stack, a, b, sink);
            }
        }
        while let Some([a, b]) = stack.pop() {
            match (child(self.fixed, a).below(), child(self.moving, b).below()) {
                (Below::Leaf(a), Below::Leaf(b)) => self.leaves(a, b, sink),
                (Below::Node(node), Below::Leaf(_)) => {
                    lanes(self.fixed, node).for_each(|a| self.push_if_met(&mut stack, a, b, sink));
                }
                (Below::Leaf(_), Below::Node(node)) => {
                    lanes(self.moving, node).for_each(|b| self.push_if_met(&mut stack, a, b, sink));
                }
                (Below::Node(a), Below::Node(b)) => {
                    for a in lanes(self.fixed, a) {
                        lanes(self.moving, b)
                            .for_each(|b| self.push_if_met(&mut stack, a, b, sink));
                    }
                }
            }
            if sink.has_enough() {
                return;
            }
        }
    }

    fn push_if_met<K: Sink>(&self, stack: &mut Vec<[Slot; 2]>, a: Slot, b: Slot, sink: &mut K) {
        sink.boxes(1);
        if !boxed(self.fixed, a).apart(&boxed(self.moving, b), &self.placement) {
            stack.push([a, b]);
        }
    }

    fn leaves<K: Sink>(&self, a: u32, b: u32, sink: &mut K) {
        for (rank_a, id_a) in ranks(&self.fixed_leaves, self.triangles[0], a) {
            for (rank_b, id_b) in ranks(&self.moving_leaves, self.triangles[1], b) {
                sink.triangles(1);
                sink.exact(1);
                if self.exact.intersect(rank_a, rank_b) {
                    sink.take([id_a, id_b]);
                }
            }
        }
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
