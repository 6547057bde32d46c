//! The last number before a contact and the first with it.

use bumper::geometry::Triangle;
use proptest::prelude::*;

use super::construction::contact;
use super::oracle::hulls_meet;
use super::pairs::{anywhere, at, of_any_dimension, weights};
use super::{assert_answer, config};

/// Position of `x` among all f64 in rising order, and back.
fn rank(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    if bits < 0 { i64::MIN - bits } else { bits }
}

fn of_rank(rank: i64) -> f64 {
    f64::from_bits(if rank < 0 { (i64::MIN - rank) as u64 } else { rank as u64 })
}

/// Bisects one coordinate of `b` between where it is, in contact, and `away`, where it is not, to
/// two neighbouring numbers, and asks about both.
fn assert_boundary(
    a: &Triangle,
    b: &Triangle,
    (vertex, axis): (usize, usize),
    away: f64,
) -> Result<(), TestCaseError> {
    let with = |coordinate: i64| {
        let mut b = *b;
        b[vertex][axis] = of_rank(coordinate);
        b
    };
    let mut limits = [rank(b[vertex][axis]), rank(away)];
    prop_assume!(hulls_meet(a, &with(limits[0])) && !hulls_meet(a, &with(limits[1])));
    while limits[0].abs_diff(limits[1]) > 1 {
        let middle = limits[0].midpoint(limits[1]);
        limits[usize::from(!hulls_meet(a, &with(middle)))] = middle;
    }
    assert_answer(a, &with(limits[0]), true)?;
    assert_answer(a, &with(limits[1]), false)
}

proptest! {
    #![proptest_config(config(150))]

    #[test]
    fn neighbours_on_either_side_of_any_contact(
        a in of_any_dimension(), b in anywhere(), w in weights(), away in -4.0..4.0,
        axis in 0..3_usize,
    ) {
        assert_boundary(&a, &[at(&a, w), b[1], b[2]], (0, axis), away)?;
    }

    #[test]
    fn neighbours_on_either_side_of_a_contact_by_construction(
        (a, b, _) in contact(), vertex in 0..3_usize, axis in 0..3_usize, sign: bool,
    ) {
        let size = a.iter().chain(&b).flatten().fold(0.0_f64, |m, c| m.max(c.abs()));
        let away = if sign { 8.0 * size } else { -8.0 * size };
        assert_boundary(&a, &b, (vertex, axis), away)?;
    }
}
