//! What must not change an answer.

use bumper::geometry::Point;
use proptest::prelude::*;

use super::{Kind, config, kinds, motions};

/// Orders of the vertices that mean the same query.
fn same(kind: Kind) -> impl Strategy<Value = [usize; 4]> {
    let orders = match kind {
        Kind::VertexFace => vec![[0, 2, 3, 1], [0, 1, 3, 2], [0, 3, 2, 1]],
        Kind::EdgeEdge => vec![[2, 3, 0, 1], [1, 0, 2, 3], [0, 1, 3, 2], [3, 2, 1, 0]],
    };
    prop::sample::select(orders)
}

fn is_contact(kind: Kind, motion: &[[Point; 4]; 2]) -> bool {
    kind.query()(&motion[0], &motion[1], 1e-9).is_some()
}

proptest! {
    #![proptest_config(config(2_000))]

    #[test]
    fn time_may_run_backwards(kind in kinds(), [start, end] in motions()) {
        prop_assert_eq!(is_contact(kind, &[start, end]), is_contact(kind, &[end, start]));
    }

    /// Far beyond what f64 can square.
    #[test]
    fn a_power_of_two_on_each_axis_changes_nothing(
        kind in kinds(),
        motion in motions(),
        exponents in prop::array::uniform3(-1000..=1000_i32),
    ) {
        let factors = exponents.map(|e| 2_f64.powi(e));
        let scale = |p: Point| [p[0] * factors[0], p[1] * factors[1], p[2] * factors[2]];
        let scaled = motion.map(|end| end.map(scale));
        prop_assert_eq!(is_contact(kind, &motion), is_contact(kind, &scaled));
    }

    #[test]
    fn vertices_may_be_named_in_any_order(
        (kind, order) in kinds().prop_flat_map(|kind| (Just(kind), same(kind))),
        motion in motions(),
    ) {
        let renamed = motion.map(|end| order.map(|i| end[i]));
        prop_assert_eq!(is_contact(kind, &motion), is_contact(kind, &renamed));
    }

    #[test]
    fn axes_may_be_swapped_and_turned(kind in kinds(), motion in motions(), k in 0..3_usize) {
        let turned = motion.map(|end| end.map(|p| [-p[k], p[(k + 2) % 3], p[(k + 1) % 3]]));
        prop_assert_eq!(is_contact(kind, &motion), is_contact(kind, &turned));
    }

    #[test]
    fn both_stages_say_the_same(kind in kinds(), motion in motions()) {
        let answer = kind.query()(&motion[0], &motion[1], 1e-9);
        let exact = kind.in_integers()(&motion[0], &motion[1], 0.0);
        prop_assert_eq!(answer.is_some(), exact.is_some());
        if let (Some(answer), Some(exact)) = (answer, exact) {
            prop_assert!(answer.earliest <= exact.latest && exact.earliest <= answer.latest);
        }
    }

    /// Motions of coordinates with all their digits.
    #[test]
    fn both_stages_say_the_same_of_any_numbers(
        kind in kinds(),
        motion in prop::array::uniform2(prop::array::uniform4(prop::array::uniform3(-1.0..1.0_f64))),
    ) {
        let answer = kind.query()(&motion[0], &motion[1], 1e-9);
        let exact = kind.in_integers()(&motion[0], &motion[1], 0.0);
        prop_assert_eq!(answer.is_some(), exact.is_some());
        if let (Some(answer), Some(exact)) = (answer, exact) {
            prop_assert!(answer.earliest <= exact.latest && exact.earliest <= answer.latest);
        }
    }
}
