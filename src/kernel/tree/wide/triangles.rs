//! Up to eight triangles of one leaf against up to eight of another, in 32 bits: what is decided
//! here is certain, the rest is left to the exact test.
//!
//! Coordinates are in the fixed leaf's frame, and what is compared are images of the contract's
//! vertices in it ([`super::leaf_boxes`] has the bounds that start here, and the notation: `u` =
//! 2^-24, `a` and `b` the sums of half extents of both leaves). Edges are taken in each leaf's own
//! frame, so that their errors do not grow with the distance of the leaves.

use super::decision::Decision;
use super::leaf_boxes::Meeting;
use super::node::{LeafRows, WIDTH};
use crate::geometry::simd::{InstructionSet, Lanes, Row, three};

/// Eight triangles by rows: the first corner, and the edges from it to the second and the third.
type Sides = [[Row; 3]; 3];

/// Bounds and extents of eight triangles.
struct Extents {
    low: [Row; 3],
    high: [Row; 3],
    /// The longest side of each box.
    longest: Row,
}

/// Both leaves' triangles in one frame.
#[derive(Debug)]
pub struct Faced {
    fixed: Sides,
    moving: Sides,
    fixed_extent: Row,
    moving_extent: Row,
    error: LeafError,
    /// Numbers of the pairs whose boxes meet, see [`Lanes::pairs`].
    codes: [u32; WIDTH * WIDTH + 16],
    count: usize,
}

/// The parts of the error bounds that are the same for all triangles of two leaves.
#[derive(Clone, Copy, Debug)]
struct LeafError {
    fixed_edge: f32,
    moving_edge: f32,
    between: f32,
}

/// Of a vector of pairs.
pub struct Decided<L: Lanes> {
    /// A pair's triangle of either leaf.
    pub lanes: [L::U; 2],
    /// Bits of the pairs that meet.
    pub meet: u32,
    /// Bits of those that are not certain.
    pub open: u32,
}

impl Default for Faced {
    fn default() -> Self {
        Self {
            fixed: [[[0.0; WIDTH]; 3]; 3],
            moving: [[[0.0; WIDTH]; 3]; 3],
            fixed_extent: [0.0; WIDTH],
            moving_extent: [0.0; WIDTH],
            error: LeafError { fixed_edge: 0.0, moving_edge: 0.0, between: 0.0 },
            codes: [0; WIDTH * WIDTH + 16],
            count: 0,
        }
    }
}

const U: f32 = 1.0 / (1 << 24) as f32;

impl Faced {
    #[inline(always)]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Lane `at` of `meeting`: places the moving triangles and finds the pairs whose boxes meet.
    ///
    /// A box is drawn around a corner and two sums of it and an edge. Such a sum of the moving leaf
    /// is off by at most u(27 b + 8 a) of the corner, 2ub and 47u times an edge of at most 2b, and
    /// the sum's own rounding; of the fixed leaf by less than 4ua. The boxes are drawn u(130 b +
    /// 16 a) wider than they are computed.
    #[inline(always)]
    pub fn face<S: InstructionSet>(
        &mut self,
        set: S,
        [fixed, moving]: [&LeafRows; 2],
        meeting: &Meeting,
        at: usize,
    ) {
        let l = set.eight();
        let (a, b) = (meeting.fixed_size[at], meeting.moving_size[at]);
        self.error = LeafError {
            fixed_edge: 2.02 * U * a,
            moving_edge: 2.02 * U * b,
            between: U * (17.0 * a + 35.0 * b) + meeting.inexact,
        };
        let wider = l.splat(U * (16.0 * a + 130.0 * b) + meeting.inexact);

        let m = &meeting.matrix;
        let offset = three!(k => l.splat(meeting.offset[k][at]));
        let matrix = three!(j => three!(i => l.splat(m[3 * j + i][at])));
        let a = sides_of(l, fixed);
        let b = sides_of(l, moving);
        let b = [
            three!(j => dot_add(l, &matrix[j], &b[0], offset[j])),
            three!(j => dot(l, &matrix[j], &b[1])),
            three!(j => dot(l, &matrix[j], &b[2])),
        ];
        for v in 0..3 {
            for k in 0..3 {
                l.store(&mut self.fixed[v][k], a[v][k]);
                l.store(&mut self.moving[v][k], b[v][k]);
            }
        }
        let a = extents(l, &a, l.splat(0.0));
        let b = extents(l, &b, wider);
        self.fixed_extent = a.longest;
        self.moving_extent = b.longest;
        let reach = three!(k => l.add(l.splat(meeting.reach[k][at]), wider));
        let near = three!(k => l.and(
            l.le(l.load(&a.low[k]), l.add(offset[k], reach[k])),
            l.le(l.sub(offset[k], reach[k]), l.load(&a.high[k])),
        ));
        let near = l.bits(l.and(l.and(near[0], near[1]), near[2]));
        self.find_pairs(set.most(), near, &a, &b);
    }

