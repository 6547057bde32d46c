//! Simultaneous descent of two wide trees: nodes that wait are opened in the order in which they
//! came, so that there is time to fetch them; pairs of leaves are taken together.

use super::decision::Decision;
use super::leaf_pairs::{LeafRooms, LeafStage};
use super::node::{Part, Slot, WIDTH, WideChild, WideNode};
use super::place::{Place, Way};
use super::queue::Queue;
use crate::geometry::simd::{InstructionSet, Kernel, Lanes, Row, three};
use crate::tree::sink::Sink;

/// Nodes fetched ahead of their turn.
const AHEAD: usize = 4;

/// Leaf pairs that are worth a round of tests.
const ROUND: usize = 64;

/// Rooms of a descent, kept between queries.
#[derive(Debug, Default)]
pub struct Queues {
    /// (node of the fixed tree to open, slot of the moving tree)
    pub fixed: Queue,
    /// (node of the moving tree to open, slot of the fixed tree)
    moving: Queue,
    /// (leaf of the fixed tree, leaf of the moving tree)
    pub leaves: Queue,
}

/// All that a descent keeps between queries.
#[derive(Debug, Default)]
pub struct Rooms {
    pub queues: Queues,
    pub leaves: LeafRooms,
}

pub struct Descend<'a, K, D> {
    pub fixed: &'a [WideNode],
    pub moving: &'a [WideNode],
    pub place: &'a Place,
    /// What to start from.
    pub seeds: &'a [[Part; 2]],
    pub queues: &'a mut Queues,
    pub stage: LeafStage<'a, D>,
    pub sink: &'a mut K,
}

impl<K: Sink, D: Decision> Kernel for Descend<'_, K, D> {
    type Output = ();

    #[inline(always)]
    fn run<S: InstructionSet>(mut self, set: S) {
        self.queues.fixed.clear();
        self.queues.moving.clear();
        self.queues.leaves.clear();
        self.stage.clear();
        for &[fixed, moving] in self.seeds {
            for lane in moving.lanes() {
                self.seed(set, fixed, moving.slot(lane));
            }
        }
        self.drain(set);
    }
}

/// What waited when the room ran out.
struct Postponed {
    fixed: Vec<[u32; 2]>,
    moving: Vec<[u32; 2]>,
}

impl<K: Sink, D: Decision> Descend<'_, K, D> {
    /// Some lanes of a fixed node against a box of the moving tree.
    #[inline(always)]
    fn seed<S: InstructionSet>(&mut self, set: S, part: Part, slot: Slot) {
        let room = [&mut self.queues.fixed, &mut self.queues.moving].map(|q| q.make_room(WIDTH));
        if room != [true; 2] || self.queues.leaves.waiting() >= ROUND {
            self.drain(set);
        }
        let Self { fixed, moving, place, queues, stage, sink, .. } = self;
        let Queues { fixed: to_fixed, moving: to_moving, leaves } = &mut **queues;
        if part.is_whole(&fixed[part.node as usize]) {
            return to_fixed.push([part.node, slot]);
        }
        let lanes = set.eight();
        sink.boxes(WIDTH);
        let mut opened = open(lanes, &place.into_fixed, fixed, moving, [part.node, slot]);
        opened.keep(part.bits);
        opened.extend(lanes, to_fixed, to_moving);
        leaves.extend(lanes, opened.leaves, opened.leaf_children(lanes), opened.box_child);
        stage.expect(set, leaves, opened.leaves.count_ones() as usize);
    }

    /// Works until nothing waits, or the sink has enough.
    ///
    /// When the room runs out, which takes meshes that overlap nearly everywhere, all that waits
    /// is put aside and done one by one: each time there is more room below, and what is aside
    /// grows with the depth of the trees, not with the number of pairs.
    #[inline(always)]
    fn drain<S: InstructionSet>(&mut self, set: S) {
        let mut postponed: Vec<Postponed> = Vec::new();
        loop {
            let full = set.part(Work(&mut *self));
            if self.sink.has_enough() {
                return;
            }
            if full {
                postponed.push(self.queues.postpone());
            }
            loop {
                let Some(last) = postponed.last_mut() else { return };
                if let Some(entry) = last.fixed.pop() {
                    self.queues.fixed.push(entry);
                    break;
                }
                if let Some(entry) = last.moving.pop() {
                    self.queues.moving.push(entry);
                    break;
                }
                postponed.pop();
            }
        }
    }
}

