//! Triangles of one leaf against those of another in 32 bits: which are certainly beyond the limit.
//!
//! Coordinates are in the fixed leaf's frame, with the notation of
//! [`crate::tree::wide::leaf_boxes`]: `u` = 2^-24, `a` and `b` the sums of half extents of both
//! leaves, and `T` the distance of their centers, summed along the axes.

use super::nodes::squared_norm;
use crate::geometry::simd::{Lanes, Row, three};
use crate::tree::wide::leaf_boxes::Meeting;
use crate::tree::wide::node::{LeafRows, WIDTH};
use crate::tree::wide::triangles::{Vector, cross, dot, dot_add, sub};

const U: f32 = 1.0 / (1 << 24) as f32;

/// More than the lanes of any vector, to fill the last one.
const MOST_LANES: usize = 16;

/// Eight triangles by rows: corners, coordinates.
type Corners = [[Row; 3]; 3];

/// Both leaves' triangles in one frame, and the pairs of them that may be near.
#[derive(Debug)]
pub struct TrianglePairs {
    fixed: Corners,
    moving: Corners,
    /// Of the fixed leaf.
    count: usize,
    /// Bound on the error of a difference of two corners, and of sums of its products.
    slack: f32,
    /// The nearest first: the bits of a bound of the squared distance, and the number of the fixed
    /// triangle times [`WIDTH`] plus that of the moving one.
    near: Vec<(u32, u32)>,
}

impl Default for TrianglePairs {
    fn default() -> Self {
        let corners = [[[0.0; WIDTH]; 3]; 3];
        Self { fixed: corners, moving: corners, count: 0, slack: 0.0, near: Vec::new() }
    }
}

/// Pairs by their bounds.
pub struct Bounded {
    pairs: [(f32, u32); MOST_LANES],
    count: usize,
}

impl Bounded {
    /// The nearest first.
    #[inline(always)]
    pub fn in_order(&self) -> &[(f32, u32)] {
        &self.pairs[..self.count]
    }
}

impl TrianglePairs {
    /// Places the moving triangles of `lane`.
    ///
    /// A moving corner is off by the frame's inverse, 4.3ub, its stored place, ub, the rotation,
    /// 10ub, products and sums, 4u(1.8 b + T), and the centers' distance, 6uT; a fixed one by ua. A
    /// sum of three products of such coordinates and a vector, of one corner and of another, and
    /// their difference, add 10u(a + 1.8 b + T) times the sum of the vector's coordinates. Together
    /// that is less than u(11 a + 41 b + 20 T); allowed is more.
    #[inline(always)]
    pub fn face<L: Lanes>(
        &mut self,
        l: L,
        [fixed, moving]: [&LeafRows; 2],
        facing: &Meeting,
        lane: usize,
        away: f32,
    ) {
        let (a, b) = (facing.fixed_size[lane], facing.moving_size[lane]);
        self.slack = U * (16.0 * a + 64.0 * b + 32.0 * away) + facing.inexact;
        let offset = three!(k => l.splat(facing.offset[k][lane]));
        let matrix = three!(j => three!(i => l.splat(facing.matrix[3 * j + i][lane])));
        let (a, b) = (corners(l, fixed), corners(l, moving));
        for v in 0..3 {
            for k in 0..3 {
                l.store(&mut self.fixed[v][k], a[v][k]);
                l.store(&mut self.moving[v][k], dot_add(l, &matrix[k], &b[v], offset[k]));
            }
        }
        self.count = fixed.ids.iter().take_while(|&&id| id != u32::MAX).count();
    }

