//! The upper part of the binary tree that a wide one stands for, down to its distributed roots.

use super::in_64_bits::boxed;
use super::node::{Below, LeafBox, Slot, WIDTH, WideNode};
use crate::tree::node::{AabbNode, Link, widen};

/// A node of depth `depth`, or a leaf above it: its first slot and how many triangles it has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopLeaf {
    pub slot: Slot,
    pub triangles: u32,
}

/// The binary nodes down to `depth`, depth first, and their leaves from left to right.
pub fn top_of(
    nodes: &[WideNode],
    leaves: &[LeafBox],
    triangles: u32,
    depth: u32,
) -> (Vec<AabbNode>, Vec<TopLeaf>) {
    let mut top = Top { nodes, leaves, binary: Vec::new(), roots: Vec::new() };
    top.descend(Part { node: 0, from: 0, to: nodes[0].lanes(), level: 0 }, depth);
    // So far each has its first triangle.
    let ends: Vec<u32> =
        top.roots.iter().skip(1).map(|root| root.triangles).chain([triangles]).collect();
    for (root, end) in top.roots.iter_mut().zip(ends) {
        root.triangles = end - root.triangles;
    }
    (top.binary, top.roots)
}

struct Top<'a> {
    nodes: &'a [WideNode],
    leaves: &'a [LeafBox],
    binary: Vec<AabbNode>,
    roots: Vec<TopLeaf>,
}

/// A binary node: some lanes of a wide one, that many levels below it.
#[derive(Clone, Copy)]
struct Part {
    node: u32,
    from: usize,
    to: usize,
    level: u32,
}

impl Top<'_> {
    fn descend(&mut self, part: Part, depth: u32) {
        let node = &self.nodes[part.node as usize];
        let slot = part.node * WIDTH as u32 + part.from as u32;
        if part.to - part.from == 1
            && let Below::Node(child) = node.child[part.from].below()
            && depth > 0
        {
            let to = self.nodes[child as usize].lanes();
            return self.descend(Part { node: child, from: 0, to, level: 0 }, depth);
        }
        let at = self.binary.len();
        let union = self.union(&part);
        if depth == 0 || part.to - part.from == 1 {
            let rank = self.roots.len() as u32;
            self.roots.push(TopLeaf { slot, triangles: self.first_triangle(slot) });
            self.binary.push(AabbNode { link: Link::leaf(rank), ..union });
            return;
        }
        self.binary.push(union);
        let middle = middle(node, &part);
        let level = part.level + 1;
        self.descend(Part { to: middle, level, ..part }, depth - 1);
        self.binary[at].link = Link::inner((self.binary.len() - at) as u32);
        self.descend(Part { from: middle, level, ..part }, depth - 1);
    }

    fn first_triangle(&self, slot: Slot) -> u32 {
        let mut child = self.nodes[slot as usize / WIDTH].child[slot as usize % WIDTH];
        loop {
            match child.below() {
                Below::Leaf(leaf) => return self.leaves[leaf as usize].first,
                Below::Node(node) => child = self.nodes[node as usize].child[0],
            }
        }
    }

    /// A box around the boxes of all lanes.
    fn union(&self, part: &Part) -> AabbNode {
        let slots = (part.from..part.to).map(|lane| part.node * WIDTH as u32 + lane as u32);
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for one in slots.map(|slot| boxed(self.nodes, slot)) {
            let (center, half) = (widen(one.center), widen(one.half));
            for k in 0..3 {
                low[k] = low[k].min(center[k] - half[k]);
                high[k] = high[k].max(center[k] + half[k]);
            }
        }
        let center = [0, 1, 2].map(|k| (0.5 * (low[k] + high[k])) as f32);
        let half = [0, 1, 2].map(|k| {
            let center = f64::from(center[k]);
            ((high[k] - center).max(center - low[k]) as f32).next_up()
        });
        AabbNode { center, half, link: Link::leaf(0), reserved: 0 }
    }
}

/// Where the right child's lanes begin: the left child's make up half of the whole.
fn middle(node: &WideNode, part: &Part) -> usize {
    let half = 128 >> (part.level + 1);
    let mut sum = 0;
    for lane in part.from..part.to {
        sum += 128 >> node.child[lane].levels();
        if sum >= half {
            return lane + 1;
        }
    }
    part.to - 1
}