    #[inline(always)]
    fn find_pairs<L: Lanes>(&mut self, l: L, mut near: u32, a: &Extents, b: &Extents) {
        let b_low = three!(k => l.repeat(&b.low[k]));
        let b_high = three!(k => l.repeat(&b.high[k]));
        let mut count = 0;
        // Fixed triangles in one step.
        let each = L::COUNT / WIDTH;
        while near != 0 {
            let step = near.trailing_zeros() as usize / each;
            near &= !(((1 << each) - 1) << (step * each));
            let on = three!(k => {
                let low = l.le(l.spread(&a.low[k], step), b_high[k]);
                l.and(low, l.le(b_low[k], l.spread(&a.high[k], step)))
            });
            let bits = l.bits(l.and(l.and(on[0], on[1]), on[2]));
            let numbers = l.load_u(&NUMBERS[step * L::COUNT..]);
            // SAFETY: at most as many as there were lanes before, and the room is one vector longer.
            let room = unsafe { self.codes.get_unchecked_mut(count..count + L::COUNT) };
            l.store_u(room, l.compress(bits, numbers));
            count += bits.count_ones() as usize;
        }
        self.count = count;
    }

    /// The pairs from `at` on, as many as there are lanes.
    #[inline(always)]
    pub fn decide<L: Lanes>(&self, l: L, at: usize, decision: impl Decision) -> Decided<L> {
        debug_assert!(at < self.count);
        // SAFETY: as in `find_pairs`.
        let codes = unsafe { self.codes.get_unchecked(at..at + L::COUNT) };
        let lanes = l.pairs(l.load_u(codes));
        let left = (self.count - at).min(L::COUNT);
        let valid = ((1_u64 << left) - 1) as u32;
        let [meet, open] = decision.decide(l, self, lanes, valid);
        Decided { lanes, meet, open }
    }

    /// Of a fixed and a moving triangle each: the first corner and the edges from it.
    #[inline(always)]
    pub fn sides<L: Lanes>(&self, l: L, [ia, ib]: [L::U; 2]) -> [[Vector<L>; 3]; 2] {
        [
            three!(v => three!(k => l.lookup(&self.fixed[v][k], ia))),
            three!(v => three!(k => l.lookup(&self.moving[v][k], ib))),
        ]
    }

    #[inline(always)]
    pub fn bounds<L: Lanes>(&self, l: L, [ia, ib]: [L::U; 2]) -> Bounds<L> {
        let ea = l.lookup(&self.fixed_extent, ia);
        let eb = l.lookup(&self.moving_extent, ib);
        Bounds::new(l, &self.error, ea, eb)
    }
}

#[inline(always)]
fn sides_of<L: Lanes>(l: L, rows: &LeafRows) -> [Vector<L>; 3] {
    let first = three!(k => l.load(&rows.first_two[k][..8]));
    let second = three!(k => l.sub(l.load(&rows.first_two[k][8..]), first[k]));
    let third = three!(k => l.sub(l.load(&rows.third[k]), first[k]));
    [first, second, third]
}

