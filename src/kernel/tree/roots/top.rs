//! The part of a tree above its distributed roots, small enough to be kept apart.

use super::{Cut, DistributedRoot};
use crate::geometry::Point;
use crate::geometry::boxes::bounds;
use crate::tree::node::{AabbNode, Child, Node, ObbNode, widen};
use crate::tree::wide::{BinaryNode, Bounds, grow_top};
use crate::tree::{Header, TreeKind, TreeView};

/// A binary tree of boxes along the axes of the mesh, whose leaves are the roots.
#[derive(Debug, Default)]
pub struct Top {
    pub nodes: Vec<BinaryNode>,
    pub roots: Vec<DistributedRoot>,
}

pub fn top_of(tree: &TreeView<'_>, cut: Cut) -> Top {
    let mut top = Top::default();
    match tree.kind() {
        TreeKind::Obb => {
            let bounds = |_: &ObbNode, first, end| bounds_of(tree, first..end);
            Binary { nodes: tree.nodes(), bounds, cut, top: &mut top }.grow();
        }
        TreeKind::Aabb => {
            let bounds = |node: &AabbNode, _, _| Bounds::around(widen(node.center), node.half());
            Binary { nodes: tree.nodes(), bounds, cut, top: &mut top }.grow();
        }
        TreeKind::Wide => grow_top(tree, cut, &mut top),
    }
    top
}

impl Top {
    /// Adds a leaf: the next root from left to right.
    pub fn add_root(&mut self, root: DistributedRoot, bounds: Bounds) {
        self.roots.push(root);
        let DistributedRoot { first, triangles: count, .. } = root;
        self.nodes.push(BinaryNode { bounds, first, count, right: 0 });
    }

    /// Adds a node, whose left child comes next; where it is.
    pub fn add_inner(&mut self) -> usize {
        self.nodes.push(BinaryNode::NOWHERE);
        self.nodes.len() - 1
    }

    /// Once both subtrees are there.
    pub fn close_inner(&mut self, at: usize, right: usize) {
        let [a, b] = [at + 1, right].map(|child| self.nodes[child]);
        self.nodes[at] = BinaryNode {
            bounds: a.bounds.with(&b.bounds),
            first: a.first,
            count: a.count + b.count,
            right: (right - at) as u32,
        };
    }
}

struct Binary<'a, N, B> {
    nodes: &'a [N],
    bounds: B,
    cut: Cut,
    top: &'a mut Top,
}

impl<N: Node, B: Fn(&N, u32, u32) -> Bounds> Binary<'_, N, B> {
    fn grow(&mut self) {
        self.subtree(0, self.nodes.len(), 0, 0);
    }

    /// Below the node `at`, up to the node `end`. As deep a recursion as [`Cut`] allows.
    fn subtree(&mut self, at: usize, end: usize, first: u32, depth: u32) {
        let node = &self.nodes[at];
        let triangles = (end - at).div_ceil(2) as u32;
        match node.link().child() {
            Child::Inner { right } if !self.cut.is_at(depth, triangles) => {
                let inner = self.top.add_inner();
                let middle = at + right as usize;
                self.subtree(at + 1, middle, first, depth + 1);
                let right = self.top.nodes.len();
                self.subtree(middle, end, first + (middle - at) as u32 / 2, depth + 1);
                self.top.close_inner(inner, right);
            }
            _ => {
                let bounds = (self.bounds)(node, first, first + triangles);
                let root = DistributedRoot { node: at as u32, lanes: 1, first, triangles };
                self.top.add_root(root, bounds);
            }
        }
    }
}

/// Tighter than a box around the turned one.
fn bounds_of(tree: &TreeView<'_>, ranks: std::ops::Range<u32>) -> Bounds {
    let Header { origin, unit, .. } = tree.header();
    let corners = ranks.flat_map(|rank| tree.corners(rank)).collect::<Vec<_>>();
    let (low, high) = bounds(&corners);
    let normalised = |v: Point| [0, 1, 2].map(|k| (v[k] - origin[k]) / unit);
    Bounds::rounded_outwards(normalised(low), normalised(high))
}
