//! Triangles in one plane, segments and points.

use std::cmp::Ordering;

use super::Face;
use super::collect::Collector;
use super::crossing::{Crossing, Divider, Place};
use crate::geometry::coplanar::{PROJECTIONS, collinear, project};
use crate::geometry::predicates::{Point2, Sides, StaticFilter, orient2d, orient3d};
use crate::geometry::{Point, Triangle};

/// Collects the corners of the common set, none if the triangles are apart. `sides`: of each
/// triangle from the other's plane, one of them [`Sides::ON_PLANE`], neither strictly on one side.
#[cold]
#[inline(never)]
pub fn corners([a, b]: [&Triangle; 2], [sides_a, sides_b]: [Sides; 2], found: &mut Collector) {
    // A side that is not zero shows that the other triangle is proper; and as this one's own
    // plane has decided nothing, it is a segment across the other's plane.
    if sides_a != Sides::ON_PLANE {
        if let Some((place, own, other)) = across_plane(a, sides_a, b) {
            found.push(place, [own, other]);
        }
        return;
    }
    if sides_b != Sides::ON_PLANE {
        if let Some((place, own, other)) = across_plane(b, sides_b, a) {
            found.push(place, [other, own]);
        }
        return;
    }
    let axes = clearest_projection(a, b);
    let hulls = [Hull::new(a, axes), Hull::new(b, axes)];
    if hulls.iter().all(|hull| hull.count < 3) {
        let [[p, q], [r, s]] = [&hulls[0], &hulls[1]].map(Hull::ends);
        if orient(p, q, r, s).is_ne() {
            return;
        }
    }
    coplanar_corners(&hulls, axes, found);
    found.sort_round();
}

/// Where a segment crosses the plane of a proper triangle, if within it: the place, the face of
/// the segment and that of the triangle.
fn across_plane<'a>(
    segment: &'a Triangle,
    sides: Sides,
    triangle: &'a Triangle,
) -> Option<(Place<'a>, Face, Face)> {
    let [i, j] = extremes(segment);
    let (p, q) = (&segment[i], &segment[j]);
    let [a, b, c] = triangle;
    // The volume with an edge is the weight of the vertex opposite.
    let weights = [orient(p, q, b, c), orient(p, q, c, a), orient(p, q, a, b)];
    let inside = weights.iter().all(|w| w.is_le()) || weights.iter().all(|w| w.is_ge());
    let vertex = (0..3).find(|v| (sides.above | sides.below) >> v & 1 == 0);
    let (place, own) = match vertex {
        Some(v) => (Place::Vertex(&segment[v]), Face::vertex(v)),
        None => {
            let crossing = Crossing { ends: [p, q], divider: Divider::Plane(triangle) };
            (Place::Crossing(crossing), Face::edge(i, j))
        }
    };
    inside.then(|| (place, own, Face::with_weights(weights.map(Ordering::is_ne))))
}

/// For six vertices of one plane.
///
/// A corner of the common set is a vertex of one of the hulls, or two edges cross there.
fn coplanar_corners([a, b]: &[Hull<'_>; 2], axes: [usize; 2], found: &mut Collector) {
    for i in a.vertices() {
        if let Some(face) = b.locate(&a.triangle[i], &a.flat[i]) {
            found.push(Place::Vertex(&a.triangle[i]), [Face::vertex(i), face]);
        }
    }
    for j in b.vertices() {
        match a.locate(&b.triangle[j], &b.flat[j]) {
            // A vertex of both was found above.
            Some(face) if !face.is_vertex() => {
                found.push(Place::Vertex(&b.triangle[j]), [face, Face::vertex(j)]);
            }
            _ => {}
        }
    }
    for [p, q] in a.edges() {
        for [r, s] in b.edges() {
            if separates(&a.flat[p], &a.flat[q], &b.flat[r], &b.flat[s])
                && separates(&b.flat[r], &b.flat[s], &a.flat[p], &a.flat[q])
            {
                let crossing = Crossing {
                    ends: [&a.triangle[p], &a.triangle[q]],
                    divider: Divider::Line([&b.triangle[r], &b.triangle[s]], axes),
                };
                found.push(Place::Crossing(crossing), [Face::edge(p, q), Face::edge(r, s)]);
            }
        }
    }
}

/// Whether the line through `p` and `q` has `r` and `s` strictly on different sides.
fn separates(p: &Point2, q: &Point2, r: &Point2, s: &Point2) -> bool {
    let side = orient2d(p, q, r);
    side.is_ne() && orient2d(p, q, s) == side.reverse()
}

/// A triangle, segment or point with its image in a coordinate plane.
struct Hull<'a> {
    triangle: &'a Triangle,
    flat: [Point2; 3],
    corners: [usize; 3],
    count: usize,
    orientation: Ordering,
}

