//! From pairs of leaves to pairs of triangles: boxes, then triangles in 32 bits, then what these
//! leave open, exactly.

use super::leaf_boxes::{self, Meeting};
use super::node::{LeafBox, LeafRows};
use super::place::LeafPlace;
use super::queue::Queue;
use super::triangles::Faced;
use crate::geometry::simd::{InstructionSet, Lanes};
use crate::geometry::triangle::{StaticFilter, triangles_intersect};
use crate::geometry::{Point, Pose, Triangle};
use crate::tree::sink::Sink;
use crate::tree::{LeafTriangle, TreeView};

/// Leaves of one tree.
#[derive(Clone, Copy)]
pub struct Leaves<'a> {
    pub boxes: &'a [LeafBox],
    pub rows: &'a [LeafRows],
}

impl<'a> Leaves<'a> {
    pub fn of(tree: &TreeView<'a>) -> Self {
        Self { boxes: tree.leaf_boxes(), rows: tree.leaf_rows() }
    }
}

/// Triangles by rank, in 64 bits as the contract has it.
#[derive(Clone, Copy)]
pub struct Exact<'a> {
    fixed: Corners<'a>,
    moving: Corners<'a>,
    pose: &'a Pose,
    filter: StaticFilter,
}

#[derive(Clone, Copy)]
struct Corners<'a> {
    triangles: &'a [LeafTriangle],
    vertices: &'a [Point],
}

impl Corners<'_> {
    #[inline(always)]
    fn of(&self, rank: u32) -> Triangle {
        let [a, b, c] = self.triangles[rank as usize].vertices;
        [self.vertices[a as usize], self.vertices[b as usize], self.vertices[c as usize]]
    }
}

impl<'a> Exact<'a> {
    pub fn new(
        fixed: &TreeView<'a>,
        moving: &TreeView<'a>,
        pose: &'a Pose,
        filter: StaticFilter,
    ) -> Self {
        let corners = |tree: &TreeView<'a>| Corners {
            triangles: tree.triangles(),
            vertices: tree.vertices(),
        };
        Self { fixed: corners(fixed), moving: corners(moving), pose, filter }
    }

    /// By ranks. Never inlined: here nothing may be fused or reordered.
    #[inline(never)]
    pub fn intersect(&self, fixed: u32, moving: u32) -> bool {
        let [a, b, c] = self.moving.of(moving);
        let placed = [self.pose.apply(a), self.pose.apply(b), self.pose.apply(c)];
        triangles_intersect(&self.fixed.of(fixed), &placed, &self.filter)
    }
}

/// More leaf pairs than are added until the next round.
const ROUND_ROOM: usize = 256;

/// Rooms of a stage, kept between queries.
#[derive(Debug, Default)]
pub struct LeafRooms {
    rounds: [Round; 2],
    faced: Faced,
}

pub struct LeafStage<'a> {
    pub rooms: &'a mut LeafRooms,
    pub place: &'a LeafPlace,
    pub fixed: Leaves<'a>,
    pub moving: Leaves<'a>,
    pub exact: Exact<'a>,
}

/// Leaf pairs tested side by side, and which of them meet.
#[derive(Debug)]
struct Round {
    fixed: [u32; 16],
    moving: [u32; 16],
    meeting: Meeting,
    meet: u32,
}

impl Default for Round {
    fn default() -> Self {
        Self { fixed: [0; 16], moving: [0; 16], meeting: Meeting::NONE, meet: 0 }
    }
}

impl LeafStage<'_> {
    /// Fetches the boxes of the pairs that were added last.
    #[inline(always)]
    pub fn expect<S: InstructionSet>(&self, set: S, waiting: &Queue, added: usize) {
        let from = waiting.waiting() - added;
        for (&a, &b) in waiting.firsts()[from..].iter().zip(&waiting.seconds()[from..]) {
            set.prefetch(self.fixed.boxes.as_ptr().wrapping_add(a as usize));
            set.prefetch(self.moving.boxes.as_ptr().wrapping_add(b as usize));
        }
    }

    /// Works on what waits in whole vectors, and at last on all.
    #[inline(always)]
    pub fn round<S: InstructionSet, K: Sink>(
        &mut self,
        set: S,
        waiting: &mut Queue,
        last: bool,
        sink: &mut K,
    ) {
        let count = waiting.waiting();
        let all = count.div_ceil(S::Most::COUNT);
        self.work(set, waiting, if last { all } else { count / S::Most::COUNT }, sink);
        waiting.rewind(ROUND_ROOM);
    }

    /// The triangles of one vector are fetched while the boxes of the next are tested.
    #[inline(always)]
    fn work<S: InstructionSet, K: Sink>(
        &mut self,
        set: S,
        waiting: &mut Queue,
        vectors: usize,
        sink: &mut K,
    ) {
        let Self { rooms, place, fixed, moving, exact } = self;
        let pair = LeafPairs { place, fixed: *fixed, moving: *moving, exact: *exact };
        let LeafRooms { rounds, faced } = &mut **rooms;
        rounds[0].meet = 0;
        for vector in 0..=vectors {
            let [even, odd] = &mut *rounds;
            let (now, next) = if vector % 2 == 0 { (even, odd) } else { (odd, even) };
            if vector < vectors {
                sink.boxes(waiting.waiting().min(S::Most::COUNT));
                pair.boxes(set, waiting, next);
            } else {
                next.meet = 0;
            }
            let mut meet = now.meet;
            while meet != 0 {
                let at = meet.trailing_zeros() as usize;
                meet &= meet - 1;
                let leaves = [now.fixed[at], now.moving[at]];
                pair.triangles(set, faced, leaves, &now.meeting, at, sink);
                if sink.has_enough() {
                    return;
                }
            }
        }
    }
}

