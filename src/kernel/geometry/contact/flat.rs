//! Triangles in one plane, segments and points.

use std::cmp::Ordering;

use super::Face;
use super::collect::Collector;
use super::crossing::{Crossing, Divider, Place};
use crate::geometry::coplanar::{PROJECTIONS, collinear, extremes, project};
use crate::geometry::predicates::{Certain, Point2, Sides, StaticFilter, orient2d, orient3d};
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
    if hulls.iter().all(|hull| !hull.is_proper()) {
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
    let (sides_b, sides_a) = (a.sides(b), b.sides(a));
    for i in a.vertices() {
        if let Some(face) = b.locate(&a.triangle[i], sides_a.map(|edge| edge[i])) {
            found.push(Place::Vertex(&a.triangle[i]), [Face::vertex(i), face]);
        }
    }
    for j in b.vertices() {
        match a.locate(&b.triangle[j], sides_b.map(|edge| edge[j])) {
            // A vertex of both was found above.
            Some(face) if !face.is_vertex() => {
                found.push(Place::Vertex(&b.triangle[j]), [face, Face::vertex(j)]);
            }
            _ => {}
        }
    }
    for (&[p, q], of_b) in a.edges().iter().zip(&sides_b) {
        for (&[r, s], of_a) in b.edges().iter().zip(&sides_a) {
            if opposite(of_a[p], of_a[q]) && opposite(of_b[r], of_b[s]) {
                let crossing = Crossing {
                    ends: [&a.triangle[p], &a.triangle[q]],
                    divider: Divider::Line([&b.triangle[r], &b.triangle[s]], axes),
                };
                found.push(Place::Crossing(crossing), [Face::edge(p, q), Face::edge(r, s)]);
            }
        }
    }
}

/// Whether two points are strictly on different sides.
fn opposite(side: Ordering, other: Ordering) -> bool {
    side.is_ne() && side == other.reverse()
}

/// A triangle, segment or point with its image in a coordinate plane.
struct Hull<'a> {
    triangle: &'a Triangle,
    flat: [Point2; 3],
    orientation: Ordering,
    /// The first and the last vertex in lexicographic order.
    ends: [usize; 2],
}

impl<'a> Hull<'a> {
    /// `axes`: of a plane on which the triangle does not become a line, unless it is one.
    fn new(triangle: &'a Triangle, axes: [usize; 2]) -> Self {
        let flat = project(triangle, axes);
        let orientation = orient2d(&flat[0], &flat[1], &flat[2]);
        Self { triangle, flat, orientation, ends: extremes(triangle) }
    }

    fn is_proper(&self) -> bool {
        self.orientation.is_ne()
    }

    fn ends(&self) -> [&'a Point; 2] {
        self.ends.map(|i| &self.triangle[i])
    }

    fn vertices(&self) -> impl Iterator<Item = usize> {
        let is_corner = |i: &usize| self.is_proper() || self.ends.contains(i);
        (0..3).filter(is_corner)
    }

    /// Of a proper triangle the edge opposite each vertex.
    fn edges(&self) -> &[[usize; 2]] {
        const OPPOSITE: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];
        if self.is_proper() { &OPPOSITE } else { std::slice::from_ref(&self.ends) }
    }

    /// On which side of each edge the other's vertices are.
    fn sides(&self, other: &Hull<'_>) -> [[Ordering; 3]; 3] {
        let mut sides = [[Ordering::Equal; 3]; 3];
        for (side, &[p, q]) in sides.iter_mut().zip(self.edges()) {
            *side = other.flat.each_ref().map(|r| orient2d(&self.flat[p], &self.flat[q], r));
        }
        sides
    }

    /// The face that a point of the plane is on, `None` outside; `sides`: of each edge.
    fn locate(&self, point: &Point, sides: [Ordering; 3]) -> Option<Face> {
        if self.is_proper() {
            // The area with an edge is the weight of the vertex opposite.
            let is_outside = sides.contains(&self.orientation.reverse());
            return (!is_outside).then(|| Face::with_weights(sides.map(Ordering::is_ne)));
        }
        let [low, high] = self.ends();
        if let Some(end) = self.ends.into_iter().find(|&i| self.triangle[i] == *point) {
            return Some(Face::vertex(end));
        }
        let is_between = low < point && point < high && sides[0].is_eq();
        is_between.then(|| Face::edge(self.ends[0], self.ends[1]))
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
    let mut projections = PROJECTIONS.map(|axes| (size(&axes), axes));
    projections.sort_by(|p, q| q.0.total_cmp(&p.0));
    let is_clear = |axes: &[usize; 2]| {
        let points = [project(a, *axes), project(b, *axes)];
        !collinear(points.as_flattened(), Certain::new(&StaticFilter::OFF))
    };
    let mut projections = projections.into_iter().map(|(_, axes)| axes);
    projections.find(is_clear).unwrap_or(PROJECTIONS[0])
}

fn orient(a: &Point, b: &Point, c: &Point, d: &Point) -> Ordering {
    orient3d(a, b, c, d, &StaticFilter::OFF)
}
