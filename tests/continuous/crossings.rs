//! One part stays in a plane, the other crosses it as a whole: contact is possible at one time only,
//! a fraction of whole numbers, at which linear programming in integers tells whether there is one.

use std::array;

use bumper::geometry::Point;
use proptest::prelude::*;

use super::oracle::hulls_meet;
use super::{Kind, config, kinds, of_size};

/// Volumes remain, and the plane is no longer across an axis.
fn sheared([x, y, z]: Point) -> Point {
    [x + 2.0 * y - z, y + 3.0 * z, z - x]
}

/// Vertices of the part that crosses.
fn crosses(kind: Kind, vertex: usize) -> bool {
    match kind {
        Kind::VertexFace => vertex == 0,
        Kind::EdgeEdge => vertex < 2,
    }
}

proptest! {
    #![proptest_config(config(3_000))]

    #[test]
    fn the_only_time_is_answered_as_by_linear_programming(
        kind in kinds(),
        ends in [prop_oneof![of_size(3), of_size(30)], prop_oneof![of_size(3), of_size(30)]],
        [above, below] in [0..=9_i32, 0..=9_i32],
    ) {
        let (above, below) = (f64::from(above), f64::from(below));
        prop_assume!(above + below > 0.0);
        let [start, end]: [[Point; 4]; 2] = array::from_fn(|e| array::from_fn(|i| {
            let [x, y, _] = ends[e][i];
            sheared([x, y, if crosses(kind, i) { [above, -below][e] } else { 0.0 }])
        }));
        // Times the denominator.
        let meeting = array::from_fn(|i| array::from_fn(|k| below * start[i][k] + above * end[i][k]));
        let [a, b] = kind.hulls(meeting);
        let answer = kind.query()(&start, &end, 1e-9);
        prop_assert_eq!(answer.is_some(), hulls_meet(&a, &b));
        if let Some(first) = answer {
            let time = above / (above + below);
            let slack = f64::EPSILON;
            prop_assert!(first.earliest <= time + slack && time - slack <= first.latest);
        }
    }

    /// A vertex or edge that stays in the plane of what it may meet.
    #[test]
    fn in_a_plane_both_directions_agree_with_samples(
        kind in kinds(),
        ends in [of_size(3), of_size(3)],
    ) {
        let [start, end] = ends.map(|end| end.map(|[x, y, _]| sheared([x, y, 0.0])));
        let there = kind.query()(&start, &end, 1e-9);
        let back = kind.query()(&end, &start, 1e-9);
        prop_assert_eq!(there.is_some(), back.is_some());
        for sample in 0..=12_u8 {
            let (after, before) = (f64::from(sample), f64::from(12 - sample));
            let at = array::from_fn(|i| array::from_fn(|k| before * start[i][k] + after * end[i][k]));
            let [a, b] = kind.hulls(at);
            let time = after / 12.0;
            let may_be = there.is_some_and(|first| first.earliest <= time + f64::EPSILON)
                && back.is_some_and(|last| 1.0 - last.earliest >= time - f64::EPSILON);
            prop_assert!(may_be || !hulls_meet(&a, &b), "{there:?} {back:?} at {time}");
        }
    }
}