/// A stage without its rooms.
struct LeafPairs<'a> {
    place: &'a LeafPlace,
    fixed: Leaves<'a>,
    moving: Leaves<'a>,
    exact: Exact<'a>,
}

impl LeafPairs<'_> {
    #[inline(always)]
    fn boxes<S: InstructionSet>(&self, set: S, waiting: &mut Queue, round: &mut Round) {
        let l = set.most();
        let count = waiting.waiting().min(S::Most::COUNT);
        let mut fixed = [leaf_boxes::words(&self.fixed.boxes[0]); 16];
        let mut moving = [leaf_boxes::words(&self.moving.boxes[0]); 16];
        for i in 0..S::Most::COUNT {
            // What is left over of the vector repeats the last pair.
            let at = i.min(count - 1);
            // SAFETY: less wait than `count`, and they are leaves of the trees that the view has
            // checked.
            unsafe {
                round.fixed[i] = *waiting.firsts().get_unchecked(at);
                round.moving[i] = *waiting.seconds().get_unchecked(at);
                let boxes = self.fixed.boxes;
                fixed[i] = leaf_boxes::words(boxes.get_unchecked(round.fixed[i] as usize));
                let boxes = self.moving.boxes;
                moving[i] = leaf_boxes::words(boxes.get_unchecked(round.moving[i] as usize));
            }
        }
        waiting.skip(count);
        let bits = leaf_boxes::meet(l, self.place, &fixed, &moving, &mut round.meeting);
        round.meet = bits & ((1_u64 << count) - 1) as u32;
        let mut meet = round.meet;
        while meet != 0 {
            let at = meet.trailing_zeros() as usize;
            meet &= meet - 1;
            prefetch_rows(set, &self.fixed.rows[round.fixed[at] as usize]);
            prefetch_rows(set, &self.moving.rows[round.moving[at] as usize]);
        }
    }

    #[inline(always)]
    fn triangles<S: InstructionSet, K: Sink>(
        &self,
        set: S,
        faced: &mut Faced,
        [fixed, moving]: [u32; 2],
        meeting: &Meeting,
        at: usize,
        sink: &mut K,
    ) {
        let (a, b) = (&self.fixed.rows[fixed as usize], &self.moving.rows[moving as usize]);
        faced.face(set, a, b, meeting, at);
        sink.triangles(faced.count());
        let mut from = 0;
        while from < faced.count() {
            let decided = faced.decide(set.most(), from);
            let mut bits = decided.meet;
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let [i, j] = S::Most::pair(faced.code(from + lane));
                sink.take([a.ids[i], b.ids[j]]);
            }
            sink.exact(decided.open.count_ones() as usize);
            let mut bits = decided.open;
            while bits != 0 {
                let lane = bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let [i, j] = S::Most::pair(faced.code(from + lane));
                let first = |boxes: &[LeafBox], leaf: u32| boxes[leaf as usize].first;
                let rank_a = first(self.fixed.boxes, fixed) + i as u32;
                let rank_b = first(self.moving.boxes, moving) + j as u32;
                if self.exact.intersect(rank_a, rank_b) {
                    sink.take([a.ids[i], b.ids[j]]);
                }
            }
            from += S::Most::COUNT;
        }
    }
}

#[inline(always)]
fn prefetch_rows<S: InstructionSet>(set: S, rows: &LeafRows) {
    let start: *const u8 = std::ptr::from_ref(rows).cast();
    for line in 0..5 {
        set.prefetch(start.wrapping_add(64 * line));
    }
}
