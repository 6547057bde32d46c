//! How far two closed triangles are from each other, and where.
//!
//! The least distance of two triangles that share no point is that of a vertex and a face or of two
//! edges. For each such pair of features one pair of points is computed that lies on them whatever
//! rounding does, parameters being clamped, and the least of all wins: there are no cases to decide,
//! and so none to decide wrongly.

mod features;
#[cfg(test)]
mod tests;

use super::boxes::bounds;
use super::contact::certified;
use super::predicates::{StaticFilter, power_of_two, sub};
use super::triangle::triangles_intersect;
use super::{Point, Triangle};
use features::{Edge, Face, Least};

/// Where two triangles are nearest; in the unit of their coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    pub distance: f64,
    /// On the first triangle and on the second, to within rounding; each within its triangle's
    /// bounds, and one point twice where they meet.
    pub points: [Point; 2],
}

/// Bound on the error of [`triangle_distance`], relative to the longest side of the box around both
/// triangles.
///
/// With u = 2^-53 and that side as the unit, vertices taken from a common origin are off by u and
/// points made of them by less than 16u. That a pair of points is not quite the nearest of its
/// features adds as little, however small an angle or thin a face is:
/// - A parameter along an edge comes from a projection on this edge alone. Its error moves the point
///   by less than 8u.
/// - Of two edges that enclose an angle a, the first point comes from the normal of both. A rounding
///   of vectors in their plane moves it by some u/sin a, which changes its distance from the line of
///   the other edge by some u. That the normal itself is off by some u/sin a turns a distance h by
///   as much, and moves the point so far that its distance from the other line grows to
///   sqrt(h^2 + e^2), where e is less than both h u/sin a and sin a, as the point stays on its edge:
///   e^2 is less than h u, and the distance grows by less than u.
/// - The foot of a vertex on a face is found likewise on the two sides that meet the longest one,
///   and then by a projection along the longest one.
///
/// All together is less than 128u.
pub const RELATIVE_ERROR: f64 = power_of_two(-46);

/// The distance is 0 iff the closed triangles share a point, which is decided exactly, as
/// [`triangles_intersect`] does. Otherwise it is off by at most [`RELATIVE_ERROR`] times the longest
/// side of the box around both and the least positive number; infinite if it overflows. A degenerate
/// triangle is the segment or point that its vertices span. All coordinates finite.
pub fn triangle_distance(a: &Triangle, b: &Triangle) -> Nearest {
    let (low, high) = bounds(a.iter().chain(b));
    let extent = sub(&high, &low);
    if triangles_intersect(a, b, &StaticFilter::for_extent(extent)) {
        let contact = certified(a, b).expect("both decide exactly whether there is a common point");
        return Nearest { distance: 0.0, points: [contact.corners()[0]; 2] };
    }
    let frame = Frame::new(a[0], extent);
    let [local_a, local_b] = [a, b].map(|triangle| triangle.map(|p| frame.enter(&p)));
    let least = least_of_features(&local_a, &local_b);
    let [p, q] = least.points;
    Nearest {
        distance: frame.length(least.squared.sqrt()).max(f64::from_bits(1)),
        points: [clamped(frame.leave(&p), a), clamped(frame.leave(&q), b)],
    }
}

fn least_of_features(a: &Triangle, b: &Triangle) -> Least {
    let [edges_a, edges_b] = [a, b].map(Edge::all);
    let mut least = Least::NONE;
    for p in a {
        edges_b.iter().for_each(|edge| least.offer(*p, edge.nearest(p)));
    }
    for q in b {
        edges_a.iter().for_each(|edge| least.offer(edge.nearest(q), *q));
    }
    for first in &edges_a {
        edges_b.iter().for_each(|second| least.offer_crossing(first, second));
    }
    if let Some(face) = Face::of(&edges_b) {
        a.iter().for_each(|p| least.offer(*p, face.nearest(p)));
    }
    if let Some(face) = Face::of(&edges_a) {
        b.iter().for_each(|q| least.offer(face.nearest(q), *q));
    }
    least
}

/// Coordinates from a vertex, of the order of 1, so that no product of four over- or underflows that
/// would matter.
struct Frame {
    origin: Point,
    /// Powers of two. The first is less than 1 where differences of coordinates could overflow.
    before: f64,
    after: f64,
}

impl Frame {
    fn new(origin: Point, extent: Point) -> Self {
        let longest = extent.iter().fold(0.0, |most: f64, &side| most.max(side));
        let before = if longest > power_of_two(1000) { power_of_two(-30) } else { 1.0 };
        let longest = longest.min(f64::MAX) * before;
        let exponent = ((longest.to_bits() >> 52) & 0x7ff) as i32 - 1023;
        Self { origin, before, after: power_of_two(-exponent.clamp(-1000, 1000)) }
    }

    fn enter(&self, p: &Point) -> Point {
        [0, 1, 2].map(|k| (p[k] * self.before - self.origin[k] * self.before) * self.after)
    }

    fn length(&self, local: f64) -> f64 {
        local / self.after / self.before
    }

    fn leave(&self, p: &Point) -> Point {
        [0, 1, 2].map(|k| (self.origin[k] * self.before + p[k] / self.after) / self.before)
    }
}

fn clamped(p: Point, triangle: &Triangle) -> Point {
    let (low, high) = bounds(triangle);
    [0, 1, 2].map(|k| p[k].clamp(low[k], high[k]))
}