    /// Finds the pairs whose boxes are not certainly beyond the limit.
    #[inline(always)]
    pub fn bound_boxes<L: Lanes>(&mut self, l: L, limit: f32) {
        let slack = l.splat(self.slack);
        let [low, high] = extents(l, &self.moving);
        let low = three!(k => l.sub(low[k], slack));
        let high = three!(k => l.add(high[k], slack));
        let (mut fixed_low, mut fixed_high) = ([[0.0; WIDTH]; 3], [[0.0; WIDTH]; 3]);
        let of_fixed = extents(l, &self.fixed);
        for k in 0..3 {
            l.store(&mut fixed_low[k], of_fixed[0][k]);
            l.store(&mut fixed_high[k], of_fixed[1][k]);
        }
        self.near.clear();
        for i in 0..self.count {
            let gaps = three!(k => l.max(
                l.sub(l.splat(fixed_low[k][i]), high[k]),
                l.sub(low[k], l.splat(fixed_high[k][i])),
            ));
            let squared = squared_norm(l, &gaps);
            let mut bits = l.bits(l.le(squared, l.splat(limit)));
            let mut bounds = [0.0_f32; WIDTH];
            l.store(&mut bounds, squared);
            while bits != 0 {
                let j = bits.trailing_zeros();
                bits &= bits - 1;
                self.near.push((bounds[j as usize].to_bits(), (i * WIDTH) as u32 + j));
            }
        }
        self.near.sort_unstable();
    }

    /// Whether boxes of pairs from `from` on are within the limit.
    #[inline(always)]
    pub fn are_near(&self, from: usize, limit: f32) -> bool {
        self.near.get(from).is_some_and(|&(bound, _)| f32::from_bits(bound) <= limit)
    }

    /// Bounds for the pairs from `from` on, as many as there are lanes.
    #[inline(always)]
    pub fn bound<L: Lanes>(&self, l: L, from: usize) -> Bounded {
        let near = &self.near[from..];
        let count = near.len().min(L::COUNT);
        let mut codes = [0; MOST_LANES];
        for (code, &(_, lanes)) in codes.iter_mut().zip(near) {
            *code = lanes;
        }
        let [a, b] = [3, 0].map(|shift| codes.map(|code| code >> shift & 7));
        let (a, b) = (l.load_u(&a), l.load_u(&b));
        let a = three!(v => three!(k => l.lookup(&self.fixed[v][k], a)));
        let b = three!(v => three!(k => l.lookup(&self.moving[v][k], b)));
        let mut bounds = [0.0; MOST_LANES];
        l.store(&mut bounds, squared_bound(l, &a, &b, l.splat(self.slack)));
        let mut out = Bounded { pairs: [(0.0, 0); MOST_LANES], count };
        for lane in 0..count {
            let mut at = lane;
            while at > 0 && out.pairs[at - 1].0 > bounds[lane] {
                out.pairs[at] = out.pairs[at - 1];
                at -= 1;
            }
            out.pairs[at] = (bounds[lane], codes[lane]);
        }
        out
    }
}

#[inline(always)]
fn corners<L: Lanes>(l: L, rows: &LeafRows) -> [Vector<L>; 3] {
    [
        three!(k => l.load(&rows.first_two[k][..WIDTH])),
        three!(k => l.load(&rows.first_two[k][WIDTH..])),
        three!(k => l.load(&rows.third[k])),
    ]
}

#[inline(always)]
fn extents<L: Lanes>(l: L, corners: &Corners) -> [Vector<L>; 2] {
    let [a, b, c] = three!(v => three!(k => l.load(&corners[v][k])));
    [three!(k => l.min(l.min(a[k], b[k]), c[k])), three!(k => l.max(l.max(a[k], b[k]), c[k]))]
}

