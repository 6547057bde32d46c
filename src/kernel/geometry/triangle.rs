//! Do two closed triangles share a point?

use super::Triangle;
use super::coplanar::coplanar_or_degenerate;
pub use super::predicates::StaticFilter;
use super::predicates::{Certain, Sides, Signs};

/// True iff the closed hulls of `a` and `b` share at least one point; touching counts, and a
/// degenerate triangle is the segment or point that its vertices span.
///
/// All coordinates finite; `filter` made for an extent that holds for these six vertices. Exact:
/// Guigue & Devillers, "Fast and robust triangle-triangle overlap test using orientation
/// predicates" (2003), on signs that are never wrong.
#[inline]
pub fn triangles_intersect(a: &Triangle, b: &Triangle, filter: &StaticFilter) -> bool {
    intersect_by(a, b, Certain::new(filter))
}

/// [`triangles_intersect`] with signs from wherever: the answer is as good as they are.
#[inline]
pub fn intersect_by<S: Signs>(a: &[[S::Scalar; 3]; 3], b: &[[S::Scalar; 3]; 3], signs: S) -> bool {
    let sides_b = signs.sides(a, b);
    if sides_b.strictly_one() {
        return false;
    }
    if sides_b.touch() && signs.have_common_corner(a, b) {
        return true;
    }
    let sides_a = signs.sides(b, a);
    if sides_a.strictly_one() {
        return false;
    }
    if sides_a == Sides::ON_PLANE || sides_b == Sides::ON_PLANE {
        return coplanar_or_degenerate(a, b, (sides_a, sides_b), signs);
    }
    intervals_overlap((a, Apex::of(sides_a)), (b, Apex::of(sides_b)), signs)
}

/// Both triangles are proper and meet the line common to their planes, each in an interval that
/// ends on the two edges at its apex: the intervals overlap iff each begins before the other
/// ends.
#[inline]
fn intervals_overlap<S: Signs>(
    (a, apex_a): (&[[S::Scalar; 3]; 3], Apex),
    (b, apex_b): (&[[S::Scalar; 3]; 3], Apex),
    signs: S,
) -> bool {
    // Turned so that each apex lies above the other's plane, which lets both intervals run the
    // same way.
    let [p1, q1, r1] = apex_a.leading(a, apex_b.below);
    let [p2, q2, r2] = apex_b.leading(b, apex_a.below);
    signs.orient3d(p1, q1, p2, q2).is_le() && signs.orient3d(p1, r1, r2, p2).is_le()
}

/// The vertex that the other triangle's plane separates from the other two. These may lie on the
/// plane, unless the apex does.
#[derive(Clone, Copy)]
pub(super) struct Apex {
    vertex: usize,
    pub(super) below: bool,
}

impl Apex {
    /// `sides`: not all on the plane, all above or all below.
    #[inline]
    pub(super) fn of(sides: Sides) -> Self {
        const TABLE: [Apex; 64] = Apex::table();
        TABLE[usize::from(sides.above | sides.below << 3) % 64]
    }

    const fn table() -> [Self; 64] {
        let mut table = [Self { vertex: 0, below: false }; 64];
        let mut index = 0;
        while index < 64 {
            let (above, below) = (index & 7, index >> 3);
            let mut vertex = 0;
            while vertex < 3 {
                let (apex, others) = (1 << vertex, 7 ^ 1 << vertex);
                if above == apex || above == 0 && below == others {
                    table[index] = Self { vertex, below: false };
                } else if below == apex || below == 0 && above == others {
                    table[index] = Self { vertex, below: true };
                }
                vertex += 1;
            }
            index += 1;
        }
        table
    }

    /// The vertices, the apex first, in their order or against it.
    #[inline]
    fn leading<P>(self, triangle: &[P; 3], reversed: bool) -> [&P; 3] {
        self.first(reversed).map(|i| &triangle[i])
    }

    /// The numbers of the vertices, the apex's first, in their order or against it.
    #[inline]
    pub(super) fn first(self, reversed: bool) -> [usize; 3] {
        const ORDERS: [[[usize; 3]; 2]; 3] =
            [[[0, 1, 2], [0, 2, 1]], [[1, 2, 0], [1, 0, 2]], [[2, 0, 1], [2, 1, 0]]];
        ORDERS[self.vertex][usize::from(reversed)]
    }
}