impl<'a> Hull<'a> {
    fn new(triangle: &'a Triangle, axes: [usize; 2]) -> Self {
        let flat = project(triangle, axes);
        let orientation = orient2d(&flat[0], &flat[1], &flat[2]);
        let [low, high] = extremes(triangle);
        // Seen on a plane on which it does not become a line, unless it is one.
        let (corners, count) = if orientation.is_ne() {
            ([0, 1, 2], 3)
        } else {
            ([low, high, high], if low == high { 1 } else { 2 })
        };
        Self { triangle, flat, corners, count, orientation }
    }

    fn ends(&self) -> [&'a Point; 2] {
        extremes(self.triangle).map(|i| &self.triangle[i])
    }

    fn vertices(&self) -> impl Iterator<Item = usize> {
        self.corners[..self.count].iter().copied()
    }

    fn edges(&self) -> impl Iterator<Item = [usize; 2]> {
        let [i, j, k] = self.corners;
        [[i, j], [j, k], [k, i]].into_iter().take([0, 0, 1, 3][self.count])
    }

    /// The face that a point of the plane is on, `None` outside.
    fn locate(&self, point: &Point, flat: &Point2) -> Option<Face> {
        let [i, j, _] = self.corners;
        if let Some(vertex) = self.vertices().find(|&v| self.triangle[v] == *point) {
            return Some(Face::vertex(vertex));
        }
        match self.count {
            1 => None,
            2 => {
                let (p, q) = (&self.flat[i], &self.flat[j]);
                let between = self.triangle[i] < *point && *point < self.triangle[j];
                (between && orient2d(p, q, flat).is_eq()).then(|| Face::edge(i, j))
            }
            _ => {
                let [a, b, c] = &self.flat;
                let weights = [orient2d(b, c, flat), orient2d(c, a, flat), orient2d(a, b, flat)];
                let outside = weights.contains(&self.orientation.reverse());
                (!outside).then(|| Face::with_weights(weights.map(Ordering::is_ne)))
            }
        }
    }
}

/// The axes of the coordinate plane on which the triangles' plane looks largest, of those on which
/// it is more than a line; any if all six vertices are on one line.
fn clearest_projection(a: &Triangle, b: &Triangle) -> [usize; 2] {
    let size = |axes: &[usize; 2]| {
        let area = |[p, q, r]: [Point2; 3]| {
            ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])).abs()
        };
        let [a, b] = [project(a, *axes), project(b, *axes)];
        // Of two segments that cross, one of the latter two is more than a line.
        let sizes = [a, b, [a[0], a[1], b[0]], [a[0], a[1], b[1]]].map(area);
        sizes.into_iter().fold(0.0, f64::max)
    };
    let mut projections = PROJECTIONS;
    projections.sort_by(|p, q| size(q).total_cmp(&size(p)));
    let is_clear =
        |axes: &[usize; 2]| !collinear([project(a, *axes), project(b, *axes)].as_flattened());
    projections.into_iter().find(is_clear).unwrap_or(PROJECTIONS[0])
}

/// The numbers of the first and the last vertex in lexicographic order, in which collinear points
/// follow their line.
fn extremes(triangle: &Triangle) -> [usize; 2] {
    let mut ends = [0; 2];
    for i in 1..3 {
        if triangle[i] < triangle[ends[0]] {
            ends[0] = i;
        }
        if triangle[i] > triangle[ends[1]] {
            ends[1] = i;
        }
    }
    ends
}

fn orient(a: &Point, b: &Point, c: &Point, d: &Point) -> Ordering {
    orient3d(a, b, c, d, &StaticFilter::OFF)
}
