//! The nearest triangles of two wide trees: branch and bound, eight boxes at a time.

mod in_64_bits;
mod leaves;
mod nodes;
mod triangles;

use super::leaf_pairs::Leaves;
use super::node::{Slot, WIDTH, WideNode};
use super::place::Place;
use crate::geometry::simd::{self, InstructionSet, Kernel, Row, SimdLevel};
use crate::tree::nearest::{Search, Waiting, descend};
use crate::tree::placement::Placement;
use in_64_bits::Slots;
use leaves::LeafStage;
use nodes::{Bounded, bound};

/// Rooms of a search, kept between queries.
#[derive(Debug, Default)]
pub struct NearestRooms {
    waiting: Vec<Entry>,
    leaves: leaves::LeafRooms,
}

/// A node to open against a box of the other tree.
#[derive(Clone, Copy, Debug)]
struct Entry {
    /// Bound of the squared distance, in squares of the fixed tree's unit.
    bound: f32,
    /// With [`MOVING`]: of the moving tree.
    node: u32,
    slot: Slot,
}

/// Nodes are numbered below this.
const MOVING: u32 = 1 << 31;

/// Gives the search every pair of triangles that is not certainly beyond its limit.
pub fn nearest(
    rooms: &mut NearestRooms,
    waiting: &mut Vec<Waiting>,
    level: SimdLevel,
    placement: &Placement,
    search: &mut Search<'_>,
) {
    let [fixed, moving] = search.trees;
    let Some(place) = Place::new(fixed, moving, search.pose) else {
        return descend(search.trees.map(Slots::of), placement, waiting, search);
    };
    let nodes = search.trees.map(|tree| tree.wide_nodes());
    let leaves = search.trees.map(Leaves::of);
    let unit_m = fixed.header().unit;
    simd::run(level, Descend { nodes, leaves, place: &place, unit_m, rooms, search });
}

struct Descend<'d, 'a> {
    nodes: [&'a [WideNode]; 2],
    leaves: [Leaves<'a>; 2],
    place: &'d Place,
    /// Of the fixed tree.
    unit_m: f64,
    rooms: &'d mut NearestRooms,
    search: &'d mut Search<'a>,
}

impl Kernel for Descend<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: InstructionSet>(self, set: S) {
        let l = set.eight();
        let Self { nodes: [fixed, moving], leaves, place, unit_m, rooms, search } = self;
        let NearestRooms { waiting, leaves: leaf_rooms } = rooms;
        let Place { into_fixed, into_moving, leaves: leaf_place } = place;
        let mut stage = LeafStage { leaves, place: leaf_place, unit_m, rooms: leaf_rooms };
        waiting.clear();
        for lane in 0..moving[0].lanes() {
            waiting.push(Entry { bound: 0.0, node: 0, slot: lane as Slot });
        }
        let mut limit = stage.limit(search);
        while let Some(Entry { bound: least, node, slot }) = waiting.pop() {
            // A negative limit ends the search.
            if least > limit {
                continue;
            }
            search.counts.boxes += WIDTH as u64;
            let is_moving = node & MOVING != 0;
            let bounded = if is_moving {
                // In squares of the moving unit.
                let scale = into_fixed.scale_squared;
                bound(l, into_moving, moving, fixed, [node & !MOVING, slot], [scale, limit])
            } else {
                bound(l, into_fixed, fixed, moving, [node, slot], [1.0, limit])
            };
            if bounded.leaves != 0 {
                stage.look(set, &bounded, is_moving, search);
                limit = stage.limit(search);
            }
            add(waiting, &bounded, node, slot, limit);
        }
    }
}

/// The nearest last.
#[inline(always)]
fn add(waiting: &mut Vec<Entry>, bounded: &Bounded<'_>, node: u32, slot: Slot, limit: f32) {
    let from = waiting.len();
    let mut lanes = bounded.again | bounded.other;
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize;
        lanes &= lanes - 1;
        let bound = bounded.bounds[lane];
        if bound > limit {
            continue;
        }
        let entry = if bounded.again >> lane & 1 != 0 {
            Entry { bound, node: bounded.children[lane].index() | node & MOVING, slot }
        } else {
            let slot = (node & !MOVING) * WIDTH as u32 + lane as u32;
            Entry { bound, node: bounded.box_child.index() | !node & MOVING, slot }
        };
        waiting.push(entry);
        let mut at = waiting.len() - 1;
        while at > from && waiting[at - 1].bound < bound {
            waiting.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// Lanes with a bit, by their bounds, the least first.
#[inline(always)]
fn in_order(bounds: &Row, mut bits: u32, order: &mut [(f32, usize); WIDTH]) -> usize {
    let mut count = 0;
    while bits != 0 {
        let lane = bits.trailing_zeros() as usize;
        bits &= bits - 1;
        let mut at = count;
        while at > 0 && order[at - 1].0 > bounds[lane] {
            order[at] = order[at - 1];
            at -= 1;
        }
        order[at] = (bounds[lane], lane);
        count += 1;
    }
    count
}
