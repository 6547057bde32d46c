//! Against the true distance in integers without limit.

use num_bigint::BigInt;
use proptest::prelude::*;

use super::*;
use crate::geometry::predicates::integer::decompose;

type Integers = [BigInt; 3];

/// A square of a distance as a fraction with a positive denominator, in squares of 2^-1074.
#[derive(Clone)]
struct Fraction(BigInt, BigInt);

impl Fraction {
    fn is_less(&self, other: &Self) -> bool {
        &self.0 * &other.1 < &other.0 * &self.1
    }

    /// Of the least, over all pairs of features, of the distances of the points where their lines or
    /// planes are nearest, as long as those are on the features. For triangles that do not meet.
    fn true_distance(a: &Triangle, b: &Triangle) -> Self {
        let [a, b] = [a, b].map(|triangle| triangle.map(|p| p.map(integer)));
        let mut all = Vec::new();
        for (p, q) in a.iter().flat_map(|p| b.iter().map(move |q| (p, q))) {
            let between = minus(p, q);
            all.push(Self(times(&between, &between), 1.into()));
        }
        for (one, other) in [(&a, &b), (&b, &a)] {
            for p in one {
                all.extend((0..3).filter_map(|i| of_line(p, &other[i], &other[(i + 1) % 3])));
                all.extend(of_plane(p, other));
            }
        }
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            all.extend(of_lines([&a[i], &a[(i + 1) % 3]], [&b[j], &b[(j + 1) % 3]]));
        }
        let least = |least: Self, next: Self| if next.is_less(&least) { next } else { least };
        all.into_iter().reduce(least).expect("there are nine distances of vertices")
    }
}

fn integer(x: f64) -> BigInt {
    let (mantissa, exponent) = decompose(x);
    BigInt::from(mantissa) << exponent
}

fn minus(p: &Integers, q: &Integers) -> Integers {
    [0, 1, 2].map(|k| &p[k] - &q[k])
}

fn times(p: &Integers, q: &Integers) -> BigInt {
    (0..3).map(|k| &p[k] * &q[k]).sum()
}

fn normal_of(p: &Integers, q: &Integers) -> Integers {
    [(1, 2), (2, 0), (0, 1)].map(|(i, j)| &p[i] * &q[j] - &p[j] * &q[i])
}

fn of_line(p: &Integers, from: &Integers, to: &Integers) -> Option<Fraction> {
    let (along, between) = (minus(to, from), minus(p, from));
    let (squared, part) = (times(&along, &along), times(&between, &along));
    let is_inside = part > BigInt::ZERO && part < squared;
    is_inside.then(|| Fraction(times(&between, &between) * &squared - &part * &part, squared))
}

fn of_plane(p: &Integers, [a, b, c]: &[Integers; 3]) -> Option<Fraction> {
    let normal = normal_of(&minus(b, a), &minus(c, a));
    let squared = times(&normal, &normal);
    let is_inside = [(a, b), (b, c), (c, a)].iter().all(|(from, to)| {
        times(&normal_of(&minus(to, from), &minus(p, from)), &normal) >= BigInt::ZERO
    });
    let along = times(&minus(p, a), &normal);
    (squared > BigInt::ZERO && is_inside).then(|| Fraction(&along * &along, squared))
}

fn of_lines([a, b]: [&Integers; 2], [c, d]: [&Integers; 2]) -> Option<Fraction> {
    let (first, second, between) = (minus(b, a), minus(d, c), minus(c, a));
    let normal = normal_of(&first, &second);
    let squared = times(&normal, &normal);
    let at = [&second, &first].map(|other| times(&normal_of(&between, other), &normal));
    let is_inside = at.iter().all(|at| *at >= BigInt::ZERO && *at <= squared);
    let along = times(&between, &normal);
    (squared > BigInt::ZERO && is_inside).then(|| Fraction(&along * &along, squared))
}

fn longest_side(a: &Triangle, b: &Triangle) -> f64 {
    let (low, high) = bounds(a.iter().chain(b));
    sub(&high, &low).into_iter().fold(0.0, f64::max)
}

/// Whether the distance is within `error` of the true one.
fn is_right(distance: f64, error: f64, truth: &Fraction) -> bool {
    let square = |x: f64| Fraction(integer(x) * integer(x), 1.into());
    let not_above = distance <= error || !truth.is_less(&square((distance - error).next_down()));
    not_above && !square((distance + error).next_up()).is_less(truth)
}

fn check(a: &Triangle, b: &Triangle, allowed: f64) {
    let Nearest { distance, points } = triangle_distance(a, b);
    let longest = longest_side(a, b);
    let meet = triangles_intersect(a, b, &StaticFilter::OFF);
    assert_eq!(distance == 0.0, meet, "{a:?} {b:?}");
    if !meet {
        let truth = Fraction::true_distance(a, b);
        let error = allowed * longest + f64::from_bits(1);
        assert!(is_right(distance, error, &truth), "{distance:e} of {a:?} {b:?}");
    }
    for (triangle, p) in [a, b].into_iter().zip(points) {
        let (low, high) = bounds(triangle);
        assert!((0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]), "{p:?} of {a:?} {b:?}");
    }
    let largest = a.iter().chain(b).flatten().fold(0.0, |most: f64, c| most.max(c.abs()));
    let between = sub(&points[0], &points[1]);
    let length = between.iter().map(|c| c * c).sum::<f64>().sqrt();
    assert!((length - distance).abs() <= 1e-14 * largest, "{points:?} are not {distance:e} apart");
}

