//! What must not change an answer, or only its numbering: bit for bit, in every way.

use bumper::geometry::{Point, Pose, Triangle};
use bumper::tree::descent::Pair;
use proptest::prelude::*;

use super::construction::contact;
use super::oracle::brute_force_pairs;
use super::pairs::{anywhere, of_any_dimension, on_grid};
use super::{assert_pairs, config};

type Soup = Vec<Triangle>;

fn soup(triangle: impl Strategy<Value = Triangle>) -> impl Strategy<Value = Soup> {
    prop::collection::vec(triangle, 1..20)
}

/// Loose ones, and ones of which most touch.
fn soups() -> impl Strategy<Value = [Soup; 2]> {
    prop_oneof![
        (soup(anywhere()), soup(of_any_dimension())).prop_map(|(a, b)| [a, b]),
        (soup(on_grid()), soup(on_grid())).prop_map(|(a, b)| [a, b]),
        prop::collection::vec(contact(), 1..20).prop_map(|cases| {
            let (a, b) = cases.into_iter().map(|(a, b, _)| (a, b)).unzip();
            [a, b]
        }),
    ]
}

fn mapped(soup: &[Triangle], map: impl Fn(Point) -> Point) -> Soup {
    soup.iter().map(|t| t.map(&map)).collect()
}

fn at_rest([fixed, moving]: &[Soup; 2]) -> Vec<Pair> {
    brute_force_pairs(fixed, moving, &Pose::IDENTITY)
}

fn sorted(pairs: impl Iterator<Item = Pair>) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = pairs.collect();
    pairs.sort_unstable();
    pairs
}

fn assert_at_rest(expected: &[Pair], fixed: &[Triangle], moving: &[Triangle]) {
    assert_pairs(expected, fixed, moving, &Pose::IDENTITY);
}

const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// The numbers 0..n in an order that follows from the seed.
fn shuffled(n: usize, seed: u64) -> Vec<u32> {
    let key =
        |i: u32| (u64::from(i) + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut numbers: Vec<u32> = (0..n as u32).collect();
    numbers.sort_by_key(|&i| (key(i) >> 20, i));
    numbers
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn swapped_operands_swap_the_pairs(soups in soups()) {
        let swapped = sorted(at_rest(&soups).into_iter().map(|[i, j]| [j, i]));
        assert_at_rest(&swapped, &soups[1], &soups[0]);
    }

    #[test]
    fn permuted_vertices_and_triangles_renumber_the_pairs(soups in soups(), seed: u64) {
        let orders = soups.each_ref().map(|soup| shuffled(soup.len(), seed));
        let permuted = [0, 1].map(|side| -> Soup {
            let corners = |i: u32| ORDERS[(seed >> (i % 50)) as usize % 6];
            let triangle = |&i: &u32| corners(i).map(|corner| soups[side][i as usize][corner]);
            orders[side].iter().map(triangle).collect()
        });
        let now = |side: usize, i: u32| orders[side].iter().position(|&was| was == i).unwrap() as u32;
        let expected = at_rest(&soups).into_iter().map(|[i, j]| [now(0, i), now(1, j)]);
        assert_at_rest(&sorted(expected), &permuted[0], &permuted[1]);
    }

    #[test]
    fn permuted_and_reflected_axes_change_nothing(
        soups in soups(), order in prop::sample::select(&ORDERS), mirror in 0..8_u32,
    ) {
        let sign = |k: usize| if mirror >> k & 1 == 1 { -1.0 } else { 1.0 };
        let turned = soups.each_ref().map(|s| mapped(s, |p| [0, 1, 2].map(|k| p[order[k]] * sign(k))));
        assert_at_rest(&at_rest(&soups), &turned[0], &turned[1]);
    }

    #[test]
    fn scaling_by_powers_of_two_changes_nothing(soups in soups(), exponent in -60..60_i32) {
        let factor = 2_f64.powi(exponent);
        let is_exact = |c: f64| c == 0.0 || (c * factor).is_normal() && c * factor / factor == c;
        prop_assume!(soups.iter().flatten().flatten().flatten().all(|&c| is_exact(c)));
        let scaled = soups.each_ref().map(|s| mapped(s, |p| p.map(|c| c * factor)));
        assert_at_rest(&at_rest(&soups), &scaled[0], &scaled[1]);
    }

    /// Only where it rounds nothing. The moving soup comes to its place by a pose as well.
    #[test]
    fn exact_translation_changes_nothing(
        fixed in soup(on_grid()), moving in soup(on_grid()), exponent in -2..50, axis in 0..3_usize,
    ) {
        let soups = [fixed, moving];
        let mut shift = [0.0; 3];
        shift[axis] = 2_f64.powi(exponent);
        let shifted = soups.each_ref().map(|s| mapped(s, |p| [0, 1, 2].map(|k| p[k] + shift[k])));
        let expected = at_rest(&soups);
        assert_at_rest(&expected, &shifted[0], &shifted[1]);
        let pose = Pose { translation: shift, ..Pose::IDENTITY };
        assert_pairs(&expected, &shifted[0], &soups[1], &pose);
    }

    /// Corners are even, so that middles of edges are exact.
    #[test]
    fn the_halves_of_a_triangle_meet_what_it_meets(
        fixed in soup(on_grid()), moving in soup(on_grid()), edge in 0..3_usize,
    ) {
        let fixed = mapped(&fixed, |p| p.map(|c| 2.0 * c));
        let half = |keep: usize| fixed.iter().map(move |t| {
            let (from, to) = (t[edge], t[(edge + 1) % 3]);
            let mut half = *t;
            half[(edge + keep) % 3] = [0, 1, 2].map(|k| 0.5 * (from[k] + to[k]));
            half
        });
        let halves: Soup = half(0).chain(half(1)).collect();
        let count = fixed.len() as u32;
        for (way, found) in super::in_every_way(&halves, &moving, &Pose::IDENTITY) {
            let mut of_whole = sorted(found.into_iter().map(|[i, j]| [i % count, j]));
            of_whole.dedup();
            prop_assert!(of_whole == brute_force_pairs(&fixed, &moving, &Pose::IDENTITY), "{way}");
        }
    }

    #[test]
    fn triangles_far_away_change_nothing(
        soups in soups(), strangers in soup(anywhere()),
        far in prop::sample::select(&[1e3, 1e6, 1e12, 1e60, 1e150, 1e300]),
    ) {
        let size = soups.iter().flatten().flatten().flatten().fold(1.0_f64, |m, c| m.max(c.abs()));
        prop_assume!(size < 1e290 / far);
        let with = |soup: &Soup, shift: f64| -> Soup {
            let away = mapped(&strangers, |p| p.map(|c| size * far * (shift + c)));
            soup.iter().copied().chain(away).collect()
        };
        let expected = at_rest(&soups);
        assert_at_rest(&expected, &with(&soups[0], 3.0), &with(&soups[1], -3.0));
        assert_at_rest(&expected, &with(&soups[0], 3.0), &soups[1]);
    }
}
