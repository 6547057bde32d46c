//! Leaves that may be near: turned boxes, then triangles in 32 bits, then their distances.

use super::in_order;
use super::nodes::{Bounded, squared_norm};
use crate::geometry::simd::{InstructionSet, Lanes, Row, three};
use crate::tree::nearest::Search;
use crate::tree::wide::leaf_boxes::{Meeting, Turned, words};
use crate::tree::wide::leaf_pairs::Leaves;
use crate::tree::wide::node::{LeafRows, WIDTH};
use crate::tree::wide::place::LeafPlace;
use crate::tree::wide::triangles::dot_add;

const U: f32 = 1.0 / (1 << 24) as f32;

#[derive(Debug)]
pub struct LeafRooms {
    facing: Meeting,
    /// Sums of the distances of centers along the fixed box's axes.
    away: Row,
    /// Pairs of triangles, the nearest first: the bits of a bound, and both lanes.
    near: Vec<(u32, u32)>,
}

impl Default for LeafRooms {
    fn default() -> Self {
        Self { facing: Meeting::NONE, away: [0.0; WIDTH], near: Vec::new() }
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
            if !(bound <= self.limit(search)) {
                break;
            }
            self.triangles(l, leaves.map(|leaves| leaves[lane]), lane, search);
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
    fn triangles<L: Lanes>(
        &mut self,
        l: L,
        leaves: [u32; 2],
        lane: usize,
        search: &mut Search<'_>,
    ) {
        let [fixed, moving] = [0, 1].map(|tree| &self.leaves[tree].rows[leaves[tree] as usize]);
        let limit = self.limit(search);
        self.rooms.bound_triangles(l, [fixed, moving], lane, limit);
        search.counts.triangles += (WIDTH * WIDTH) as u64;
        let [a, b] = [0, 1].map(|tree| self.leaves[tree].boxes[leaves[tree] as usize].first);
        for at in 0..self.rooms.near.len() {
            let (bound, lanes) = self.rooms.near[at];
            if !(f32::from_bits(bound) <= self.limit(search)) {
                break;
            }
            search.consider(a + lanes / WIDTH as u32, b + lanes % WIDTH as u32);
        }
    }
}

impl LeafRooms {
    /// Pairs of triangles whose boxes in the fixed leaf's frame are not certainly beyond the limit.
    ///
    /// In the notation of [`crate::tree::wide::leaf_boxes`], with `T` as above, a moving corner in
    /// that frame is off by the frame's inverse, 4.3ub, its stored place, ub, the rotation, 10ub,
    /// products and sums, 4u(1.8 b + T), and the centers' distance, 6uT; a fixed one by ua, and a gap
    /// of both adds u(a + 1.8 b + T). That is less than u(2 a + 25 b + 11 T). Allowed is more.
    #[inline(always)]
    fn bound_triangles<L: Lanes>(
        &mut self,
        l: L,
        [fixed, moving]: [&LeafRows; 2],
        lane: usize,
        limit: f32,
    ) {
        let facing = &self.facing;
        let (a, b) = (facing.fixed_size[lane], facing.moving_size[lane]);
        let slack = l.splat(U * (8.0 * a + 40.0 * b + 24.0 * self.away[lane]) + facing.inexact);
        let offset = three!(k => l.splat(facing.offset[k][lane]));
        let matrix = three!(j => three!(i => l.splat(facing.matrix[3 * j + i][lane])));
        let corners = corners(l, moving);
        let corners = three!(v => three!(j => dot_add(l, &matrix[j], &corners[v], offset[j])));
        let (low, high) = extents(l, &corners);
        let low = three!(k => l.sub(low[k], slack));
        let high = three!(k => l.add(high[k], slack));
        let (mut fixed_low, mut fixed_high) = ([[0.0; WIDTH]; 3], [[0.0; WIDTH]; 3]);
        let of_fixed = extents(l, &self::corners(l, fixed));
        for k in 0..3 {
            l.store(&mut fixed_low[k], of_fixed.0[k]);
            l.store(&mut fixed_high[k], of_fixed.1[k]);
        }
        self.near.clear();
        for i in (0..WIDTH).take_while(|&i| fixed.ids[i] != u32::MAX) {
            let gaps = three!(k => l.max(
                l.sub(l.splat(fixed_low[k][i]), high[k]),
                l.sub(low[k], l.splat(fixed_high[k][i])),
            ));
            let squared = squared_norm(l, &gaps);
            let mut bits = l.bits(l.le(squared, l.splat(limit)));
            let mut bounds = [0.0; WIDTH];
            l.store(&mut bounds, squared);
            while bits != 0 {
                let j = bits.trailing_zeros();
                bits &= bits - 1;
                self.near.push((bounds[j as usize].to_bits(), (i * WIDTH) as u32 + j));
            }
        }
        self.near.sort_unstable();
    }
}

#[inline(always)]
fn corners<L: Lanes>(l: L, rows: &LeafRows) -> [[L::F; 3]; 3] {
    [
        three!(k => l.load(&rows.first_two[k][..WIDTH])),
        three!(k => l.load(&rows.first_two[k][WIDTH..])),
        three!(k => l.load(&rows.third[k])),
    ]
}

#[inline(always)]
fn extents<L: Lanes>(l: L, [a, b, c]: &[[L::F; 3]; 3]) -> ([L::F; 3], [L::F; 3]) {
    (three!(k => l.min(l.min(a[k], b[k]), c[k])), three!(k => l.max(l.max(a[k], b[k]), c[k])))
}
