//! The wide tree: nodes of eight boxes along the mesh's axes, above leaves of up to eight triangles
//! in turned boxes. One instruction works on a whole node, and no step of the descent waits for
//! the one before it.

mod build;
mod check;
mod collapse;
mod decision;
mod descend;
mod face_value;
mod in_64_bits;
mod leaf_boxes;
mod leaf_fit;
mod leaf_pairs;
mod meeting;
mod nearest;
mod node;
mod outcome;
mod place;
mod queue;
mod refit;
mod top;
mod triangles;

pub use build::{BinaryNode, Bounds};
pub use check::{Root, check, check_below, check_top};
pub use descend::{Queues, Rooms};
pub use nearest::{NearestRooms, nearest};
pub use node::{Below, LeafBox, LeafRows, Part, WIDTH, WideChild, WideNode};
pub use refit::refit;
pub use top::grow_top;

use rayon::prelude::*;

use super::TreeView;
use super::placement::Placement;
use super::sink::{All, Any, Erased, Gathered, Sink};
use crate::geometry::simd::{self, SimdLevel};
use crate::geometry::triangle_test::PreparedTest;
use crate::geometry::{Pose, Triangle, TriangleTest};
use build::build_binary;
use decision::{Chosen, Decision, OnlyCertain};
use descend::Descend;
use in_64_bits::{Boxes, LeafPairsOnly, ToTriangles};
use leaf_pairs::{LeafRooms, LeafStage, Leaves};
use meeting::Meeting;
use outcome::ByRank;
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

/// A sink that a kernel of its own is compiled for.
pub trait WideSink: Sink {
    /// Of what it does where only what is certain is to be decided.
    type Decision: Decision + Into<Chosen>;
}

impl WideSink for All<'_> {
    type Decision = OnlyCertain;
}

impl WideSink for Any {
    type Decision = OnlyCertain;
}

/// The kernel of the other levels of accuracy.
impl WideSink for Gathered<'_> {
    type Decision = Chosen;
}

/// A question about two wide trees.
pub struct Query<'a, 'q> {
    pub trees: [&'q TreeView<'a>; 2],
    /// Pairs of lanes to start below, of which none is below another; absent: the whole trees.
    pub seeds: Option<&'q [[Part; 2]]>,
    pub pose: &'q Pose,
    pub placement: &'q Placement,
    pub test: TriangleTest,
    pub prepared: PreparedTest<'q>,
}

/// Gives every pair that the test finds to `sink`, or as many as it takes.
pub fn descend<K: WideSink>(
    rooms: &mut Rooms,
    level: SimdLevel,
    query: &Query<'_, '_>,
    sink: &mut K,
) {
    let [fixed, moving] = query.trees;
    let by_rank = ByRank::new(fixed, moving, query.pose, query.prepared);
    let leaves = query.trees.map(Leaves::of);
    let nodes = query.trees.map(|tree| tree.wide_nodes());
    let whole = [nodes.map(whole)];
    let seeds = query.seeds.unwrap_or(&whole);
    let Some(place) = Place::new(fixed, moving, query.pose) else {
        let [fixed_nodes, moving_nodes] = nodes;
        let boxes =
            Boxes { fixed: fixed_nodes, moving: moving_nodes, placement: query.placement.clone() };
        let [fixed_leaves, moving_leaves] = leaves;
        let triangles = query.trees.map(TreeView::triangle_count);
        let mut to =
            ToTriangles { fixed: fixed_leaves, moving: moving_leaves, triangles, by_rank, sink };
        return boxes.descend(seeds, &mut to);
    };
    let descent = Descent32 { level, nodes, leaves, place: &place, seeds, by_rank };
    match Chosen::of(query.test, query.placement) {
        Chosen::OnlyCertain => descent.run(rooms, K::Decision::CERTAIN, sink),
        // One kernel for all sinks.
        other => Gathered::for_sink(sink, |gathered| descent.run(rooms, other, gathered)),
    }
}

/// All of a descent but what it keeps and whom it tells.
struct Descent32<'a> {
    level: SimdLevel,
    nodes: [&'a [WideNode]; 2],
    leaves: [Leaves<'a>; 2],
    place: &'a Place,
    seeds: &'a [[Part; 2]],
    by_rank: ByRank<'a>,
}

impl Descent32<'_> {
    fn run<K: Sink>(
        &self,
        rooms: &mut Rooms,
        decision: impl Decision + Into<Chosen>,
        sink: &mut K,
    ) {
        let erased = decision.into();
        if let Err(kernel) = simd::run_vectors(self.level, self.kernel(rooms, decision, sink)) {
            let Descend { queues, stage, sink, .. } = kernel;
            let sink = &mut Erased(sink);
            simd::run_portable(self.kernel_in(queues, stage.rooms, erased, sink));
        }
    }

    fn kernel<'k, K, D>(
        &'k self,
        rooms: &'k mut Rooms,
        decision: D,
        sink: &'k mut K,
    ) -> Descend<'k, K, D> {
        self.kernel_in(&mut rooms.queues, &mut rooms.leaves, decision, sink)
    }

    fn kernel_in<'k, K, D>(
        &'k self,
        queues: &'k mut Queues,
        rooms: &'k mut LeafRooms,
        decision: D,
        sink: &'k mut K,
    ) -> Descend<'k, K, D> {
        let &Self { nodes: [fixed, moving], leaves, place, seeds, by_rank, .. } = self;
        let [fixed_leaves, moving_leaves] = leaves;
        let stage = LeafStage {
            rooms,
            place: &place.leaves,
            fixed: fixed_leaves,
            moving: moving_leaves,
            by_rank,
            decision,
        };
        Descend { fixed, moving, place, seeds, queues, stage, sink }
    }
}

/// Appends the pairs of leaves whose boxes meet; how many pairs of boxes were tested for that. `tops` are in the frames of `trees`, and their
/// leaves stand for anything.
pub fn meeting_leaves(
    queues: &mut Queues,
    level: SimdLevel,
    [fixed, moving]: [&[WideNode]; 2],
    trees: [&TreeView<'_>; 2],
    pose: &Pose,
    pairs: &mut Vec<[u32; 2]>,
) -> u64 {
    match Place::new(trees[0], trees[1], pose) {
        Some(place) => simd::run(level, Meeting { fixed, moving, place: &place, queues, pairs }),
        None => {
            let placement = Placement::new(trees[0], trees[1], pose);
            let mut to = LeafPairsOnly { pairs, tests: 0 };
            Boxes { fixed, moving, placement }.descend(&[[whole(fixed), whole(moving)]], &mut to);
            to.tests
        }
    }
}

fn whole(nodes: &[WideNode]) -> Part {
    Part::new(0, nodes[0].lanes() as u32)
}