/// Bounds of the squared distances of triangles.
///
/// Along any direction at all, triangles are not nearer than the gap between what they span on it. So
/// it does not matter how the directions are found: the normals of both, which are right where a
/// vertex is nearest to a face, and the way between the nearest points of two edges.
#[inline(always)]
fn squared_bound<L: Lanes>(l: L, a: &[Vector<L>; 3], b: &[Vector<L>; 3], slack: L::F) -> L::F {
    let edges_a = three!(v => Edge::new(l, &a[v], &a[(v + 1) % 3]));
    let edges_b = three!(v => Edge::new(l, &b[v], &b[(v + 1) % 3]));
    let mut way = [l.splat(0.0); 3];
    let mut nearest = l.splat(f32::INFINITY);
    for first in &edges_a {
        for second in &edges_b {
            let between = first.way_to(l, second);
            let squared = dot(l, &between, &between);
            let nearer = l.le(squared, nearest);
            nearest = l.select(nearer, squared, nearest);
            way = three!(k => l.select(nearer, between[k], way[k]));
        }
    }
    let normal_a = cross(l, &edges_a[0].along, &edges_a[1].along);
    let normal_b = cross(l, &edges_b[0].along, &edges_b[1].along);
    let along_way = squared_gap(l, a, b, &way, slack);
    let along_a = squared_gap(l, a, b, &normal_a, slack);
    let along_b = squared_gap(l, a, b, &normal_b, slack);
    l.max(along_way, l.max(along_a, along_b))
}

/// Of what the corners span on a direction, whichever of them is ahead.
#[inline(always)]
fn squared_gap<L: Lanes>(
    l: L,
    a: &[Vector<L>; 3],
    b: &[Vector<L>; 3],
    direction: &Vector<L>,
    slack: L::F,
) -> L::F {
    let [a, b] = [three!(v => dot(l, direction, &a[v])), three!(v => dot(l, direction, &b[v]))];
    let ahead = l.sub(least(l, &a), most(l, &b));
    let gap = l.max(ahead, l.sub(least(l, &b), most(l, &a)));
    let sizes = three!(k => l.abs(direction[k]));
    let size = l.add(l.add(sizes[0], sizes[1]), sizes[2]);
    let gap = l.max(l.splat(0.0), l.sub(gap, l.mul(size, slack)));
    // Too short a direction gives no gap, and the least number keeps it one.
    let squared = l.max(dot(l, direction, direction), l.splat(f32::MIN_POSITIVE));
    l.div(l.mul(gap, gap), squared)
}

#[inline(always)]
fn least<L: Lanes>(l: L, x: &[L::F; 3]) -> L::F {
    l.min(l.min(x[0], x[1]), x[2])
}

#[inline(always)]
fn most<L: Lanes>(l: L, x: &[L::F; 3]) -> L::F {
    l.max(l.max(x[0], x[1]), x[2])
}

struct Edge<L: Lanes> {
    from: Vector<L>,
    along: Vector<L>,
    squared: L::F,
    /// One over that.
    inverse: L::F,
}

impl<L: Lanes> Edge<L> {
    #[inline(always)]
    fn new(l: L, from: &Vector<L>, to: &Vector<L>) -> Self {
        let along = sub(l, to, from);
        let squared = l.max(dot(l, &along, &along), l.splat(f32::MIN_POSITIVE));
        Self { from: *from, along, squared, inverse: l.div(l.splat(1.0), squared) }
    }

    /// Between points that are nearest, or nearly so (Ericson, Real-Time Collision Detection,
    /// section 5.1.9, with the first parameter corrected for the second whatever this is).
    #[inline(always)]
    fn way_to(&self, l: L, other: &Self) -> Vector<L> {
        let start = sub(l, &other.from, &self.from);
        let both = dot(l, &self.along, &other.along);
        let (first, second) = (dot(l, &self.along, &start), dot(l, &other.along, &start));
        let determinant = l.mul_sub(self.squared, other.squared, l.mul(both, both));
        let determinant = l.max(determinant, l.splat(f32::MIN_POSITIVE));
        let s = l.mul_sub(first, other.squared, l.mul(both, second));
        let s = between_ends(l, l.div(s, determinant));
        let t = between_ends(l, l.mul(l.mul_sub(both, s, second), other.inverse));
        let s = between_ends(l, l.mul(l.mul_add(both, t, first), self.inverse));
        three!(k => {
            let ahead = l.mul_add(other.along[k], t, start[k]);
            l.sub(ahead, l.mul(self.along[k], s))
        })
    }
}

#[inline(always)]
fn between_ends<L: Lanes>(l: L, part: L::F) -> L::F {
    l.min(l.max(part, l.splat(0.0)), l.splat(1.0))
}
