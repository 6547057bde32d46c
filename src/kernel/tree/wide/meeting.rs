//! Leaves of two wide trees whose boxes meet, and no more than that.

use super::descend::{Queues, open};
use super::node::{Slot, WIDTH, WideNode};
use super::place::Place;
use super::queue::Queue;
use crate::geometry::simd::{InstructionSet, Kernel, Lanes};

/// For trees that are small: nothing is fetched ahead.
pub struct Meeting<'a> {
    pub fixed: &'a [WideNode],
    pub moving: &'a [WideNode],
    pub place: &'a Place,
    pub queues: &'a mut Queues,
    pub pairs: &'a mut Vec<[u32; 2]>,
}

/// Of an entry that waits: its node is one of the moving tree. Nodes are numbered below this.
const MOVING: u32 = 1 << 31;

impl Kernel for Meeting<'_> {
    /// Pairs of boxes tested.
    type Output = u64;

    #[inline(always)]
    fn run<S: InstructionSet>(self, set: S) -> u64 {
        let l = set.eight();
        let Self { fixed, moving, place, queues, pairs } = self;
        let Queues { fixed: stack, leaves, .. } = queues;
        stack.clear();
        leaves.clear();
        for lane in 0..moving[0].lanes() {
            stack.push([0, lane as Slot]);
        }
        let mut tests = 0;
        // What came last is opened first, so that what waits grows with the depth of the trees.
        while stack.waiting() > 0 {
            assert!(stack.has_room(2 * WIDTH), "no tree is as deep above its roots");
            if !leaves.has_room(WIDTH) {
                flush(leaves, pairs);
            }
            let [node, slot] = stack.take(true);
            tests += WIDTH as u64;
            if node & MOVING == 0 {
                let opened = open(l, &place.into_fixed, fixed, moving, [node, slot]);
                stack.extend(l, opened.again, opened.children_again(l), opened.slot);
                let other = l.add_u(opened.box_child, l.splat_u(MOVING));
                stack.extend(l, opened.other, other, opened.slots_other(l));
                leaves.extend(l, opened.leaves, opened.leaf_children(l), opened.box_child);
            } else {
                let opened = open(l, &place.into_moving, moving, fixed, [node & !MOVING, slot]);
                let again = l.add_u(opened.children_again(l), l.splat_u(MOVING));
                stack.extend(l, opened.again, again, opened.slot);
                stack.extend(l, opened.other, opened.box_child, opened.slots_other(l));
                leaves.extend(l, opened.leaves, opened.box_child, opened.leaf_children(l));
            }
        }
        flush(leaves, pairs);
        tests
    }
}

fn flush(leaves: &mut Queue, pairs: &mut Vec<[u32; 2]>) {
    pairs.extend(leaves.firsts().iter().zip(leaves.seconds()).map(|(&a, &b)| [a, b]));
    leaves.clear();
}
