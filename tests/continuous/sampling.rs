//! Positions at sampled times, where they are exact, against linear programming in integers.

use std::array;

use bumper::geometry::Point;
use proptest::prelude::*;

use super::oracle::hulls_meet;
use super::{config, kinds, motions};

const SAMPLES: u32 = 16;

/// Where the vertices are after so many sixteenths, times sixteen.
fn at([start, end]: &[[Point; 4]; 2], sample: u32) -> [Point; 4] {
    let (after, before) = (f64::from(sample), f64::from(SAMPLES - sample));
    array::from_fn(|i| array::from_fn(|k| before * start[i][k] + after * end[i][k]))
}

proptest! {
    #![proptest_config(config(2_000))]

    #[test]
    fn a_contact_at_a_sampled_time_is_never_missed(kind in kinds(), motion in motions()) {
        let answer = kind.query()(&motion[0], &motion[1], 1e-9);
        for sample in 0..=SAMPLES {
            let [a, b] = kind.hulls(at(&motion, sample));
            let time = f64::from(sample) / f64::from(SAMPLES);
            if hulls_meet(&a, &b) {
                prop_assert!(answer.is_some_and(|first| first.earliest <= time), "{answer:?}");
            } else {
                // Nothing is known of the times beside this one.
                let claimed = answer.is_some_and(|first| first.earliest == first.latest
                    && first.earliest == time);
                prop_assert!(!claimed, "{answer:?}");
            }
        }
    }

    /// A contact is put at a sampled time, and the end follows from it.
    #[test]
    fn a_contact_that_was_made_is_found(
        kind in kinds(),
        [start, other] in motions(),
        sample in 1..=SAMPLES,
        [u, v] in prop::array::uniform2(0..=8_i32),
    ) {
        // All vertices where they are to be, the first so that it touches; times sixteen.
        let mut touching = other.map(|p| p.map(|x| 64.0 * x));
        let (u, v) = (f64::from(u) / 8.0, f64::from(v.min(8 - u)) / 8.0);
        let weights = match kind {
            super::Kind::VertexFace => [1.0 - u - v, u, v],
            super::Kind::EdgeEdge => [0.0, 1.0 - u, u],
        };
        touching[0] = array::from_fn(|k| (0..3).map(|i| weights[i] * touching[i + 1][k]).sum());
        // The motion through there, stretched by the sample's number to keep it whole.
        let s = f64::from(sample);
        let from = start.map(|p| p.map(|x| s * x));
        let to = array::from_fn(|i| array::from_fn(|k| {
            f64::from(SAMPLES) * touching[i][k] - f64::from(SAMPLES - sample) * start[i][k]
        }));
        let answer = kind.query()(&from, &to, 1e-9);
        let time = s / f64::from(SAMPLES);
        prop_assert!(answer.is_some_and(|first| first.earliest <= time), "{answer:?} at {time}");
    }
}
