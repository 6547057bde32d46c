//! Whether sections of an image are one wide tree: asked once of bytes from outside, so that the
//! descent need not ask.

use super::node::{Below, LeafBox, MOST, WIDTH, WideChild, WideNode};

/// What is wrong, if anything is.
pub fn check(nodes: &[WideNode], leaves: &[LeafBox], triangles: u32) -> Result<(), &'static str> {
    if nodes.is_empty() || nodes.len() >= MOST || leaves.is_empty() || leaves.len() >= MOST {
        return Err("the number of nodes or leaves is out of range");
    }
    let mut walk = Walk { nodes, next_node: 1, next_leaf: 0 };
    walk.subtrees()?;
    if walk.next_node as usize != nodes.len() || walk.next_leaf as usize != leaves.len() {
        return Err("nodes or leaves are left over");
    }
    let ends = leaves[1..].iter().map(|leaf| leaf.first).chain([triangles]);
    let mut first = 0;
    for (leaf, end) in leaves.iter().zip(ends) {
        if leaf.first != first || end <= first || end - first > WIDTH as u32 {
            return Err("a leaf does not have one to eight triangles of its own");
        }
        first = end;
    }
    Ok(())
}

struct Walk<'a> {
    nodes: &'a [WideNode],
    next_node: u32,
    next_leaf: u32,
}

impl Walk<'_> {
    /// Depth first, without recursion: bytes from outside may be as deep as they like.
    fn subtrees(&mut self) -> Result<(), &'static str> {
        let mut open = vec![(0_usize, 0_usize)];
        while let Some((node, lane)) = open.pop() {
            let lanes = check_lanes(&self.nodes[node], self.nodes.len() == 1)?;
            if lane == lanes {
                continue;
            }
            open.push((node, lane + 1));
            match self.nodes[node].child[lane].below() {
                Below::Leaf(leaf) if leaf == self.next_leaf => self.next_leaf += 1,
                Below::Node(child)
                    if child == self.next_node && (child as usize) < self.nodes.len() =>
                {
                    self.next_node += 1;
                    open.push((child as usize, 0));
                }
                _ => return Err("the nodes are not one depth-first tree"),
            }
        }
        Ok(())
    }
}

/// The number of lanes in use, which come first and are the leaves of one binary tree.
fn check_lanes(node: &WideNode, alone: bool) -> Result<usize, &'static str> {
    let lanes = node.lanes();
    let rest = &node.child[lanes..];
    if lanes == 0 || rest.iter().any(|child| *child != WideChild::NONE) {
        return Err("a node's lanes are not in their place");
    }
    // Parts of the whole, in 128ths, that the lanes so far make up.
    let mut before = 0_u32;
    for child in &node.child[..lanes] {
        if child.levels() >= WIDTH as u32 {
            return Err("a node's lanes are no binary tree");
        }
        let part = 128 >> child.levels();
        if !before.is_multiple_of(part) {
            return Err("a node's lanes are no binary tree");
        }
        before += part;
    }
    // A tree of a single leaf has one lane.
    if before == 128 || (alone && lanes == 1 && before == 64) {
        Ok(lanes)
    } else {
        Err("a node's lanes are no binary tree")
    }
}