/// Far below the bound that is stated: what is proven has room.
const SEEN: f64 = RELATIVE_ERROR / 8.0;

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -1.0..1.0, 1 => (-4..5_i32).prop_map(|n| f64::from(n) / 4.0)]
}

fn point() -> BoxedStrategy<Point> {
    [number(), number(), number()].boxed()
}

/// Proper ones, slivers down to segments with a last digit astray, segments and points.
fn triangle() -> BoxedStrategy<Triangle> {
    let thin =
        (point(), point(), 0.0..1.0, point(), 0..60_i32).prop_map(|(a, b, t, away, tiny)| {
            let between = |k: usize| a[k] + t * (b[k] - a[k]) + away[k] * power_of_two(-tiny);
            [a, b, [0, 1, 2].map(between)]
        });
    let segment = (point(), point(), 0..3_usize)
        .prop_map(|(a, b, twice)| [[a, a, b], [a, b, a], [b, a, a]][twice]);
    prop_oneof![
        3 => [point(), point(), point()],
        4 => thin,
        1 => segment,
        1 => point().prop_map(|p| [p; 3]),
    ]
    .boxed()
}

/// The second moved away from the first, or nearly along it: edges at all small angles.
fn pair() -> impl Strategy<Value = [Triangle; 2]> {
    let beside = (triangle(), [point(), point(), point()], 0..56_i32, point()).prop_map(
        |(a, astray, tiny, shift)| {
            let moved =
                |v: usize, k: usize| a[v][k] + astray[v][k] * power_of_two(-tiny) + 0.5 * shift[k];
            [a, [0, 1, 2].map(|v| [0, 1, 2].map(|k| moved(v, k)))]
        },
    );
    let apart = (triangle(), triangle(), point())
        .prop_map(|(a, b, shift)| [a, b.map(|p| [0, 1, 2].map(|k| p[k] + 1.5 * shift[k]))]);
    prop_oneof![apart, beside]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn distance_is_true_to_within_its_bound([a, b] in pair()) {
        check(&a, &b, SEEN);
    }

    #[test]
    fn distance_is_true_far_from_the_origin_and_at_any_scale(
        [a, b] in pair(), away in point(), exponent in -300..300_i32, shift in 0..40_i32,
    ) {
        let (unit, far) = (power_of_two(exponent), power_of_two(shift));
        let moved = |p: Point| [0, 1, 2].map(|k| (p[k] + far * away[k]) * unit);
        check(&a.map(moved), &b.map(moved), SEEN);
    }

    #[test]
    fn distance_does_not_depend_on_the_order_beyond_its_error([a, b] in pair()) {
        let there = triangle_distance(&a, &b);
        let [c, d, e] = a;
        let back = triangle_distance(&b, &[d, c, e]);
        let error = 2.0 * SEEN * longest_side(&a, &b);
        prop_assert!((there.distance - back.distance).abs() <= error);
    }
}

#[test]
fn simple_features_have_their_distance() {
    let face = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let above = [[1.0, 1.0, 2.0], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]];
    let nearest = triangle_distance(&face, &above);
    assert_eq!(nearest, Nearest { distance: 2.0, points: [[1.0, 1.0, 0.0], [1.0, 1.0, 2.0]] });
    let beyond = [[5.0, -3.0, 4.0], [9.0, -3.0, 5.0], [9.0, -4.0, 4.0]];
    let nearest = triangle_distance(&face, &beyond);
    assert_eq!(nearest.distance, 26.0_f64.sqrt());
    assert_eq!(nearest.points, [[4.0, 0.0, 0.0], [5.0, -3.0, 4.0]]);
    let across = [[1.0, -1.0, 1.0], [1.0, 5.0, 1.0], [1.0, 2.0, 9.0]];
    assert_eq!(triangle_distance(&face, &across).distance, 1.0);
}

#[test]
fn triangles_that_touch_or_cross_are_at_no_distance() {
    let face = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let touching = [[1.0, 1.0, 0.0], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]];
    let crossing = [[1.0, 1.0, -1.0], [1.0, 2.0, 3.0], [2.0, 1.0, 3.0]];
    let touch = triangle_distance(&face, &touching);
    assert_eq!(touch, Nearest { distance: 0.0, points: [[1.0, 1.0, 0.0]; 2] });
    let cross = triangle_distance(&face, &crossing);
    assert_eq!((cross.distance, cross.points[0][2]), (0.0, 0.0));
    // Nearer than any rounding shows, and still apart.
    let mut apart = touching;
    apart[0][2] = f64::from_bits(1);
    let distance = triangle_distance(&face, &apart).distance;
    assert!(distance > 0.0 && distance <= RELATIVE_ERROR * 4.0);
}

#[test]
fn extreme_coordinates_have_a_distance() {
    let max = f64::MAX;
    let [a, b] = [-max, max].map(|x| [[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]]);
    let far = triangle_distance(&a, &b);
    assert_eq!((far.distance, far.points[0][0], far.points[1][0]), (f64::INFINITY, -max, max));
    let c = a.map(|[_, y, z]| [0.25 * max, y, z]);
    let d = a.map(|[_, y, z]| [-0.5 * max, y, z]);
    assert_eq!(triangle_distance(&c, &d).distance, 0.75 * max);
    let least = f64::from_bits(1);
    let [tiny, near] =
        [0.0, 3.0 * least].map(|x| [[x, 0.0, 0.0], [x, least, 0.0], [x, 0.0, least]]);
    assert_eq!(triangle_distance(&tiny, &near).distance, 3.0 * least);
}
