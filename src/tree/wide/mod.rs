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
mod node;
mod place;
mod queue;
mod top;
mod triangles;

pub use check::check;
pub use descend::Rooms;
pub use node::{LeafBox, LeafRows, WideNode};
pub use top::{TopLeaf, top_of};

use rayon::prelude::*;

use super::TreeView;
use super::placement::Placement;
use super::sink::Sink;
use crate::geometry::simd::{self, SimdLevel};
use crate::geometry::{Pose, Triangle};
use descend::Descend;
use leaf_pairs::{Exact, LeafStage, Leaves};
use place::Place;

/// What lies in an image of this kind, and the triangles' numbers in the order of the leaves.
pub struct WideTree {
    pub nodes: Vec<WideNode>,
    pub leaf_boxes: Vec<LeafBox>,
    pub leaf_rows: Vec<LeafRows>,
    pub order: Vec<u32>,
}

pub fn build(triangles: &[Triangle]) -> WideTree {
    let (binary, order) = build::build_binary(triangles);
    let collapse::Collapsed { nodes, leaves } = collapse::collapse(&binary);
    let (leaf_boxes, leaf_rows) = leaves
        .par_iter()
        .with_min_len(64)
        .map(|range| {
            let ids = &order[range.start as usize..range.end as usize];
            leaf_fit::fit_leaf(triangles, ids, range.start)
        })
        .unzip();
    WideTree { nodes, leaf_boxes, leaf_rows, order }
}

/// Gives every intersecting pair to `sink`, or as many as it takes.
pub fn descend<K: Sink>(
    rooms: &mut Rooms,
    level: SimdLevel,
    [fixed, moving]: [&TreeView<'_>; 2],
    pose: &Pose,
    sink: &mut K,
) {
    let placement = Placement::new(fixed, moving, pose);
    let exact = Exact::new(fixed, moving, pose, placement.static_filter());
    let place = Place::new(fixed, moving, pose);
    let triangles = [fixed.triangle_count(), moving.triangle_count()];
    let (fixed_leaves, moving_leaves) = (Leaves::of(fixed), Leaves::of(moving));
    let (fixed, moving) = (fixed.wide_nodes(), moving.wide_nodes());
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
            simd::run(level, Descend { fixed, moving, place: &place, queues, stage, sink });
        }
        None => {
            in_64_bits::Trees {
                fixed,
                moving,
                fixed_leaves,
                moving_leaves,
                triangles,
                exact,
                placement,
            }
            .descend(sink);
        }
    }
}
