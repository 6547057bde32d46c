//! The rare part of the triangle-triangle test: triangles in one plane, segments and points.

use std::cmp::Ordering;

use super::predicates::{Point2, Sides, StaticFilter, orient2d, orient3d};
use super::{Point, Triangle};

/// Whether two triangles meet if all vertices of one lie on the plane of the other, which all
/// points do if that is degenerate. `sides_a` are the sides of `a`'s vertices from the plane of
/// `b`, and the other way round; one of the two is [`Sides::ON_PLANE`].
#[cold]
#[inline(never)]
pub fn coplanar_or_degenerate(a: &Triangle, b: &Triangle, sides_a: Sides, sides_b: Sides) -> bool {
    // A side that is not zero shows that the other triangle is proper; and as this one's own
    // plane has decided nothing, it is a segment across the other's plane.
    if sides_a != Sides::ON_PLANE {
        return crossing_segment_meets(extremes(a), b);
    }
    if sides_b != Sides::ON_PLANE {
        return crossing_segment_meets(extremes(b), a);
    }
    let ([p, q], [r, s]) = (extremes(a), extremes(b));
    (is_proper(a) || is_proper(b) || orient(p, q, r, s).is_eq()) && coplanar_meet(a, b)
}

/// Whether the line through `p` and `q`, which crosses the triangle's plane, passes all three
/// edges on the same side, or through them.
fn crossing_segment_meets([p, q]: [&Point; 2], [a, b, c]: &Triangle) -> bool {
    let sides = [orient(p, q, a, b), orient(p, q, b, c), orient(p, q, c, a)];
    sides.iter().all(|side| side.is_le()) || sides.iter().all(|side| side.is_ge())
}

fn is_proper(triangle: &Triangle) -> bool {
    PROJECTIONS.iter().any(|&axes| !collinear(&project(triangle, axes)))
}

/// For six vertices that lie in one plane.
fn coplanar_meet(a: &Triangle, b: &Triangle) -> bool {
    for axes in PROJECTIONS {
        let (a, b) = (project(a, axes), project(b, axes));
        // An image that is more than a line shows that the projection of the plane is one to one.
        if !collinear([a, b].as_flattened()) {
            return !edge_separates(&a, &b) && !edge_separates(&b, &a);
        }
    }
    let ([a_low, a_high], [b_low, b_high]) = (extremes(a), extremes(b));
    a_low <= b_high && b_low <= a_high
}

/// Whether the line of an edge of `a` has all of `b` strictly on one side and none of `a` there.
///
/// Two convex hulls in a plane are apart iff an edge of either does this (separating axes), also
/// if one of them or both are degenerate, as long as the points are not all on one line.
fn edge_separates(a: &[Point2; 3], b: &[Point2; 3]) -> bool {
    [[0, 1, 2], [1, 2, 0], [2, 0, 1]].iter().any(|&[from, to, apex]| {
        let [side, others @ ..] = b.each_ref().map(|p| orient2d(&a[from], &a[to], p));
        let own = orient2d(&a[from], &a[to], &a[apex]);
        side.is_ne() && others == [side; 2] && own != side
    })
}

/// Pairs of axes to project on.
pub(super) const PROJECTIONS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

pub(super) fn project(triangle: &Triangle, [x, y]: [usize; 2]) -> [Point2; 3] {
    triangle.map(|p| [p[x], p[y]])
}

pub(super) fn collinear(points: &[Point2]) -> bool {
    let [low, high] = extremes(points);
    points.iter().all(|p| orient2d(low, high, p).is_eq())
}

/// The first and the last in lexicographic order, in which collinear points follow their line.
fn extremes<P: PartialOrd>(points: &[P]) -> [&P; 2] {
    let mut ends = [&points[0]; 2];
    for p in points {
        if p < ends[0] {
            ends[0] = p;
        }
        if p > ends[1] {
            ends[1] = p;
        }
    }
    ends
}

fn orient(a: &Point, b: &Point, c: &Point, d: &Point) -> Ordering {
    orient3d(a, b, c, d, &StaticFilter::OFF)
}
