//! What the pre-analysis costs where it is done as the paper does it (section 6.6): by descending the
//! trees of oriented boxes themselves.

use super::{CutTree, DistributedRoot};
use crate::geometry::Pose;
use crate::tree::TreeKind;
use crate::tree::node::{Child, Node, ObbNode};
use crate::tree::placement::{BoxNode, Placement};

/// How many pairs of boxes are tested to find the pairs of distributed roots that meet, from the tops
/// of both trees, into the larger box first. `None` for trees of other kinds.
pub fn box_tests(fixed: &CutTree<'_>, moving: &CutTree<'_>, pose: &Pose) -> Option<u64> {
    let trees = [fixed.tree(), moving.tree()];
    if trees.iter().any(|tree| tree.kind() != TreeKind::Obb) {
        return None;
    }
    let placement = Placement::new(trees[0], trees[1], pose);
    let [a_nodes, b_nodes] = trees.map(|tree| tree.nodes::<ObbNode>());
    let apart = |a: u32, b: u32| a_nodes[a as usize].apart(&b_nodes[b as usize], &placement);
    let mut tests = 1;
    let mut stack = vec![(0, 0)];
    stack.retain(|&(a, b)| !apart(a, b));
    while let Some((a, b)) = stack.pop() {
        let below = [below(a_nodes, fixed.roots(), a), below(b_nodes, moving.roots(), b)];
        let is_first_larger =
            || placement.first_is_larger(&a_nodes[a as usize], &b_nodes[b as usize]);
        let pairs = match below {
            [None, None] => continue,
            [Some(children), None] => children.map(|child| (child, b)),
            [None, Some(children)] => children.map(|child| (a, child)),
            [Some(children), Some(_)] if is_first_larger() => children.map(|child| (child, b)),
            [Some(_), Some(children)] => children.map(|child| (a, child)),
        };
        tests += 2;
        stack.extend(pairs.into_iter().filter(|&(a, b)| !apart(a, b)));
    }
    Some(tests)
}

/// The children of a node that is above the distributed roots.
fn below(nodes: &[ObbNode], roots: &[DistributedRoot], node: u32) -> Option<[u32; 2]> {
    match nodes[node as usize].link().child() {
        Child::Inner { right } if roots.binary_search_by_key(&node, |root| root.node).is_err() => {
            Some([node + 1, node + right])
        }
        _ => None,
    }
}
