//! Whether sections of an image are one wide tree: asked once of bytes from outside, so that the
//! descent need not ask.

use std::ops::Range;

use super::node::{Below, LeafBox, LeafRows, MOST, WIDTH, WideChild, WideNode};
use crate::tree::LeafTriangle;

/// What is wrong, if anything is.
pub fn check(
    nodes: &[WideNode],
    (leaves, rows): (&[LeafBox], &[LeafRows]),
    triangles: &[LeafTriangle],
) -> Result<(), &'static str> {
    if nodes.is_empty() || nodes.len() >= MOST || leaves.is_empty() || leaves.len() >= MOST {
        return Err("the number of nodes or leaves is out of range");
    }
    let root = [WideChild::new(Below::Node(0), 1)];
    let mut walk = Walk { nodes, base: 0, next_node: 0, next_leaf: 0, alone: nodes.len() == 1 };
    walk.below(&root)?;
    walk.end(leaves.len())?;
    check_leaves((leaves, rows), triangles, 0..triangles.len() as u32)
}

/// As [`check`], of what lies below some lanes: nodes and leaves numbered from these, triangles of
/// these ranks.
pub fn check_below(
    children: &[WideChild],
    (first_node, nodes): (u32, &[WideNode]),
    (first_leaf, leaves, rows): (u32, &[LeafBox], &[LeafRows]),
    triangles: &[LeafTriangle],
    ranks: Range<u32>,
) -> Result<(), &'static str> {
    let (next_node, next_leaf) = (first_node, first_leaf);
    let mut walk = Walk { nodes, base: first_node, next_node, next_leaf, alone: false };
    walk.below(children)?;
    walk.end(first_leaf as usize + leaves.len())?;
    check_leaves((leaves, rows), triangles, ranks)
}

/// `triangles` are those of these ranks.
fn check_leaves(
    (leaves, rows): (&[LeafBox], &[LeafRows]),
    triangles: &[LeafTriangle],
    ranks: Range<u32>,
) -> Result<(), &'static str> {
    let ends = leaves.iter().skip(1).map(|leaf| leaf.first).chain([ranks.end]);
    let mut first = ranks.start;
    for ((leaf, rows), end) in leaves.iter().zip(rows).zip(ends) {
        if leaf.first != first || end <= first || end - first > WIDTH as u32 {
            return Err("a leaf does not have one to eight triangles of its own");
        }
        let [from, to] = [first, end].map(|rank| rank.wrapping_sub(ranks.start) as usize);
        let own = triangles.get(from..to);
        if !own.is_some_and(|own| holds(rows, own)) {
            return Err("a leaf's rows are not of its triangles");
        }
        first = end;
    }
    Ok(())
}

/// In each lane a triangle of the leaf, and no number in those that are left over.
fn holds(rows: &LeafRows, triangles: &[LeafTriangle]) -> bool {
    let used = triangles.len();
    let (ids, rest) = rows.ids.split_at(used);
    // Without branches: every worker asks this of every leaf before its first scenario.
    let no_number = |row: &[f32; WIDTH]| {
        let fits = |(lane, x): (usize, &f32)| (lane < used) | x.is_nan();
        row.iter().enumerate().map(fits).fold(true, |all, one| all & one)
    };
    let no_numbers = |row: &[f32]| row.as_chunks().0.iter().map(no_number).fold(true, |a, b| a & b);
    ids.iter().zip(triangles).all(|(id, triangle)| *id == triangle.id)
        && rest.iter().all(|id| *id == u32::MAX)
        && no_numbers(rows.first_two.as_flattened())
        && no_numbers(rows.third.as_flattened())
}

/// Lanes of a node, and the ranges of nodes and leaves below them.
#[derive(Clone, Copy, Debug)]
pub struct Root {
    pub slot: u32,
    pub lanes: u32,
    pub first_node: u32,
    pub nodes: u32,
    pub first_leaf: u32,
    pub leaves: u32,
}

/// Whether the nodes above roots, in their order, and the roots, in theirs, are one tree; the
/// nodes' numbers in it. `node_count` nodes it has in all.
pub fn check_top(
    top: &[WideNode],
    roots: impl Iterator<Item = Root>,
    node_count: u32,
) -> Result<Vec<u32>, &'static str> {
    const BROKEN: &str = "roots and the nodes above them are not one tree";
    if top.is_empty() || node_count as usize >= MOST {
        return Err("the number of nodes is out of range");
    }
    let mut roots = roots.peekable();
    let (mut numbers, mut next_node, mut next_leaf) = (vec![0], 1, 0);
    let mut open = vec![(0, 0)];
    while let Some((at, lane)) = open.pop() {
        let lanes = check_lanes(&top[at], node_count == 1)?;
        if lane == lanes {
            continue;
        }
        let slot = numbers[at] * WIDTH as u32 + lane as u32;
        if let Some(root) = roots.next_if(|root| root.slot == slot) {
            let first_node = if root.nodes == 0 { 0 } else { next_node };
            let fits = (1..=lanes - lane).contains(&(root.lanes as usize));
            if !fits || (root.first_node, root.first_leaf) != (first_node, next_leaf) {
                return Err(BROKEN);
            }
            // No overflow: whoever calls has summed up both.
            (next_node, next_leaf) = (next_node + root.nodes, next_leaf + root.leaves);
            open.push((at, lane + root.lanes as usize));
        } else if top[at].child[lane].below() == Below::Node(next_node) && numbers.len() < top.len()
        {
            open.extend([(at, lane + 1), (numbers.len(), 0)]);
            numbers.push(next_node);
            next_node += 1;
        } else {
            return Err(BROKEN);
        }
    }
    let all = roots.next().is_none() && numbers.len() == top.len() && next_node == node_count;
    if all { Ok(numbers) } else { Err(BROKEN) }
}

struct Walk<'a> {
    nodes: &'a [WideNode],
    /// Number of the first.
    base: u32,
    next_node: u32,
    next_leaf: u32,
    /// Whether there is one node in all.
    alone: bool,
}

impl<'a> Walk<'a> {
    /// Depth first, without recursion: bytes from outside may be as deep as they like.
    fn below(&mut self, children: &'a [WideChild]) -> Result<(), &'static str> {
        let mut open = vec![children];
        while let Some(children) = open.pop() {
            let Some((child, rest)) = children.split_first() else { continue };
            open.push(rest);
            let at = (self.next_node - self.base) as usize;
            match child.below() {
                Below::Leaf(leaf) if leaf == self.next_leaf => self.next_leaf += 1,
                Below::Node(child) if child == self.next_node && at < self.nodes.len() => {
                    self.next_node += 1;
                    let node = &self.nodes[at];
                    open.push(&node.child[..check_lanes(node, self.alone)?]);
                }
                _ => return Err("the nodes are not one depth-first tree"),
            }
        }
        Ok(())
    }

    fn end(&self, leaves: usize) -> Result<(), &'static str> {
        let nodes = self.base as usize + self.nodes.len();
        if (self.next_node as usize, self.next_leaf as usize) != (nodes, leaves) {
            return Err("nodes or leaves are left over");
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
    // A box that could be met would lead to the child that is not there.
    let boxes = node.center.iter().chain(&node.half);
    if !boxes.flat_map(|row| &row[lanes..]).all(|x| x.is_nan()) {
        return Err("a node has a box without a child");
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
