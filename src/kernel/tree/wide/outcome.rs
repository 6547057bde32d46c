//! What the 32-bit tests make of pairs of triangles: those that are certain are handed on, those
//! that are left open are tested one by one. Both wait, so that no step of the 32-bit tests depends
//! on how many there are, and what the other tests read is there when they come.

use super::node::WIDTH;
use super::queue::Queue;
use crate::geometry::simd::{InstructionSet, Lanes};
use crate::geometry::triangle_test::PreparedTest;
use crate::geometry::{Point, Pose, Triangle};
use crate::tree::descent::Pair;
use crate::tree::sink::Sink;
use crate::tree::{LeafTriangle, TreeView};

/// Triangles by rank, in 64 bits as the contract has it.
#[derive(Clone, Copy)]
pub struct ByRank<'a> {
    fixed: Corners<'a>,
    moving: Corners<'a>,
    pose: &'a Pose,
    test: PreparedTest<'a>,
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

    #[inline(always)]
    fn prefetch_numbers<S: InstructionSet>(&self, set: S, rank: u32) {
        set.prefetch(self.triangles.as_ptr().wrapping_add(rank as usize));
    }

    #[inline(always)]
    fn prefetch_corners<S: InstructionSet>(&self, set: S, rank: u32) {
        for vertex in self.triangles[rank as usize].vertices {
            set.prefetch(self.vertices.as_ptr().wrapping_add(vertex as usize));
        }
    }
}

impl<'a> ByRank<'a> {
    pub fn new(
        fixed: &TreeView<'a>,
        moving: &TreeView<'a>,
        pose: &'a Pose,
        test: PreparedTest<'a>,
    ) -> Self {
        let corners = |tree: &TreeView<'a>| Corners {
            triangles: tree.triangles(),
            vertices: tree.vertices(),
        };
        Self { fixed: corners(fixed), moving: corners(moving), pose, test }
    }

    /// By ranks. Never inlined: here nothing may be fused or reordered.
    #[inline(never)]
    pub fn intersect(&self, fixed: u32, moving: u32) -> bool {
        let [a, b, c] = self.moving.of(moving);
        let placed = [self.pose.apply(a), self.pose.apply(b), self.pose.apply(c)];
        self.test.intersect(&self.fixed.of(fixed), &placed)
    }

    fn numbers_in_files(&self, fixed: u32, moving: u32) -> Pair {
        [self.fixed.triangles[fixed as usize].id, self.moving.triangles[moving as usize].id]
    }
}

/// Rooms for what waits, kept between queries.
#[derive(Debug, Default)]
pub struct Outcome {
    /// Certain pairs, by the triangles' numbers in the files.
    found: Queue,
    /// Pairs left open, by ranks.
    open: Queue,
}

impl Outcome {
    pub fn clear(&mut self) {
        self.found.clear();
        self.open.clear();
    }

    /// Whether there is room for all pairs of two leaves.
    #[inline(always)]
    pub fn has_room(&self) -> bool {
        let more = WIDTH * WIDTH;
        self.found.has_room(more) && self.open.has_room(more)
    }

    /// Adds certain pairs, the lanes whose bit is set.
    #[inline(always)]
    pub fn add_found<L: Lanes>(&mut self, l: L, bits: u32, [fixed, moving]: [L::U; 2]) {
        self.found.extend(l, bits, l.compress(bits, fixed), l.compress(bits, moving));
    }

    /// Adds pairs left open, the lanes whose bit is set.
    #[inline(always)]
    pub fn add_open<L: Lanes>(&mut self, l: L, bits: u32, [fixed, moving]: [L::U; 2]) {
        self.open.extend(l, bits, l.compress(bits, fixed), l.compress(bits, moving));
    }

    /// Gives to `sink` all that was found, or as much as it takes.
    #[inline(always)]
    pub fn settle<S: InstructionSet, K: Sink>(
        &mut self,
        set: S,
        triangles: &ByRank<'_>,
        sink: &mut K,
    ) {
        sink.take_all(self.found.entries());
        self.found.clear();
        if !sink.has_enough() {
            sink.exact(self.open.waiting());
            self.test_open(set, triangles, sink);
        }
        self.open.clear();
    }

    #[inline(always)]
    fn test_open<S: InstructionSet, K: Sink>(&self, set: S, triangles: &ByRank<'_>, sink: &mut K) {
        for [fixed, moving] in self.open.entries() {
            triangles.fixed.prefetch_numbers(set, fixed);
            triangles.moving.prefetch_numbers(set, moving);
        }
        for [fixed, moving] in self.open.entries() {
            triangles.fixed.prefetch_corners(set, fixed);
            triangles.moving.prefetch_corners(set, moving);
        }
        for [fixed, moving] in self.open.entries() {
            if triangles.intersect(fixed, moving) {
                sink.take(triangles.numbers_in_files(fixed, moving));
                if sink.has_enough() {
                    return;
                }
            }
        }
    }
}
