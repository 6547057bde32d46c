//! The wide tree: nodes of eight boxes along the mesh's axes, above leaves of up to eight triangles
//! in turned boxes. One instruction works on a whole node, and no step of the descent waits for
//! the one before it.

mod build;
mod check;
mod collapse;
mod descend;
mod in_64_bits;
mod leaf_boxes;
mod leaf_fit;
mod leaf_pairs;
mod meeting;
mod node;
mod outcome;
mod place;
mod queue;
mod top;
mod triangles;

pub use build::{BinaryNode, Bounds};
pub use check::{Root, check, check_below, check_top};
pub use descend::{Queues, Rooms};
pub use node::{Below, LeafBox, LeafRows, Part, WIDTH, WideChild, WideNode};
pub use top::grow_top;

use rayon::prelude::*;

use super::TreeView;
use super::placement::Placement;
use super::sink::{Erased, Sink};
use crate::geometry::simd::{self, SimdLevel};
use crate::geometry::{Pose, Triangle};
use build::build_binary;
use descend::Descend;
use in_64_bits::{Boxes, ToTriangles};
use leaf_pairs::{LeafStage, Leaves};
use meeting::Meeting;
use outcome::Exact;
use place::Place;

/// What lies in an image of this kind.
pub struct WideTree {
    pub nodes: Vec<WideNode>,
    pub leaf_boxes: Vec<LeafBox>,
    pub leaf_rows: Vec<LeafRows>,
}

/// Which triangle is in which leaf, before there are leaves.
pub struct Outline {
    binary: Vec<BinaryNode>,
    order: Vec<u32>,
}

impl Outline {
    pub fn of(triangles: &[Triangle]) -> Self {
        let (binary, order) = build_binary(triangles);
        Self { binary, order }
    }

    /// The triangles' numbers in the order of the leaves.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// `triangles`: the same as before.
    pub fn fill(&self, triangles: &[Triangle]) -> WideTree {
        let leaf = |node: &BinaryNode| {
            let ids = &self.order[node.first as usize..][..node.count as usize];
            leaf_fit::fit_leaf(triangles, ids, node.first)
        };
        let fit_leaves = || {
            let leaves: Vec<_> = self.binary.iter().filter(|node| node.right == 0).collect();
            leaves.into_par_iter().with_min_len(64).map(leaf).unzip()
        };
        let collapse = || collapse::collapse(&self.binary);
        let (nodes, (leaf_boxes, leaf_rows)) = rayon::join(collapse, fit_leaves);
        WideTree { nodes, leaf_boxes, leaf_rows }
    }
}

/// The nodes of eight of a binary tree, whose leaves are numbered from left to right.
pub fn collapsed(binary: &[BinaryNode]) -> Vec<WideNode> {
    collapse::collapse(binary)
}

/// Gives every intersecting pair to `sink`, or as many as it takes: of the whole trees, or below
/// pairs of lanes of theirs, of which none is below another.
pub fn descend<K: Sink>(
    rooms: &mut Rooms,
    level: SimdLevel,
    [fixed, moving]: [&TreeView<'_>; 2],
    seeds: Option<&[[Part; 2]]>,
    pose: &Pose,
    sink: &mut K,
) {
    let placement = Placement::new(fixed, moving, pose);
    let exact = Exact::new(fixed, moving, pose, placement.static_filter());
    let place = Place::new(fixed, moving, pose);
    let triangles = [fixed.triangle_count(), moving.triangle_count()];
    let (fixed_leaves, moving_leaves) = (Leaves::of(fixed), Leaves::of(moving));
    let (fixed, moving) = (fixed.wide_nodes(), moving.wide_nodes());
    let whole = [[whole(fixed), whole(moving)]];
    let seeds = seeds.unwrap_or(&whole);
    match place {
        Some(place) => {
            let Rooms { queues, leaves } = rooms;
            let stage = LeafStage {
                rooms: leaves,
                place: &place.leaves,
                fixed: fixed_leaves,
                moving: moving_leaves,
                exact,
            };
            let place = &place;
            let descend = Descend { fixed, moving, place, seeds, queues, stage, sink };
            if let Err(descend) = simd::run_vectors(level, descend) {
                let Descend { fixed, moving, place, seeds, queues, stage, sink } = descend;
                let sink = &mut Erased(sink);
                simd::run_portable(Descend { fixed, moving, place, seeds, queues, stage, sink });
            }
        }
        None => Boxes { fixed, moving, placement }.descend(
            seeds,
            &mut ToTriangles { fixed: fixed_leaves, moving: moving_leaves, triangles, exact, sink },
        ),
    }
}

/// Appends the pairs of leaves whose boxes meet. `tops` are in the frames of `trees`, and their
/// leaves stand for anything.
pub fn meeting_leaves(
    queues: &mut Queues,
    level: SimdLevel,
    [fixed, moving]: [&[WideNode]; 2],
    trees: [&TreeView<'_>; 2],
    pose: &Pose,
    pairs: &mut Vec<[u32; 2]>,
) {
    match Place::new(trees[0], trees[1], pose) {
        Some(place) => {
            simd::run(level, Meeting { fixed, moving, place: &place, queues, pairs });
        }
        None => {
            let placement = Placement::new(trees[0], trees[1], pose);
            Boxes { fixed, moving, placement }.descend(&[[whole(fixed), whole(moving)]], pairs);
        }
    }
}

fn whole(nodes: &[WideNode]) -> Part {
    Part::new(0, nodes[0].lanes() as u32)
}