static NUMBERS: [u32; WIDTH * WIDTH] = {
    let mut numbers = [0; WIDTH * WIDTH];
    let mut i = 0;
    while i < WIDTH * WIDTH {
        numbers[i] = i as u32;
        i += 1;
    }
    numbers
};

#[inline(always)]
fn extents<L: Lanes>(l: L, sides: &[Vector<L>; 3], grow: L::F) -> Extents {
    let mut out = Extents { low: [[0.0; 8]; 3], high: [[0.0; 8]; 3], longest: [0.0; 8] };
    let nothing = l.splat(0.0);
    let mut longest = nothing;
    let [corners, seconds, thirds] = sides;
    for (k, &corner) in corners.iter().enumerate() {
        let (second, third) = (seconds[k], thirds[k]);
        let down = l.sub(l.min(l.min(second, third), nothing), grow);
        let up = l.add(l.max(l.max(second, third), nothing), grow);
        longest = l.max(l.sub(up, down), longest);
        l.store(&mut out.low[k], l.add(corner, down));
        l.store(&mut out.high[k], l.add(corner, up));
    }
    l.store(&mut out.longest, longest);
    out
}

pub type Vector<L> = [<L as Lanes>::F; 3];

/// Error bounds of a vector of pairs; `A` and `B` bound the edges of the fixed and the moving
/// triangle, as computed and as they are, `W = A + B` the difference of any two corners.
pub struct Bounds<L: Lanes> {
    a: L::F,
    b: L::F,
    w: L::F,
    /// Errors of an edge from the first corner, but for a moving one's rotation.
    side_a: L::F,
    side_b: L::F,
    /// Errors of any edge.
    edge_a: L::F,
    edge_b: L::F,
    between: L::F,
}

impl<L: Lanes> Bounds<L> {
    /// - An edge of the fixed triangle from its first corner is the rounded difference of two
    ///   rounded coordinates: 2ua + uA. The third edge is the difference of those: 4ua + 3uA.
    /// - An edge of the moving one is its true image under a matrix that differs from the identity
    ///   by at most 35u (ten in each entry of the rotation, 4.3 of its frame), and what rounding
    ///   does to it: 2ub for stored coordinates, u of their difference, 4u of products and sums,
    ///   with |edge| <= sqrt(3) B together 2ub + 9uB. As a whole, 2ub + 70uB; the third edge
    ///   4ub + 141uB.
    /// - The difference of two first corners: u(27 b + 8 a) for the moving one, ua for the fixed
    ///   one, uW; of two other corners also an edge of each, and two sums: 5uW.
    ///
    /// All have one more uA or uB for the roundings in a product of two edges. `between` has one
    /// edge's error of each and 8uW more, for the roundings in a product with a difference and a sum
    /// of such products, and 246uW for what the matrix does to a moving normal: its cofactors differ
    /// from the identity by at most 71u, the difference is at most sqrt(3) W long, and a second
    /// corner adds as much.
    #[inline(always)]
    fn new(l: L, error: &LeafError, a: L::F, b: L::F) -> Self {
        // The moving box was drawn wider by more than all errors of both; that of the fixed
        // triangle was not.
        let a = l.add(a, l.splat(2.0 * error.fixed_edge));
        let w = l.add(a, b);
        Self {
            side_a: l.mul_add(a, l.splat(2.1 * U), l.splat(error.fixed_edge)),
            side_b: l.mul_add(b, l.splat(10.1 * U), l.splat(error.moving_edge)),
            edge_a: l.mul_add(a, l.splat(4.1 * U), l.splat(2.0 * error.fixed_edge)),
            edge_b: l.mul_add(b, l.splat(143.0 * U), l.splat(2.0 * error.moving_edge)),
            between: l.mul_add(w, l.splat(560.0 * U), l.splat(error.between)),
            a,
            b,
            w,
        }
    }

