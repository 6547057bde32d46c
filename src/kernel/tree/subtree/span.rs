use bytemuck::{Pod, Zeroable};

use crate::geometry::Point;
use crate::tree::node::{AabbNode, ObbNode};
use crate::tree::roots::DistributedRoot;
use crate::tree::wide::{Below, LeafBox, LeafRows, Root, WIDTH, WideChild, WideNode};
use crate::tree::{LeafTriangle, TreeKind, TreeView};

/// A root, and where in each section of the image its subtree lies.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Span {
    /// As in [`DistributedRoot`].
    pub node: u32,
    pub lanes: u32,
    pub first_triangle: u32,
    pub triangles: u32,
    /// Of a wide tree the nodes below that of the root, which other roots may have lanes of.
    pub first_node: u32,
    pub nodes: u32,
    pub first_leaf: u32,
    pub leaves: u32,
    /// Vertices that no triangle further left has.
    pub first_vertex: u32,
    pub vertices: u32,
}

const _: () = assert!(size_of::<Span>() == 40);

impl Span {
    /// All but the vertices.
    pub fn of(tree: &TreeView<'_>, root: &DistributedRoot) -> Self {
        let &DistributedRoot { node, lanes, first: first_triangle, triangles } = root;
        let mut span =
            Self { node, lanes, first_triangle, triangles, first_node: node, ..Self::zeroed() };
        if tree.kind() == TreeKind::Wide {
            span.add_wide(tree.wide_nodes());
        } else {
            span.nodes = 2 * triangles - 1;
        }
        span
    }

    /// Nodes and leaves are in the order of the lanes.
    fn add_wide(&mut self, nodes: &[WideNode]) {
        let children = self.children(nodes);
        let below = |child: &&WideChild| !child.is_leaf();
        self.first_node = 0;
        if let (Some(first), Some(last)) =
            (children.iter().find(below), children.iter().rfind(below))
        {
            self.first_node = first.index();
            self.nodes = last_node(nodes, last.index()) + 1 - first.index();
        }
        self.first_leaf = leaf_at_end(nodes, children[0], |children| children[0]);
        let last = leaf_at_end(nodes, children[children.len() - 1], |children| {
            children[children.len() - 1]
        });
        self.leaves = last + 1 - self.first_leaf;
    }

    /// Of a wide tree: what its lanes have below them.
    pub fn children<'n>(&self, nodes: &'n [WideNode]) -> &'n [WideChild] {
        let lane = self.node as usize % WIDTH;
        &nodes[self.node as usize / WIDTH].child[lane..lane + self.lanes as usize]
    }

    /// Of a binary tree: whether it is a node and all below it.
    pub fn is_binary(&self) -> bool {
        let nodes = 2 * u64::from(self.triangles) - 1;
        self.lanes == 1 && self.first_node == self.node && u64::from(self.nodes) == nodes
    }

    pub fn lanes_below(&self) -> Root {
        let &Self { node: slot, lanes, first_node, nodes, first_leaf, leaves, .. } = self;
        Root { slot, lanes, first_node, nodes, first_leaf, leaves }
    }

    /// Of the arrays of its message, with so many vertices of subtrees further left.
    pub fn array_bytes(&self, kind: TreeKind, shared: u32) -> u64 {
        fn all<T>(count: u32) -> u64 {
            u64::from(count) * size_of::<T>() as u64
        }
        let nodes = match kind {
            TreeKind::Obb => all::<ObbNode>(self.nodes),
            TreeKind::Aabb => all::<AabbNode>(self.nodes),
            TreeKind::Wide => all::<WideNode>(self.nodes),
        };
        nodes
            + all::<LeafBox>(self.leaves)
            + all::<LeafRows>(self.leaves)
            + all::<LeafTriangle>(self.triangles)
            + all::<Point>(self.vertices)
            + all::<u32>(shared)
            + all::<Point>(shared)
    }

    pub fn root(&self) -> DistributedRoot {
        let &Self { node, lanes, first_triangle: first, triangles, .. } = self;
        DistributedRoot { node, lanes, first, triangles }
    }
}

fn last_node(nodes: &[WideNode], mut at: u32) -> u32 {
    loop {
        let node = &nodes[at as usize];
        match node.child[..node.lanes()].iter().rfind(|child| !child.is_leaf()) {
            Some(child) => at = child.index(),
            None => return at,
        }
    }
}

fn leaf_at_end(
    nodes: &[WideNode],
    mut child: WideChild,
    end: impl Fn(&[WideChild]) -> WideChild,
) -> u32 {
    loop {
        match child.below() {
            Below::Leaf(leaf) => return leaf,
            Below::Node(node) => {
                let node = &nodes[node as usize];
                child = end(&node.child[..node.lanes()]);
            }
        }
    }
}
