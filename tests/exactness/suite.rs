//! The exactness contract on the packed hard cases.

use bumper::geometry::triangle::{StaticFilter, triangles_intersect};
use bumper::geometry::{Pose, Triangle};
use bumper::hardcases::{PairCase, mesh_cases, pair_cases, transform_cases};

use super::oracle::{brute_force_pairs, hulls_meet, tight_filter};

const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// Panics with the number of cases that have a wrong answer, by family.
fn assert_all_right<'a, I: IntoIterator<Item = bool>>(
    cases: &'a [PairCase],
    answers: impl Fn(&'a PairCase) -> I,
) {
    assert_eq!(cases.len(), 12_800);
    let mut wrong = std::collections::BTreeMap::new();
    for case in cases {
        if answers(case).into_iter().any(|answer| answer != case.intersect()) {
            *wrong.entry(&case.family).or_insert(0) += 1;
        }
    }
    assert!(wrong.is_empty(), "wrong answers by family: {wrong:?}");
}

fn filter_of(case: &PairCase) -> StaticFilter {
    tight_filter(case.a.iter().chain(&case.b))
}

#[test]
fn all_12800_pairs_are_right() {
    assert_all_right(&pair_cases(), |case| {
        [triangles_intersect(&case.a, &case.b, &filter_of(case))]
    });
}

#[test]
fn pairs_are_right_with_a_wide_filter_and_with_none() {
    let cases = pair_cases();
    let wide = StaticFilter::for_extent([1e3, 1e5, 1e7]);
    let holds = |case: &PairCase| {
        case.a.iter().chain(&case.b).flatten().all(|coordinate| coordinate.abs() <= 500.0)
    };
    assert!(cases.iter().filter(|case| holds(case)).count() > 5_000);
    assert_all_right(&cases, |case| {
        let filter = if holds(case) { wide } else { filter_of(case) };
        [filter, StaticFilter::OFF].map(|filter| triangles_intersect(&case.a, &case.b, &filter))
    });
}

#[test]
fn pairs_are_right_with_vertices_permuted_and_operands_swapped() {
    assert_all_right(&pair_cases(), |case| {
        let filter = filter_of(case);
        let swapped = move |a, b| {
            [triangles_intersect(&a, &b, &filter), triangles_intersect(&b, &a, &filter)]
        };
        ORDERS.into_iter().flat_map(move |of_a| {
            let a = of_a.map(|i| case.a[i]);
            ORDERS.into_iter().flat_map(move |of_b| swapped(a, of_b.map(|i| case.b[i])))
        })
    });
}

#[test]
fn pairs_are_right_with_axes_permuted_and_negated() {
    assert_all_right(&pair_cases(), |case| {
        ORDERS.into_iter().flat_map(move |order| {
            (0..8).map(move |mirror: u32| {
                let sign = |k: usize| if mirror >> k & 1 == 1 { -1.0 } else { 1.0 };
                let turn = |t: &Triangle| t.map(|p| [0, 1, 2].map(|k| p[order[k]] * sign(k)));
                let (a, b) = (turn(&case.a), turn(&case.b));
                triangles_intersect(&a, &b, &tight_filter(a.iter().chain(&b)))
            })
        })
    });
}

#[test]
fn oracle_agrees_with_the_truth() {
    assert_all_right(&pair_cases(), |case| [hulls_meet(&case.a, &case.b)]);
}

#[test]
fn all_60_mesh_pairs_give_their_listed_contacts() {
    let cases = mesh_cases();
    assert_eq!(cases.len(), 60);
    assert_eq!(cases.iter().map(|case| case.pairs.len()).sum::<usize>(), 20_388);
    for case in cases {
        let pose = Pose::from_quaternion(case.quaternion, case.pose.translation);
        assert_eq!(pose, case.pose, "{}", case.name);
        let (fixed, moving): (Vec<_>, Vec<_>) =
            (case.fixed.triangles().collect(), case.moving.triangles().collect());
        assert!(brute_force_pairs(&fixed, &moving, &pose) == case.pairs, "{}", case.name);
    }
}

#[test]
fn all_2000_poses_place_their_points_bit_for_bit() {
    let cases = transform_cases();
    assert_eq!(cases.len(), 2_000);
    for (number, case) in cases.iter().enumerate() {
        let pose = Pose::from_quaternion(case.quaternion, case.translation);
        assert_eq!(pose.rotation.map(f64::to_bits), case.rotation.map(f64::to_bits), "{number}");
        let placed = pose.apply(case.point);
        assert_eq!(placed.map(f64::to_bits), case.placed.map(f64::to_bits), "{number}");
    }
}
