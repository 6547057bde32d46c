//! When does a moving vertex meet a moving triangle, or a moving edge another?
//!
//! Every vertex moves on the straight line (1-t) start + t end, t in the closed [0, 1]; the hulls
//! are closed and may be degenerate at any time. Whether there is a contact is answered exactly:
//! neither missed nor invented.
//!
//! Both queries are one: does the convex polygon of the differences of their corners (triangle minus
//! vertex; edge minus edge, a parallelogram) contain the origin? It does at a time at which
//! 1. the volume of its first three corners is zero, which is a cubic in t: polygon and origin are
//!    in a plane;
//! 2. on no axis the corners lie all strictly on one side of the origin;
//! 3. on no axis two cross products of neighbouring corners have opposite signs: the origin is not
//!    to the left of one edge and to the right of another. These are quadratics in t.
//!
//! That holds for degenerate polygons too. If all corners are on a line that misses the origin, the
//! cross products add up to zero and are not all zero, which the third condition excludes, unless
//! the corners are equal, which the second does. On a line through the origin all cross products
//! are zero, and the second condition is the whole truth.
//!
//! `certified` decides in f64 what bounds on rounding allow, `exact` the rest in integers.
//! Published methods for the same queries: Provot 1997 (the cubic); Brochu, Edwards & Bridson 2012
//! (exact parity, which counts even numbers of contacts as none); Wang et al. 2021 (inclusion,
//! conservative).

mod certified;
mod exact;
mod polynomial;

use std::array;

use self::certified::Answer;
use super::Point;
use super::predicates::sub;

/// A closed interval, within [0, 1], that contains the first time of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeOfImpact {
    pub earliest: f64,
    pub latest: f64,
}

/// The first contact of vertex p with triangle v0 v1 v2, given p v0 v1 v2, or `None` if there is
/// none.
///
/// The tolerance is the widest interval that is good enough, as a part of the whole motion; below
/// 2^-53 it counts as that. It has no influence on whether there is a contact. Coordinates are
/// finite.
pub fn vertex_face(start: &[Point; 4], end: &[Point; 4], tolerance: f64) -> Option<TimeOfImpact> {
    first_contact(&triangle_minus_vertex([start, end]), tolerance)
}

/// As [`vertex_face`], of edge a0 a1 with edge b0 b1, given a0 a1 b0 b1.
pub fn edge_edge(start: &[Point; 4], end: &[Point; 4], tolerance: f64) -> Option<TimeOfImpact> {
    first_contact(&edge_minus_edge([start, end]), tolerance)
}

/// [`vertex_face`] by its last stage alone: slow, and without any rounding.
pub fn vertex_face_in_integers(
    start: &[Point; 4],
    end: &[Point; 4],
    tolerance: f64,
) -> Option<TimeOfImpact> {
    exact::first_contact(&triangle_minus_vertex([start, end]), tolerance)
}

/// [`edge_edge`] by its last stage alone: slow, and without any rounding.
pub fn edge_edge_in_integers(
    start: &[Point; 4],
    end: &[Point; 4],
    tolerance: f64,
) -> Option<TimeOfImpact> {
    exact::first_contact(&edge_minus_edge([start, end]), tolerance)
}

/// The corners of a convex polygon in cyclic order, at the start and at the end, each as the two
/// points whose difference it is.
type Differences<'a, const N: usize> = [[[&'a Point; 2]; N]; 2];

fn triangle_minus_vertex<'a>(ends: [&'a [Point; 4]; 2]) -> Differences<'a, 3> {
    ends.map(|[p, v0, v1, v2]| [[v0, p], [v1, p], [v2, p]])
}

/// The volume of any three corners is that of the four vertices, up to its sign.
fn edge_minus_edge<'a>(ends: [&'a [Point; 4]; 2]) -> Differences<'a, 4> {
    ends.map(|[a0, a1, b0, b1]| [[a0, b0], [a1, b0], [a1, b1], [a0, b1]])
}

#[inline]
fn first_contact<const N: usize>(
    differences: &Differences<'_, N>,
    tolerance: f64,
) -> Option<TimeOfImpact> {
    let corners: [[Point; N]; 2] = array::from_fn(|end| {
        array::from_fn(|i| {
            let [minuend, subtrahend] = differences[end][i];
            sub(minuend, subtrahend)
        })
    });
    match certified::first_contact(&corners, tolerance) {
        Answer::Apart => None,
        Answer::Contact(time) => Some(time),
        Answer::Unsure => exact::first_contact(differences, tolerance),
    }
}
