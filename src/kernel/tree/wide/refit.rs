//! A wide tree whose vertices have moved: leaves first, then the nodes above them.

use rayon::prelude::*;

use super::build::Bounds;
use super::collapse::set_box;
use super::leaf_fit::refit_leaf;
use super::node::{Below, LeafBox, LeafRows, WIDTH, WideChild, WideNode};
use crate::geometry::Point;
use crate::tree::refit::Moved;

/// Below this many another task does not pay.
const PARALLEL_LEAVES: usize = 256;
const PARALLEL_NODES: usize = 256;

/// The boxes of all nodes become those that [`super::collapsed`] would give them.
pub fn refit(
    nodes: &mut [WideNode],
    (leaf_boxes, leaf_rows): (&mut [LeafBox], &mut [LeafRows]),
    moved: &Moved<'_>,
) {
    let ends: Vec<u32> = leaf_boxes.iter().skip(1).map(|leaf| leaf.first).collect();
    let leaves = leaf_boxes.par_iter_mut().zip(leaf_rows);
    let refit_one = |(number, (leaf, rows)): (usize, (&mut LeafBox, &mut LeafRows))| {
        let end = ends.get(number).copied().unwrap_or(moved.triangle_count());
        if moved.any_of(leaf.first..end) {
            let mut room = [[Point::default(); 3]; WIDTH];
            let triangles = &mut room[..(end - leaf.first) as usize];
            for (triangle, rank) in triangles.iter_mut().zip(leaf.first..) {
                *triangle = moved.triangle(rank);
            }
            refit_leaf(triangles, moved.unit_before, leaf, rows);
        }
        let (low, high) = moved.bounds(leaf.first..end);
        Bounds::rounded_outwards(low, high)
    };
    let of_leaves: Vec<Bounds> =
        leaves.enumerate().with_min_len(PARALLEL_LEAVES).map(refit_one).collect();
    refit_nodes(nodes, &of_leaves);
}

/// A node's children come after it. What nothing has moved in comes out as it was.
fn refit_nodes(nodes: &mut [WideNode], of_leaves: &[Bounds]) {
    let mut of_nodes = vec![Bounds::NOTHING; nodes.len()];
    for (at, node) in nodes.iter().enumerate().rev() {
        let lanes = node.child[..node.lanes()].iter();
        let below = lanes.map(|child| *bounds_below(*child, of_leaves, &of_nodes));
        of_nodes[at] = below.fold(Bounds::NOTHING, |all, below| all.with(&below));
    }
    nodes.par_iter_mut().with_min_len(PARALLEL_NODES).for_each(|node| {
        for lane in 0..node.lanes() {
            let below = bounds_below(node.child[lane], of_leaves, &of_nodes);
            set_box(node, lane, below);
        }
    });
}

fn bounds_below<'a>(
    child: WideChild,
    of_leaves: &'a [Bounds],
    of_nodes: &'a [Bounds],
) -> &'a Bounds {
    match child.below() {
        Below::Leaf(leaf) => &of_leaves[leaf as usize],
        Below::Node(node) => &of_nodes[node as usize],
    }
}
