//! Leaves that may be near: turned boxes, then triangles in 32 bits, then what is left of them.

use super::in_order;
use super::nodes::{Bounded, squared_norm};
use super::triangles::TrianglePairs;
use crate::geometry::simd::{InstructionSet, Lanes, Row, three};
use crate::tree::nearest::Search;
use crate::tree::wide::leaf_boxes::{Meeting, Turned, words};
use crate::tree::wide::leaf_pairs::Leaves;
use crate::tree::wide::node::WIDTH;
use crate::tree::wide::place::LeafPlace;

#[derive(Debug)]
pub struct LeafRooms {
    facing: Meeting,
    /// Sums of the distances of centers along the fixed box's axes.
    away: Row,
    pairs: TrianglePairs,
}

impl Default for LeafRooms {
    fn default() -> Self {
        Self { facing: Meeting::NONE, away: [0.0; WIDTH], pairs: TrianglePairs::default() }
    }
}

pub struct LeafStage<'d, 'a> {
    pub leaves: [Leaves<'a>; 2],
    pub place: &'d LeafPlace,
    /// Of the fixed tree.
    pub unit_m: f64,
    pub rooms: &'d mut LeafRooms,
}

impl LeafStage<'_, '_> {
    /// What a computed bound of a squared distance is compared with, in squares of the fixed unit.
    ///
    /// With `d` and `p` as in [`crate::tree::wide::leaf_boxes`], gaps along axes that are not quite
    /// orthonormal make a square that is too large by less than a part of 1.1 (d + p), and rounding
    /// adds 8 * 2^-24; the relative slack is more. Negative if nothing is near enough any more.
    #[inline(always)]
    pub fn limit(&self, search: &Search<'_>) -> f32 {
        let limit = search.limit_m() / self.unit_m;
        if limit < 0.0 {
            return -1.0;
        }
        let wider = 1.0 + f64::from(self.place.relative_slack);
        ((limit * limit * wider) as f32).next_up()
    }

    /// One leaf against those leaves of the other tree that have a bit.
    #[inline(always)]
    pub fn look<S: InstructionSet>(
        &mut self,
        set: S,
        bounded: &Bounded<'_>,
        is_moving: bool,
        search: &mut Search<'_>,
    ) {
        let l = set.eight();
        let one = bounded.box_child.index();
        let first = bounded.leaves.trailing_zeros() as usize;
        // A lane without a bit repeats the first that has one.
        let many: [u32; WIDTH] = std::array::from_fn(|lane| {
            bounded.children[if bounded.leaves >> lane & 1 != 0 { lane } else { first }].index()
        });
        let leaves = if is_moving { [[one; WIDTH], many] } else { [many, [one; WIDTH]] };
        let bounds = self.bound(l, &leaves);
        search.counts.boxes += WIDTH as u64;
        let mut order = [(0.0, 0); WIDTH];
        let count = in_order(&bounds, bounded.leaves, &mut order);
        for &(bound, lane) in &order[..count] {
            let may_be_nearer = bound <= self.limit(search);
            if !may_be_nearer {
                break;
            }
            self.triangles(set, leaves.map(|leaves| leaves[lane]), lane, search);
        }
    }

    /// Of squared distances of turned boxes.
    ///
    /// In the notation of [`crate::tree::wide::leaf_boxes`], with `T` the distance of the centers,
    /// summed along the axes: rounded once and projected, it has an error of 6uT along an axis of the
    /// fixed box, and of 30uT along one of the moving box; all else is as there, relative to S. So the
    /// slack there, relative to S + T, is enough.
    #[inline(always)]
    fn bound<L: Lanes>(&mut self, l: L, leaves: &[[u32; WIDTH]; 2]) -> Row {
        let [fixed, moving] = [0, 1]
            .map(|tree| leaves[tree].map(|leaf| words(&self.leaves[tree].boxes[leaf as usize])));
        let turned = Turned::new(l, self.place, &fixed, &moving);
        let t = three!(k => l.abs(turned.between[k]));
        let away = l.add(l.add(t[0], t[1]), t[2]);
        let size = l.add(l.add(turned.fixed_size, turned.moving_size), away);
        let slack =
            l.mul_add(size, l.splat(self.place.relative_slack), l.splat(self.place.inexact));
        let on_fixed = three!(j => {
            l.sub(t[j], l.add(turned.reach[j], l.add(turned.fixed_half[j], slack)))
        });
        let on_moving = three!(i => {
            let radius = l.add(turned.reach_of_fixed(l, i), l.add(turned.moving_half[i], slack));
            l.sub(turned.along_moving(l, i), radius)
        });
        turned.store(l, self.place, &mut self.rooms.facing);
        l.store(&mut self.rooms.away, away);
        let mut bounds = [0.0; WIDTH];
        l.store(&mut bounds, l.max(squared_norm(l, &on_fixed), squared_norm(l, &on_moving)));
        bounds
    }

    /// The triangles of two leaves, `lane` of those that [`LeafStage::bound`] has turned.
    #[inline(always)]
    fn triangles<S: InstructionSet>(
        &mut self,
        set: S,
        leaves: [u32; 2],
        lane: usize,
        search: &mut Search<'_>,
    ) {
        let rows = [0, 1].map(|tree| &self.leaves[tree].rows[leaves[tree] as usize]);
        let [a, b] = [0, 1].map(|tree| self.leaves[tree].boxes[leaves[tree] as usize].first);
        let limit = self.limit(search);
        let LeafRooms { facing, away, pairs } = &mut *self.rooms;
        pairs.face(set.eight(), rows, facing, lane, away[lane]);
        pairs.bound_boxes(set.eight(), limit);
        search.counts.triangles += (WIDTH * WIDTH) as u64;
        let mut from = 0;
        while self.rooms.pairs.are_near(from, self.limit(search)) {
            let near = self.rooms.pairs.bound(set.most(), from);
            for &(bound, lanes) in near.in_order() {
                if bound > self.limit(search) {
                    break;
                }
                search.consider(a + lanes / WIDTH as u32, b + lanes % WIDTH as u32);
            }
            from += S::Most::COUNT;
        }
    }
}
