//! The rare part of the triangle-triangle test: triangles in one plane, segments and points.

use super::predicates::{Scalar, Sides, Signs};

/// Whether two triangles meet if all vertices of one lie on the plane of the other, which all
/// points do if that is degenerate. `sides_a` are the sides of `a`'s vertices from the plane of
/// `b`, and the other way round; one of the two is [`Sides::ON_PLANE`].
#[cold]
#[inline(never)]
pub fn coplanar_or_degenerate<S: Signs>(
    a: &[[S::Scalar; 3]; 3],
    b: &[[S::Scalar; 3]; 3],
    (sides_a, sides_b): (Sides, Sides),
    signs: S,
) -> bool {
    // A side that is not zero shows that the other triangle is proper; and as this one's own
    // plane has decided nothing, it is a segment across the other's plane.
    if sides_a != Sides::ON_PLANE {
        return crossing_segment_meets(extremes(a), b, signs);
    }
    if sides_b != Sides::ON_PLANE {
        return crossing_segment_meets(extremes(b), a, signs);
    }
    let ([p, q], [r, s]) = (extremes(a), extremes(b));
    (is_proper(a, signs) || is_proper(b, signs) || signs.orient3d(p, q, r, s).is_eq())
        && coplanar_meet(a, b, signs)
}

/// Whether the line through `p` and `q`, which crosses the triangle's plane, passes all three
/// edges on the same side, or through them.
fn crossing_segment_meets<S: Signs>(
    [p, q]: [&[S::Scalar; 3]; 2],
    [a, b, c]: &[[S::Scalar; 3]; 3],
    signs: S,
) -> bool {
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| signs.orient3d(p, q, from, to));
    sides.iter().all(|side| side.is_le()) || sides.iter().all(|side| side.is_ge())
}

fn is_proper<S: Signs>(triangle: &[[S::Scalar; 3]; 3], signs: S) -> bool {
    PROJECTIONS.iter().any(|&axes| !collinear(&project(triangle, axes), signs))
}

/// For six vertices that lie in one plane.
fn coplanar_meet<S: Signs>(a: &[[S::Scalar; 3]; 3], b: &[[S::Scalar; 3]; 3], signs: S) -> bool {
    for axes in PROJECTIONS {
        let (a, b) = (project(a, axes), project(b, axes));
        // An image that is more than a line shows that the projection of the plane is one to one.
        if !collinear([a, b].as_flattened(), signs) {
            return !edge_separates(&a, &b, signs) && !edge_separates(&b, &a, signs);
        }
    }
    let ([a_low, a_high], [b_low, b_high]) = (extremes(a), extremes(b));
    a_low <= b_high && b_low <= a_high
}

/// Whether the line of an edge of `a` has all of `b` strictly on one side and none of `a` there.
///
/// Two convex hulls in a plane are apart iff an edge of either does this (separating axes), also
/// if one of them or both are degenerate, as long as the points are not all on one line.
fn edge_separates<S: Signs>(a: &[[S::Scalar; 2]; 3], b: &[[S::Scalar; 2]; 3], signs: S) -> bool {
    [[0, 1, 2], [1, 2, 0], [2, 0, 1]].iter().any(|&[from, to, apex]| {
        let side = |p| signs.orient2d(&a[from], &a[to], p);
        let first = side(&b[0]);
        first.is_ne() && side(&b[1]) == first && side(&b[2]) == first && side(&a[apex]) != first
    })
}

/// Pairs of axes to project on.
const PROJECTIONS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

fn project<C: Scalar>(triangle: &[[C; 3]; 3], [x, y]: [usize; 2]) -> [[C; 2]; 3] {
    triangle.map(|p| [p[x], p[y]])
}

fn collinear<S: Signs>(points: &[[S::Scalar; 2]], signs: S) -> bool {
    let [low, high] = extremes(points);
    points.iter().all(|p| signs.orient2d(low, high, p).is_eq())
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
