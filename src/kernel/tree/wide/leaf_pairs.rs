//! From pairs of leaves to pairs of triangles: boxes, then triangles in 32 bits.

use super::decision::Decision;
use super::leaf_boxes::{self, Meeting};
use super::node::{LeafBox, LeafRows};
use super::outcome::{ByRank, Outcome};
use super::place::LeafPlace;
use super::queue::Queue;
use super::triangles::{Decided, Faced};
use crate::geometry::simd::{InstructionSet, Kernel, Lanes};
use crate::tree::TreeView;
use crate::tree::sink::Sink;

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

/// More leaf pairs than are added until the next round.
const ROUND_ROOM: usize = 256;

/// Rooms of a stage, kept between queries.
#[derive(Debug, Default)]
pub struct LeafRooms {
    rounds: [Round; 2],
    faced: Faced,
    outcome: Outcome,
}

pub struct LeafStage<'a, D> {
    pub rooms: &'a mut LeafRooms,
    pub place: &'a LeafPlace,
    pub fixed: Leaves<'a>,
    pub moving: Leaves<'a>,
    pub by_rank: ByRank<'a>,
    /// What the 32-bit tests are to decide.
    pub decision: D,
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

impl<D: Decision> LeafStage<'_, D> {
    pub fn clear(&mut self) {
        self.rooms.outcome.clear();
    }

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
    pub fn round<'r, K: Sink>(
        &'r mut self,
        waiting: &'r mut Queue,
        last: bool,
        sink: &'r mut K,
    ) -> impl Kernel<Output = ()> {
        WholeVectors { stage: self, waiting, last, sink }
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
        let Self { rooms, place, fixed, moving, by_rank, decision } = self;
        let pair = LeafPairs { place, fixed: *fixed, moving: *moving };
        let LeafRooms { rounds, faced, outcome } = &mut **rooms;
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
                faced.face(set, pair.rows(leaves), &now.meeting, at);
                sink.triangles(faced.count());
                let decision = *decision;
                set.part(Triangles { pair: &pair, leaves, faced, decision, outcome });
                if sink.hurry() || !outcome.has_room() {
                    outcome.settle(set, by_rank, sink);
                }
                if sink.has_enough() {
                    return;
                }
            }
        }
        outcome.settle(set, by_rank, sink);
    }
}

struct WholeVectors<'r, 'a, D, K> {
    stage: &'r mut LeafStage<'a, D>,
    waiting: &'r mut Queue,
    last: bool,
    sink: &'r mut K,
}

impl<D: Decision, K: Sink> Kernel for WholeVectors<'_, '_, D, K> {
    type Output = ();

    #[inline(always)]
    fn run<S: InstructionSet>(self, set: S) {
        let Self { stage, waiting, last, sink } = self;
        let count = waiting.waiting();
        let all = count.div_ceil(S::Most::COUNT);
        stage.work(set, waiting, if last { all } else { count / S::Most::COUNT }, sink);
        waiting.rewind(ROUND_ROOM);
    }
}

/// A stage without its rooms.
struct LeafPairs<'a> {
    place: &'a LeafPlace,
    fixed: Leaves<'a>,
    moving: Leaves<'a>,
}

impl<'a> LeafPairs<'a> {
    #[inline(always)]
    fn rows(&self, [fixed, moving]: [u32; 2]) -> [&'a LeafRows; 2] {
        [&self.fixed.rows[fixed as usize], &self.moving.rows[moving as usize]]
    }

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
    fn first_ranks(&self, [fixed, moving]: [u32; 2]) -> [u32; 2] {
        [self.fixed.boxes[fixed as usize].first, self.moving.boxes[moving as usize].first]
    }
}

/// Two leaves that face each other.
struct Triangles<'r, D> {
    pair: &'r LeafPairs<'r>,
    leaves: [u32; 2],
    faced: &'r Faced,
    decision: D,
    outcome: &'r mut Outcome,
}

impl<D: Decision> Kernel for Triangles<'_, D> {
    type Output = ();

    /// Decides what it can.
    #[inline(always)]
    fn run<S: InstructionSet>(self, set: S) {
        let Self { pair, leaves, faced, decision, outcome } = self;
        let l = set.most();
        let [a, b] = pair.rows(leaves);
        let mut from = 0;
        while from < faced.count() {
            let Decided { lanes: [i, j], meet, open } = faced.decide(l, from, decision);
            outcome.add_found(l, meet, [l.lookup_u(&a.ids, i), l.lookup_u(&b.ids, j)]);
            if open != 0 {
                let [a, b] = pair.first_ranks(leaves);
                outcome.add_open(l, open, [l.add_u(l.splat_u(a), i), l.add_u(l.splat_u(b), j)]);
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