    /// Of a normal times a difference, see [`decide`]: 24 E W side + |n| between.
    #[inline(always)]
    fn of_side(&self, l: L, extent: L::F, edge: L::F, normal: &Vector<L>) -> L::F {
        let product = l.mul(l.mul(extent, self.w), l.mul(edge, l.splat(24.1)));
        self.with_normal(l, normal, product)
    }

    /// Of a product of an edge of each times a difference: 6 W (A edge_b + B edge_a) + |n| between.
    #[inline(always)]
    fn of_edges(&self, l: L) -> L::F {
        let both = l.mul_add(self.a, self.edge_b, l.mul(self.b, self.edge_a));
        l.mul(l.mul(both, self.w), l.splat(6.1))
    }

    /// The last constant is more than all that underflow can add.
    #[inline(always)]
    fn with_normal(&self, l: L, normal: &Vector<L>, product: L::F) -> L::F {
        let length = l.add(l.add(l.abs(normal[0]), l.abs(normal[1])), l.abs(normal[2]));
        let tiny = l.splat(1.0 / (1_u128 << 120) as f32);
        l.add(l.mul_add(length, l.mul(self.between, l.splat(1.01)), product), tiny)
    }
}

/// Guigue & Devillers' test (2003, section 3), as in [`crate::geometry::triangle`], where all its
/// signs are certain.
///
/// # The bounds
/// In the notation of [`Bounds`], with |n| the sum of a vector's absolute components:
///
/// - A normal of two edges of one triangle, of extent E: each of two products 2E times an edge's
///   error, and their roundings 4uEE; together 4E times `side`. Times a difference of corners:
///   three such times W, and |n| times the difference's error; a second corner adds as much for an
///   edge of the other triangle, which is at most W: 24 E W `side` and |n| `between`.
/// - The product of an edge of each triangle: 2 (A edge_b + B edge_a). Times a difference: three
///   times W that, and |n| `between`.
///
/// Bits of the pairs that meet, and of those that are not certain.
#[inline(always)]
pub fn decide<L: Lanes>(
    l: L,
    a: &[Vector<L>; 3],
    b: &[Vector<L>; 3],
    bounds: &Bounds<L>,
    valid: u32,
) -> [u32; 2] {
    let between = sub(l, &b[0], &a[0]);

    let normal = cross(l, &a[1], &a[2]);
    let first = dot(l, &normal, &between);
    let sides_b = [first, dot_add(l, &normal, &b[1], first), dot_add(l, &normal, &b[2], first)];
    let limit = bounds.of_side(l, bounds.a, bounds.side_a, &normal);
    let (apart_b, sure_b) = sides(l, &sides_b, limit);

    let normal = cross(l, &b[1], &b[2]);
    let first = negated(l, dot(l, &normal, &between));
    let sides_a = [first, dot_add(l, &normal, &a[1], first), dot_add(l, &normal, &a[2], first)];
    let limit = bounds.of_side(l, bounds.b, bounds.side_b, &normal);
    let (apart_a, sure_a) = sides(l, &sides_a, limit);

    let alive = valid & !l.bits(l.or(apart_a, apart_b));
    let sure = alive & l.bits(l.and(sure_a, sure_b));
    let open = alive & !sure;
    if sure == 0 {
        return [0, open];
    }

    let nothing = l.splat(0.0);
    let a = Lead::of(l, a, three!(k => l.le(sides_a[k], nothing)));
    let b = Lead::of(l, b, three!(k => l.le(sides_b[k], nothing)));
    let between = sub(l, &three!(k => l.add(between[k], b.corner[k])), &a.corner);
    let [q1, r1] = a.edges_in_order(l, b.below);
    let [q2, r2] = b.edges_in_order(l, a.below);
    // orient3d(p1, q1, p2, q2), with its sign turned, and orient3d(p1, r1, r2, p2).
    let begin = cross(l, &q1, &q2);
    let end = cross(l, &r1, &r2);
    let product = bounds.of_edges(l);
    let (begin_limit, end_limit) =
        (bounds.with_normal(l, &begin, product), bounds.with_normal(l, &end, product));
    let begins = negated(l, dot(l, &begin, &between));
    let ends = dot(l, &end, &between);
    let inside = l.and(l.le(begins, negated(l, begin_limit)), l.le(ends, negated(l, end_limit)));
    let outside = l.or(l.le(begin_limit, begins), l.le(end_limit, ends));
    let meet = sure & l.bits(inside);
    [meet, open | sure & !(meet | l.bits(outside))]
}

