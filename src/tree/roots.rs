//! Distributed roots: the nodes at depth d, or leaves above it, numbered from left to right
//! (figure 2 of the paper), and the pairs of them that a scenario needs (section 6.6).
//!
//! A wide tree is a binary tree with levels left out of its nodes; depth is counted in the levels
//! of that.

use super::node::{AabbNode, Child, Node, ObbNode};
use super::placement::{BoxNode, Placement};
use super::wide::{TopLeaf, top_of};
use super::{TreeKind, TreeView};
use crate::geometry::Pose;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DistributedRoot {
    /// Index of the node in the image; its subtree is the `2 * triangles - 1` nodes from there. Of
    /// a wide tree the first lane, eight times the node and the lane in it.
    pub node: u32,
    /// Leaves below it.
    pub triangles: u32,
}

pub fn distributed_roots(tree: &TreeView<'_>, depth: u32) -> Vec<DistributedRoot> {
    match tree.kind() {
        TreeKind::Obb => collect(tree.nodes::<ObbNode>(), depth),
        TreeKind::Aabb => collect(tree.nodes::<AabbNode>(), depth),
        TreeKind::Wide => wide_top(tree, depth).1,
    }
}

fn wide_top(tree: &TreeView<'_>, depth: u32) -> (Vec<AabbNode>, Vec<DistributedRoot>) {
    let triangles = tree.triangle_count();
    let (nodes, roots) = top_of(tree.wide_nodes(), tree.leaf_boxes(), triangles, depth);
    let root = |r: TopLeaf| DistributedRoot { node: r.slot, triangles: r.triangles };
    (nodes, roots.into_iter().map(root).collect())
}

fn collect<N: Node>(nodes: &[N], depth: u32) -> Vec<DistributedRoot> {
    let mut roots = Vec::new();
    let mut open = vec![(0, nodes.len(), depth)];
    while let Some((at, end, depth)) = open.pop() {
        match nodes[at].link().child() {
            Child::Inner { right } if depth > 0 => {
                let right = at + right as usize;
                open.push((right, end, depth - 1));
                open.push((at + 1, right, depth - 1));
            }
            _ => {
                let triangles = (end - at).div_ceil(2) as u32;
                roots.push(DistributedRoot { node: at as u32, triangles });
            }
        }
    }
    roots
}

/// Pre-analysis of scenarios: the pairs of distributed roots whose boxes meet.
#[derive(Debug)]
pub struct PreAnalysis<'a> {
    fixed: Side<'a>,
    moving: Side<'a>,
    stack: Vec<(u32, u32)>,
}

#[derive(Debug)]
struct Side<'a> {
    tree: TreeView<'a>,
    roots: Vec<DistributedRoot>,
    /// The nodes above the roots of a wide tree, and the roots as their leaves.
    top: Vec<AabbNode>,
}

impl<'a> Side<'a> {
    fn new(tree: TreeView<'a>, depth: u32) -> Self {
        let (top, roots) = match tree.kind() {
            TreeKind::Wide => wide_top(&tree, depth),
            _ => (Vec::new(), distributed_roots(&tree, depth)),
        };
        Self { tree, roots, top }
    }

    /// Number of the distributed root at this node; `None` for a node above them.
    fn number(&self, at: u32) -> Option<u32> {
        if self.top.is_empty() {
            // They are numbered in the order of their nodes.
            return self.roots.binary_search_by_key(&at, |root| root.node).ok().map(|i| i as u32);
        }
        match self.top[at as usize].link().child() {
            Child::Leaf { rank } => Some(rank),
            Child::Inner { .. } => None,
        }
    }
}

impl<'a> PreAnalysis<'a> {
    /// # Panics
    /// If the trees are of different kinds.
    pub fn new(
        fixed: TreeView<'a>,
        fixed_depth: u32,
        moving: TreeView<'a>,
        moving_depth: u32,
    ) -> Self {
        assert_eq!(fixed.kind(), moving.kind(), "trees of one scene are of one kind");
        let (fixed, moving) = (Side::new(fixed, fixed_depth), Side::new(moving, moving_depth));
        Self { fixed, moving, stack: Vec::new() }
    }

    pub fn fixed_roots(&self) -> &[DistributedRoot] {
        &self.fixed.roots
    }

    pub fn moving_roots(&self) -> &[DistributedRoot] {
        &self.moving.roots
    }

    /// Replaces `pairs` by (number of the fixed root, number of the moving root). Every
    /// intersecting pair of triangles lies below one of them.
    pub fn overlapping_roots(&mut self, pose: &Pose, pairs: &mut Vec<[u32; 2]>) {
        pairs.clear();
        match self.fixed.tree.kind() {
            TreeKind::Obb => self.descend(|side| side.tree.nodes::<ObbNode>(), pose, pairs),
            TreeKind::Aabb => self.descend(|side| side.tree.nodes::<AabbNode>(), pose, pairs),
            TreeKind::Wide => self.descend(|side| &side.top, pose, pairs),
        }
    }

    fn descend<N: BoxNode>(
        &mut self,
        nodes: impl for<'s> Fn(&'s Side<'a>) -> &'s [N],
        pose: &Pose,
        pairs: &mut Vec<[u32; 2]>,
    ) {
        let (fixed, moving) = (&self.fixed, &self.moving);
        let (a_nodes, b_nodes) = (nodes(fixed), nodes(moving));
        let placement = Placement::new(&fixed.tree, &moving.tree, pose);
        self.stack.clear();
        self.stack.push((0, 0));
        while let Some((a, b)) = self.stack.pop() {
            let (a_node, b_node) = (&a_nodes[a as usize], &b_nodes[b as usize]);
            if a_node.apart(b_node, &placement) {
                continue;
            }
            match (fixed.number(a), moving.number(b)) {
                (Some(a), Some(b)) => pairs.push([a, b]),
                (None, root) if root.is_some() || placement.first_is_larger(a_node, b_node) => {
                    self.stack.extend(children(a_node, a).map(|child| (child, b)));
                }
                _ => self.stack.extend(children(b_node, b).map(|child| (a, child))),
            }
        }
    }
}

/// Right, then left: the left one is on top of a stack. A node above the distributed roots has
/// both.
fn children<N: Node>(node: &N, at: u32) -> [u32; 2] {
    match node.link().child() {
        Child::Inner { right } => [at + right, at + 1],
        Child::Leaf { .. } => unreachable!("a leaf is a distributed root"),
    }
}
