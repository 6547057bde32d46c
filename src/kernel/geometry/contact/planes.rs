//! Proper triangles in two planes: the common set lies on the line common to both planes.

use std::cmp::Ordering;

use super::Face;
use super::collect::Collector;
use super::crossing::{Crossing, Divider, Place};
use crate::geometry::Triangle;
use crate::geometry::predicates::{Sides, StaticFilter, orient3d};
use crate::geometry::triangle::Apex;

/// Collects the ends of the common segment, one if it is a point, none if the triangles are apart.
///
/// Each triangle meets the line in an interval that ends on the two edges at its apex (Guigue &
/// Devillers 2003); the sign of the volume of an edge of one and an edge of the other is the order
/// of the two ends. `sides`: of each triangle from the other's plane, neither all on it nor
/// strictly on one side.
#[inline]
pub fn corners(
    [a, b]: [&Triangle; 2],
    [sides_a, sides_b]: [Sides; 2],
    filter: &StaticFilter,
    found: &mut Collector,
) {
    let [apex_a, apex_b] = [sides_a, sides_b].map(Apex::of);
    // Turned so that both intervals run the same way: `a` from r to q, `b` from q to r.
    let a = Interval::new(a, b, sides_a, apex_a.first(apex_b.below));
    let b = Interval::new(b, a.triangle, sides_b, apex_b.first(apex_a.below));
    let [p1, q1, r1] = a.order;
    let [p2, q2, r2] = b.order;
    // How the end of b lies from that of a.
    let compare = |of_a: usize, of_b: usize| {
        let [a, b] = [a.triangle, b.triangle];
        orient3d(&a[p1], &a[of_a], &b[p2], &b[of_b], filter)
    };
    let (last_first, first_last) = (compare(q1, q2), compare(r1, r2));
    if last_first.is_gt() || first_last.is_lt() {
        return;
    }
    let mut push = |of_a: usize, of_b: usize, order: Ordering| match order {
        Ordering::Less => found.push(a.place(of_a), [a.end(of_a), b.inside()]),
        Ordering::Greater => found.push(b.place(of_b), [a.inside(), b.end(of_b)]),
        Ordering::Equal => {
            let of_a_is_vertex = a.end(of_a).is_vertex();
            let place = if of_a_is_vertex || !b.end(of_b).is_vertex() {
                a.place(of_a)
            } else {
                b.place(of_b)
            };
            found.push(place, [a.end(of_a), b.end(of_b)]);
        }
    };
    if last_first.is_eq() {
        return push(q1, q2, Ordering::Equal);
    }
    if first_last.is_eq() {
        return push(r1, r2, Ordering::Equal);
    }
    // The common interval begins with the later beginning and stops with the earlier stop.
    push(r1, q2, compare(r1, q2));
    if !a.is_point() && !b.is_point() {
        push(q1, r2, compare(q1, r2).reverse());
    }
}

/// What a triangle has of the line common to its plane and another's.
struct Interval<'a> {
    triangle: &'a Triangle,
    other: &'a Triangle,
    on_plane: [bool; 3],
    /// The apex first; the ends are on the edges from it to the other two.
    order: [usize; 3],
}

impl<'a> Interval<'a> {
    #[inline]
    fn new(triangle: &'a Triangle, other: &'a Triangle, sides: Sides, order: [usize; 3]) -> Self {
        let on_plane = [0, 1, 2].map(|i| (sides.above | sides.below) >> i & 1 == 0);
        Self { triangle, other, on_plane, order }
    }

    fn is_point(&self) -> bool {
        self.on_plane[self.order[0]]
    }

    /// The face that the end on the edge from the apex to vertex `x` is on.
    #[inline]
    fn end(&self, x: usize) -> Face {
        let apex = self.order[0];
        if self.on_plane[apex] {
            Face::vertex(apex)
        } else if self.on_plane[x] {
            Face::vertex(x)
        } else {
            Face::edge(apex, x)
        }
    }

    /// The face that what is between the ends is on.
    #[inline]
    fn inside(&self) -> Face {
        let [apex, q, r] = self.order;
        if self.on_plane[apex] {
            Face::vertex(apex)
        } else if self.on_plane[q] && self.on_plane[r] {
            Face::edge(q, r)
        } else {
            Face::INTERIOR
        }
    }

    #[inline]
    fn place(&self, x: usize) -> Place<'a> {
        let apex = self.order[0];
        let vertex = [apex, x].into_iter().find(|&i| self.on_plane[i]);
        match vertex {
            Some(i) => Place::Vertex(&self.triangle[i]),
            None => Place::Crossing(Crossing {
                ends: [&self.triangle[apex], &self.triangle[x]],
                divider: Divider::Plane(self.other),
            }),
        }
    }
}