#[inline(always)]
pub fn negated<L: Lanes>(l: L, x: L::F) -> L::F {
    l.sub(l.splat(0.0), x)
}

/// Whether all three are certainly on one side, and whether the side of each is certain.
#[inline(always)]
fn sides<L: Lanes>(l: L, d: &[L::F; 3], limit: L::F) -> (L::M, L::M) {
    let least = l.min(l.min(d[0], d[1]), d[2]);
    let most = l.max(l.max(d[0], d[1]), d[2]);
    let apart = l.or(l.le(limit, least), l.le(most, l.sub(l.splat(0.0), limit)));
    let nearest = l.min(l.min(l.abs(d[0]), l.abs(d[1])), l.abs(d[2]));
    (apart, l.le(limit, nearest))
}

/// A triangle from the corner that the other's plane separates from the other two.
pub struct Lead<L: Lanes> {
    /// From the first corner to this one.
    pub corner: Vector<L>,
    /// To the next corner and to the one after that.
    edges: [Vector<L>; 2],
    /// Whether it is below that plane.
    pub below: L::M,
}

impl<L: Lanes> Lead<L> {
    /// `below`: which corners are, not all of them and not none.
    #[inline(always)]
    pub fn of(l: L, triangle: &[Vector<L>; 3], below: [L::M; 3]) -> Self {
        let nothing = l.splat(0.0);
        let not_first = l.xor(below[1], below[2]);
        let third = l.and(not_first, l.xor(below[0], below[2]));
        let [_, to_second, to_third] = triangle;
        let across = sub(l, to_third, to_second);
        let corner = three!(k => {
            let second = l.select(not_first, to_second[k], nothing);
            l.select(third, to_third[k], second)
        });
        let next = three!(k => {
            let second = l.select(not_first, across[k], to_second[k]);
            l.select(third, negated(l, to_third[k]), second)
        });
        let last = three!(k => {
            let second = l.select(not_first, negated(l, to_second[k]), to_third[k]);
            l.select(third, negated(l, across[k]), second)
        });
        // Alone is who is not with the majority.
        let majority = l.or(l.and(below[0], below[1]), l.and(below[2], l.or(below[0], below[1])));
        let below = l.xor(majority, l.le(nothing, nothing));
        Self { corner, edges: [next, last], below }
    }

    /// The edges in their order or against it.
    #[inline(always)]
    pub fn edges_in_order(&self, l: L, reversed: L::M) -> [Vector<L>; 2] {
        let [next, last] = &self.edges;
        [pick(l, reversed, last, next), pick(l, reversed, next, last)]
    }
}

#[inline(always)]
fn pick<L: Lanes>(l: L, m: L::M, yes: &Vector<L>, no: &Vector<L>) -> Vector<L> {
    three!(k => l.select(m, yes[k], no[k]))
}

#[inline(always)]
pub fn sub<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>) -> Vector<L> {
    three!(k => l.sub(a[k], b[k]))
}

#[inline(always)]
pub fn cross<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>) -> Vector<L> {
    three!(i => {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        l.mul_sub(a[j], b[k], l.mul(a[k], b[j]))
    })
}

#[inline(always)]
pub fn dot<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>) -> L::F {
    l.mul_add(a[2], b[2], l.mul_add(a[1], b[1], l.mul(a[0], b[0])))
}

#[inline(always)]
pub fn dot_add<L: Lanes>(l: L, a: &Vector<L>, b: &Vector<L>, start: L::F) -> L::F {
    l.mul_add(a[2], b[2], l.mul_add(a[1], b[1], l.mul_add(a[0], b[0], start)))
}