/// Until nothing waits, the sink has enough, or the room runs out.
struct Work<'w, 'a, K, D>(&'w mut Descend<'a, K, D>);

impl<K: Sink, D: Decision> Kernel for Work<'_, '_, K, D> {
    /// Whether it stopped because the room ran out.
    type Output = bool;

    #[inline(always)]
    fn run<S: InstructionSet>(self, set: S) -> bool {
        let lanes = set.eight();
        let Descend { fixed, moving, place, queues, stage, sink, .. } = self.0;
        let Queues { fixed: to_fixed, moving: to_moving, leaves } = &mut **queues;
        let hurry = sink.hurry();
        let enough = if hurry { S::Most::COUNT } else { ROUND };
        loop {
            while to_fixed.waiting() > 0 && leaves.waiting() < enough {
                if !(to_fixed.make_room(WIDTH) && to_moving.make_room(WIDTH)) {
                    return true;
                }
                sink.boxes(WIDTH);
                prefetch_node(set, fixed, to_fixed.glance(AHEAD) as usize);
                let opened = open(lanes, &place.into_fixed, fixed, moving, to_fixed.take(hurry));
                opened.extend(lanes, to_fixed, to_moving);
                leaves.extend(lanes, opened.leaves, opened.leaf_children(lanes), opened.box_child);
                stage.expect(set, leaves, opened.leaves.count_ones() as usize);
            }
            while to_moving.waiting() > 0 && leaves.waiting() < enough {
                if !(to_fixed.make_room(WIDTH) && to_moving.make_room(WIDTH)) {
                    return true;
                }
                sink.boxes(WIDTH);
                prefetch_node(set, moving, to_moving.glance(AHEAD) as usize);
                let opened = open(lanes, &place.into_moving, moving, fixed, to_moving.take(hurry));
                opened.extend(lanes, to_moving, to_fixed);
                leaves.extend(lanes, opened.leaves, opened.box_child, opened.leaf_children(lanes));
                stage.expect(set, leaves, opened.leaves.count_ones() as usize);
            }
            let last = to_fixed.waiting() == 0 && to_moving.waiting() == 0;
            if last || leaves.waiting() >= enough {
                set.part(stage.round(leaves, last, *sink));
                if last || sink.has_enough() {
                    return false;
                }
            }
        }
    }
}

impl Queues {
    #[cold]
    fn postpone(&mut self) -> Postponed {
        let all = |queue: &mut Queue| {
            let mut entries = Vec::with_capacity(queue.waiting());
            while queue.waiting() > 0 {
                entries.push(queue.take(false));
            }
            entries
        };
        Postponed { fixed: all(&mut self.fixed), moving: all(&mut self.moving) }
    }
}

#[inline(always)]
fn prefetch_node<S: InstructionSet>(set: S, nodes: &[WideNode], at: usize) {
    let start: *const u8 = nodes.as_ptr().wrapping_add(at).cast();
    for line in 0..4 {
        set.prefetch(start.wrapping_add(64 * line));
    }
}

/// Of the children of an opened node X that meet the box Y: bits by what comes next.
pub struct Opened<L: Lanes> {
    /// Those to open against the same box.
    pub again: u32,
    /// Those against which the box is to be opened.
    pub other: u32,
    /// Leaves that meet a leaf.
    pub leaves: u32,
    children: L::U,
    slots: L::U,
    pub slot: L::U,
    pub box_child: L::U,
}

