//! The upper part of the binary tree that a wide one stands for, down to its distributed roots.

use super::build::Bounds;
use super::node::{Below, LeafBox, WIDTH, WideChild, WideNode};
use crate::tree::TreeView;
use crate::tree::node::widen;
use crate::tree::roots::{Cut, DistributedRoot, Top};

pub fn grow_top(tree: &TreeView<'_>, cut: Cut, top: &mut Top) {
    let mut grow = Grow { nodes: tree.wide_nodes(), leaves: tree.leaf_boxes(), cut, top };
    let to = grow.nodes[0].lanes();
    let end = tree.triangle_count();
    grow.subtree(Branch { node: 0, from: 0, to, level: 0, depth: 0, first: 0, end });
}

struct Grow<'a> {
    nodes: &'a [WideNode],
    leaves: &'a [LeafBox],
    cut: Cut,
    top: &'a mut Top,
}

/// A binary node: some lanes of a wide one, `level` levels below it, and the ranks of its
/// triangles.
#[derive(Clone, Copy)]
struct Branch {
    node: u32,
    from: usize,
    to: usize,
    level: u32,
    depth: u32,
    first: u32,
    end: u32,
}

impl Grow<'_> {
    /// As deep a recursion as [`Cut`] allows.
    fn subtree(&mut self, branch: Branch) {
        let Branch { node, from, to, depth, first, end, .. } = branch;
        let lanes = &self.nodes[node as usize].child;
        let is_root = self.cut.is_at(depth, end - first);
        if to - from == 1 {
            match lanes[from].below() {
                Below::Node(child) if !is_root => {
                    let to = self.nodes[child as usize].lanes();
                    self.subtree(Branch { node: child, from: 0, to, level: 0, ..branch });
                }
                _ => self.root(&branch),
            }
        } else if is_root {
            self.root(&branch);
        } else {
            let middle = middle(lanes, &branch);
            let between = self.first_triangle(lanes[middle]);
            let below = Branch { level: branch.level + 1, depth: depth + 1, ..branch };
            let inner = self.top.add_inner();
            self.subtree(Branch { to: middle, end: between, ..below });
            let right = self.top.nodes.len();
            self.subtree(Branch { from: middle, first: between, ..below });
            self.top.close_inner(inner, right);
        }
    }

    fn root(&mut self, branch: &Branch) {
        let &Branch { node, from, to, first, end, .. } = branch;
        let wide = &self.nodes[node as usize];
        let bounds = (from..to).fold(Bounds::NOTHING, |all, lane| {
            let [center, half] = [wide.center, wide.half].map(|rows| rows.map(|row| row[lane]));
            all.with(&Bounds::around(widen(center), widen(half)))
        });
        let node = node * WIDTH as u32 + from as u32;
        let lanes = (to - from) as u32;
        self.top.add_root(DistributedRoot { node, lanes, first, triangles: end - first }, bounds);
    }

    fn first_triangle(&self, mut child: WideChild) -> u32 {
        loop {
            match child.below() {
                Below::Leaf(leaf) => return self.leaves[leaf as usize].first,
                Below::Node(node) => child = self.nodes[node as usize].child[0],
            }
        }
    }
}

/// Where the right child's lanes begin: the left child's make up half of the whole.
fn middle(lanes: &[WideChild; WIDTH], branch: &Branch) -> usize {
    let half = 128 >> (branch.level + 1);
    let mut sum = 0;
    for (lane, child) in lanes.iter().enumerate().take(branch.to).skip(branch.from) {
        sum += 128 >> child.levels();
        if sum >= half {
            return lane + 1;
        }
    }
    branch.to - 1
}
