//! What two triangles have in common, its error bounds, and its names, held against clipping in
//! fractions.

mod clipping;
mod curves;
mod properties;

use bumper::geometry::contact::{Contact, certified};
use bumper::geometry::triangle::{StaticFilter, triangles_intersect};
use bumper::geometry::{Point, Triangle};
use bumper::hardcases::pair_cases;
use clipping::CommonSet;

/// What is wrong with what [`certified`] says of two triangles, if anything.
fn fault(a: &Triangle, b: &Triangle) -> Option<String> {
    let truth = CommonSet::of(a, b);
    let contact = certified(a, b);
    if contact.is_some() != triangles_intersect(a, b, &StaticFilter::OFF) {
        return Some("disagrees with triangles_intersect".into());
    }
    let Some(contact) = contact else {
        return (!truth.corners.is_empty()).then(|| "apart, but they meet".into());
    };
    let (found, wanted) = (contact.corners().len(), truth.corners.len());
    if found != wanted {
        return Some(format!("{found} corners instead of {wanted}"));
    }
    if !(contact.error() >= 0.0 && contact.error() <= worst_error(a, b)) {
        return Some(format!("an error of {:e}", contact.error()));
    }
    (!orders(found).any(|order| is_right(&contact, &truth, [a, b], &order)))
        .then(|| format!("{contact:?} is not {truth:?}"))
}

/// Whether the corners are, in this order of the true ones, within the error and on their faces.
fn is_right(contact: &Contact, truth: &CommonSet, of: [&Triangle; 2], order: &[usize]) -> bool {
    let on_face = |corner: usize, side: usize, i: usize| {
        let vertices: Vec<usize> = contact.faces()[i][side].vertices().collect();
        truth.is_on_face(corner, of[side], &vertices)
    };
    order.iter().enumerate().all(|(i, &corner)| {
        truth.is_within(corner, contact.error(), &contact.corners()[i])
            && on_face(corner, 0, i)
            && on_face(corner, 1, i)
    })
}

/// All ways to go once round a polygon of `count` corners.
fn orders(count: usize) -> impl Iterator<Item = Vec<usize>> {
    (0..count).flat_map(move |start| {
        let forwards: Vec<usize> = (0..count).map(|i| (start + i) % count).collect();
        let backwards = forwards.iter().rev().copied().collect();
        [forwards, backwards]
    })
}

/// What the documentation promises.
fn worst_error(a: &Triangle, b: &Triangle) -> f64 {
    let points: Vec<Point> = a.iter().chain(b).copied().collect();
    let largest = points.iter().flatten().fold(0.0, |m: f64, c| m.max(c.abs()));
    let differences = points.iter().flat_map(|p| points.iter().map(move |q| (p, q)));
    let extent = differences
        .flat_map(|(p, q)| [0, 1, 2].map(|k| p[k] - q[k]))
        .fold(0.0, f64::max)
        .min(f64::MAX);
    let unit = (largest - largest.next_down()).max(f64::from_bits(1));
    2_f64.powi(-39) * extent + 4.0 * unit
}

const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

#[test]
fn all_12800_hard_pairs_have_their_kind_and_lie_within_their_error() {
    let cases = pair_cases();
    assert_eq!(cases.len(), 12_800);
    for case in cases {
        let kind = certified(&case.a, &case.b).map(|contact| contact.kind());
        assert_eq!(kind, case.common, "{}: {:?}", case.family, case);
        for [a, b] in [[&case.a, &case.b], [&case.b, &case.a]] {
            let fault = fault(a, b);
            assert!(fault.is_none(), "{}: {:?} {:?}: {fault:?}", case.family, a, b);
        }
    }
}