#[inline(always)]
pub fn open<L: Lanes>(
    l: L,
    way: &Way,
    nodes: &[WideNode],
    others: &[WideNode],
    [node, slot]: [u32; 2],
) -> Opened<L> {
    let x = &nodes[node as usize];
    let (y, lane) = (&others[slot as usize / WIDTH], slot as usize % WIDTH);
    let met = l.bits(meet(l, way, x, y, lane));
    let children: &[u32; WIDTH] = bytemuck::cast_ref(&x.child);
    let children = l.load_u(children);
    let area = l.splat(y.area[lane] * way.scale_squared);
    let larger = l.bits(l.le(area, l.load(&x.area)));
    let leaf = l.top_bits(children);
    let box_child = y.child[lane];
    // A leaf is not opened: a mask of all lanes, or of none.
    let box_is_leaf = 0_u32.wrapping_sub(u32::from(box_child.is_leaf()));
    let again = met & !leaf & (larger | box_is_leaf);
    let leaves = met & leaf & box_is_leaf;
    Opened {
        again,
        other: met & !(again | leaves),
        leaves,
        children: l.and_u(children, l.splat_u(WideChild::INDEX)),
        slots: l.add_u(l.load_u(&LANE_NUMBERS), l.splat_u(node * WIDTH as u32)),
        slot: l.splat_u(slot),
        box_child: l.splat_u(box_child.index()),
    }
}

impl<L: Lanes> Opened<L> {
    #[inline(always)]
    fn extend(&self, l: L, same: &mut Queue, other: &mut Queue) {
        same.extend(l, self.again, self.children_again(l), self.slot);
        other.extend(l, self.other, self.box_child, self.slots_other(l));
    }

    /// Only the lanes whose bit is set.
    #[inline(always)]
    fn keep(&mut self, bits: u32) {
        self.again &= bits;
        self.other &= bits;
        self.leaves &= bits;
    }

    #[inline(always)]
    pub fn children_again(&self, l: L) -> L::U {
        l.compress(self.again, self.children)
    }

    #[inline(always)]
    pub fn slots_other(&self, l: L) -> L::U {
        l.compress(self.other, self.slots)
    }

    #[inline(always)]
    pub fn leaf_children(&self, l: L) -> L::U {
        l.compress(self.leaves, self.children)
    }
}

const LANE_NUMBERS: [u32; WIDTH] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Which children of `x` meet lane `lane` of `y`, on the three axes of each: [`Way`] has the
/// bound. Products of axes separate too few boxes to pay.
#[inline(always)]
fn meet<L: Lanes>(l: L, way: &Way, x: &WideNode, y: &WideNode, lane: usize) -> L::M {
    let slack = l.splat(way.slack);
    let center = three!(k => l.splat(y.center[k][lane]));
    let half = three!(k => l.splat(y.half[k][lane]));
    let halves = three!(k => l.load(&x.half[k]));
    let distance = three!(j => {
        let at = row_times(l, &way.matrix[j], &center, l.load(&way.offset[j]));
        l.sub(at, l.load(&x.center[j]))
    });
    let on_x = three!(j => {
        let radius = row_times(l, &way.absolute[j], &half, slack);
        l.le(l.abs(distance[j]), l.add(halves[j], radius))
    });
    let on_y = three!(i => {
        let own = l.mul_add(half[i], l.splat(way.scale), slack);
        let radius = row_times(l, &way.absolute_axes[i], &halves, own);
        let [x, y, z] = &way.axes[i];
        let along = l.mul_add(l.load(y), distance[1], l.mul(l.load(x), distance[0]));
        let along = l.mul_add(l.load(z), distance[2], along);
        l.le(l.abs(along), radius)
    });
    let x_axes = l.and(l.and(on_x[0], on_x[1]), on_x[2]);
    let y_axes = l.and(l.and(on_y[0], on_y[1]), on_y[2]);
    l.and(x_axes, y_axes)
}

#[inline(always)]
pub fn row_times<L: Lanes>(l: L, row: &[Row; 3], v: &[L::F; 3], start: L::F) -> L::F {
    let first = l.mul_add(l.load(&row[0]), v[0], start);
    let second = l.mul_add(l.load(&row[1]), v[1], first);
    l.mul_add(l.load(&row[2]), v[2], second)
}
