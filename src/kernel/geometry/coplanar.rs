//! The rare part of the triangle-triangle test: triangles in one plane, segments and points.

use std::cmp::Ordering;

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
        return crossing_segment_meets(ends(a), b, signs);
    }
    if sides_b != Sides::ON_PLANE {
        return crossing_segment_meets(ends(b), a, signs);
    }
    for axes in PROJECTIONS {
        let images = [project(a, axes), project(b, axes)];
        let turns = images.each_ref().map(|[a, b, c]| signs.orient2d(a, b, c));
        // A triangle that is one in its image too shows that there is a plane, and that the
        // projection of it is one to one.
        if turns != [Ordering::Equal; 2] {
            return !separated(&images, turns, signs);
        }
    }
    segments_meet(a, b, signs)
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

/// Two triangles without area.
fn segments_meet<S: Signs>(a: &[[S::Scalar; 3]; 3], b: &[[S::Scalar; 3]; 3], signs: S) -> bool {
    let ([p, q], [r, s]) = (ends(a), ends(b));
    if signs.orient3d(p, q, r, s).is_ne() {
        return false;
    }
    for axes in PROJECTIONS {
        let images = [project(a, axes), project(b, axes)];
        // As above, of an image that is more than a line.
        if !collinear(images.as_flattened(), signs) {
            return !separated(&images, [Ordering::Equal; 2], signs);
        }
    }
    p <= s && r <= q
}

/// Whether an edge of either has all of the other strictly on one side, and none of its own
/// triangle there.
///
/// Two convex hulls in a plane are apart iff one does (separating axes), also if one of them or
/// both are degenerate, as long as the points are not all on one line. `turns`: whether each goes
/// counterclockwise, or is degenerate.
fn separated<S: Signs>([a, b]: &[[[S::Scalar; 2]; 3]; 2], turns: [Ordering; 2], signs: S) -> bool {
    edge_separates(a, turns[0], b, signs) || edge_separates(b, turns[1], a, signs)
}

/// The third corner of `a` lies on the side of each edge that `a` turns to.
fn edge_separates<S: Signs>(
    a: &[[S::Scalar; 2]; 3],
    turn: Ordering,
    b: &[[S::Scalar; 2]; 3],
    signs: S,
) -> bool {
    let edge_does = |from, to| {
        let first = signs.orient2d(from, to, &b[0]);
        first.is_ne()
            && first != turn
            && signs.orient2d(from, to, &b[1]) == first
            && signs.orient2d(from, to, &b[2]) == first
    };
    let [p, q, r] = a;
    edge_does(p, q) || edge_does(q, r) || edge_does(r, p)
}

/// Pairs of axes to project on.
pub(super) const PROJECTIONS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

pub(super) fn project<C: Scalar>(triangle: &[[C; 3]; 3], [x, y]: [usize; 2]) -> [[C; 2]; 3] {
    triangle.map(|p| [p[x], p[y]])
}

pub(super) fn collinear<S: Signs>(points: &[[S::Scalar; 2]], signs: S) -> bool {
    let [low, high] = ends(points);
    points.iter().all(|p| signs.orient2d(low, high, p).is_eq())
}

fn ends<P: PartialOrd>(points: &[P]) -> [&P; 2] {
    extremes(points).map(|i| &points[i])
}

/// The numbers of the first and the last in lexicographic order, in which collinear points follow
/// their line.
pub(super) fn extremes<P: PartialOrd>(points: &[P]) -> [usize; 2] {
    let mut ends = [0; 2];
    for (i, p) in points.iter().enumerate() {
        if *p < points[ends[0]] {
            ends[0] = i;
        }
        if *p > points[ends[1]] {
            ends[1] = i;
        }
    }
    ends
}
