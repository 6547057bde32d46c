//! What two triangles that meet have in common: a point, a segment or a convex polygon, with a
//! bound on the error of its corners.
//!
//! Which features of the triangles make a corner (a vertex, or an edge that crosses a plane or an
//! edge) follows from exact signs alone, as the answer of [`triangles_intersect`] does. Only then is
//! the corner's place computed: in f64 with a running bound on its error, or, where that is poor,
//! in integers without limit and rounded once.
//!
//! [`triangles_intersect`]: super::triangle::triangles_intersect

mod bounded;
mod collect;
mod crossing;
pub mod curves;
mod exact;
mod flat;
mod plain;
mod planes;
mod shape;

pub use plain::{plain_f32, plain_f64};
pub use shape::{Corners, Face, Kind};

use super::boxes::bounds;
use super::predicates::{Plane, Sides, StaticFilter};
use super::{Point, Triangle};
use collect::Collector;

/// What two triangles have in common; coordinates and the error in the unit of the triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    corners: Corners,
    faces: [[Face; 2]; Corners::MOST],
    error: f64,
}

impl Contact {
    /// In order round a polygon, either way; no two stand for the same point.
    pub fn corners(&self) -> &[Point] {
        self.corners.points()
    }

    /// For each corner the smallest face of `a`, and of `b`, that it lies on.
    ///
    /// Exact, and the same for every pair of triangles that share the two faces: ends of segments
    /// can be joined by it. Only of a triangle without area, a vertex between its ends may be
    /// reported as the edge between these.
    pub fn faces(&self) -> &[[Face; 2]] {
        &self.faces[..self.corners.points().len()]
    }

    /// No corner is farther than this from the true one. Zero if all are vertices; finite always.
    pub fn error(&self) -> f64 {
        self.error
    }

    pub fn kind(&self) -> Kind {
        self.corners.kind()
    }
}

/// The common set of the closed hulls of `a` and `b`, all coordinates finite; `None` iff they are
/// apart, in agreement with [`triangles_intersect`](super::triangle::triangles_intersect).
///
/// Let S be the common set of the two hulls of exactly these f64 vertices, which is convex. The
/// corners of S are as many as those reported, and in the order reported (or against it) each is
/// at most [`Contact::error`] away from its own, in Euclidean distance. So S has the kind that
/// is reported, and lies, point for point, within the error of the reported one.
///
/// In ordinary cases the error is a few units in the last place of the coordinates; it is at most
/// 2^-39 of the triangles' extent, plus four such units. About twice the time of
/// [`plain_f64`], and some microseconds a corner where only integers reach that bound
/// (`benches/contact.rs`).
pub fn certified(a: &Triangle, b: &Triangle) -> Option<Contact> {
    let (low, high) = bounds(a.iter().chain(b));
    let extent = [0, 1, 2].map(|k| high[k] - low[k]);
    let filter = StaticFilter::for_extent(extent);
    let sides_b = Plane::through(a).sides(b, &filter);
    if sides_b.strictly_one() {
        return None;
    }
    let sides_a = Plane::through(b).sides(a, &filter);
    if sides_a.strictly_one() {
        return None;
    }
    let mut corners = Collector::for_extent(extent);
    let sides = [sides_a, sides_b];
    if sides.contains(&Sides::ON_PLANE) {
        flat::corners([a, b], sides, &mut corners);
    } else {
        planes::corners([a, b], sides, &filter, &mut corners);
    }
    corners.contact()
}
