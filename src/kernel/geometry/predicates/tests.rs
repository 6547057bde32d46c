use std::cmp::Ordering::{Equal, Greater, Less};

use proptest::prelude::*;

use super::*;

fn tight_filter(points: [&Point; 4]) -> StaticFilter {
    StaticFilter::for_extent([0, 1, 2].map(|k| {
        let axis = points.map(|p| p[k]);
        axis.into_iter().fold(f64::MIN, f64::max) - axis.into_iter().fold(f64::MAX, f64::min)
    }))
}

#[test]
fn orientation_is_positive_where_the_points_are_seen_counterclockwise() {
    let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let [a, b, c] = &triangle;
    let (above, on, below) = ([0.3, 0.2, 1.0], [9.0, -4.0, 0.0], [0.3, 0.2, -1.0]);
    for filter in [StaticFilter::for_extent([13.0; 3]), StaticFilter::OFF] {
        assert_eq!(orient3d(a, b, c, &above, &filter), Greater);
        assert_eq!(orient3d(a, b, c, &on, &filter), Equal);
        assert_eq!(orient3d(a, b, c, &below, &filter), Less);
        let sides = Plane::through(&triangle).sides(&[above, on, below], &filter);
        assert_eq!(sides, Sides { above: 0b001, below: 0b100 });
    }
    assert_eq!(orient2d(&[0.0, 0.0], &[1.0, 0.0], &[7.0, 1e-300]), Greater);
    assert_eq!(orient2d(&[0.0, 0.0], &[1.0, 0.0], &[7.0, 0.0]), Equal);
    assert_eq!(orient2d(&[0.0, 0.0], &[1.0, 0.0], &[7.0, -1e-300]), Less);
}

#[test]
fn differences_that_overflow_have_a_sign() {
    let max = f64::MAX;
    let [a, b, c] = [[-max, -max, 0.0], [max, -max, 0.0], [max, max, 0.0]];
    let on = [-max, max, 0.0];
    let filter = tight_filter([&a, &b, &c, &on]);
    assert_eq!(filter, StaticFilter::OFF);
    assert_eq!(orient3d(&a, &b, &c, &on, &filter), Equal);
    assert_eq!(orient3d(&a, &b, &c, &[-max, max, f64::from_bits(1)], &filter), Greater);
    assert_eq!(orient2d(&[-max, -max], &[max, max], &[max.next_down(), max]), Greater);
}

#[test]
fn filter_is_off_where_its_bound_does_not_hold() {
    for extent in [1.1e102, f64::MAX, f64::INFINITY, f64::NAN] {
        assert_eq!(StaticFilter::for_extent([1.0, extent, 1.0]), StaticFilter::OFF);
    }
    assert!(!StaticFilter::OFF.is_positive(f64::INFINITY));
    assert!(!StaticFilter::OFF.is_negative(f64::NAN));
}

#[test]
fn filter_decides_ordinary_determinants() {
    let filter = StaticFilter::for_extent([1.0, 2.0, 3.0]);
    assert!(filter.is_positive(4e-14) && filter.is_negative(-4e-14));
    assert!(!filter.is_positive(3e-14) && !filter.is_negative(-3e-14));
    // A flat scene has no extent on one axis, and all determinants zero.
    let flat = StaticFilter::for_extent([1.0, 1.0, 0.0]);
    assert!(!flat.is_positive(0.0) && !flat.is_negative(0.0) && flat.is_positive(1e-100));
}

/// Four points of a plane, up to the rounding of the last coordinate and `ulps` beyond it.
fn nearly_coplanar() -> impl Strategy<Value = [Point; 4]> {
    let weights = prop::array::uniform2(-8..=8);
    (prop::array::uniform3(prop::array::uniform3(-1.0..1.0)), weights, -2..=2_i32).prop_map(
        |(plane, [u, v], ulps): ([Point; 3], _, _)| {
            let [u, v] = [u, v].map(|weight| f64::from(weight) / 8.0);
            let [a, b, c] = plane;
            let mut d = [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
            d[2] += f64::from(ulps) * f64::EPSILON * d[2];
            [a, b, c, d]
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn stages_agree_on_nearly_coplanar_points(points in nearly_coplanar()) {
        let points = points.each_ref();
        let [a, b, c, d] = points;
        let truth = integer::orient3d(points);
        prop_assert_eq!(orient3d_exact(points, Untold), truth);
        prop_assert_eq!(orient3d(a, b, c, d, &tight_filter(points)), truth);
        prop_assert_eq!(orient3d(a, b, c, d, &StaticFilter::for_extent([50.0; 3])), truth);
        for axes in [[0, 1], [1, 2], [2, 0]] {
            let flat = points.map(|p| axes.map(|k| p[k]));
            let [a, b, c, d] = flat.each_ref();
            prop_assert_eq!(orient2d(a, b, c), integer::orient2d([a, b, c]));
            prop_assert_eq!(orient2d(a, b, d), integer::orient2d([a, b, d]));
        }
    }

    #[test]
    fn stages_agree_at_the_ends_of_the_exponent_windows(
        points in nearly_coplanar(), large in any::<bool>(),
    ) {
        let scale = |range: [i32; 2]| f64::powi(2.0, range[usize::from(large)]);
        let scaled = points.map(|p| p.map(|c| c * scale([-278, 329])));
        let points = scaled.each_ref();
        prop_assert_eq!(orient3d_exact(points, Untold), integer::orient3d(points));
        let flat = points.map(|p| [p[0], p[1]].map(|c| c * scale([-170, 150])));
        let [a, b, c, d] = flat.each_ref();
        for third in [c, d] {
            prop_assert_eq!(orient2d(a, b, third), integer::orient2d([a, b, third]));
        }
    }

    #[test]
    fn on_a_grid_nothing_is_rounded_and_beside_it_nothing_is_taken_for_it(
        n in prop::array::uniform12(-60_000..=60_000_i32), offset in -1_000_000..=1_000_000_i32,
        exponent in -230..=200_i32, moved in 0..12_usize, ulps in -1..=1_i64,
    ) {
        let number = |n: i32| f64::from(n + offset) * f64::powi(2.0, exponent);
        let mut points: [Point; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|k| number(n[3 * i + k]))
        });
        let order = grid::orient3d(points.each_ref());
        prop_assert_eq!(order, Some(integer::orient3d(points.each_ref())));
        let [a, b, c, _] = points.map(|[x, y, _]| [x, y]);
        let order = grid::orient2d([&a, &b, &c]);
        prop_assert_eq!(order, Some(integer::orient2d([&a, &b, &c])));
        let coordinate = &mut points[moved / 3][moved % 3];
        prop_assume!(*coordinate != 0.0);
        *coordinate = f64::from_bits(coordinate.to_bits().wrapping_add_signed(ulps));
        let truth = integer::orient3d(points.each_ref());
        prop_assert_eq!(orient3d_exact(points.each_ref(), Untold), truth);
        let [a, b, c, _] = points.map(|[x, y, _]| [x, y]);
        prop_assert_eq!(orient2d(&a, &b, &c), integer::orient2d([&a, &b, &c]));
    }

    #[test]
    fn a_plane_across_an_axis_has_the_sides_of_any_other(
        corners in prop::array::uniform3(prop::array::uniform3(-3..=3_i32)),
        points in prop::array::uniform3(prop::array::uniform3(-3..=3_i32)),
        axis in 0..3_usize, scale in prop::array::uniform3(-1074..=900_i32),
    ) {
        let power = |e: i32| f64::powi(2.0, e.max(-1000)) * f64::powi(2.0, (e + 1000).min(0));
        let place = |p: [i32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) * power(scale[k]));
        let mut corners = corners.map(place);
        (corners[1][axis], corners[2][axis]) = (corners[0][axis], corners[0][axis]);
        let points = points.map(place);
        let sides = Plane::through(&corners).sides(&points, &StaticFilter::OFF);
        let [a, b, c] = &corners;
        for (i, point) in points.iter().enumerate() {
            let side = (sides.above >> i & 1).cmp(&(sides.below >> i & 1));
            prop_assert_eq!(side, integer::orient3d([a, b, c, point]));
        }
    }

    #[test]
    fn integers_at_any_scale_have_the_sign_of_their_determinant(
        n in prop::array::uniform12(-9..=9_i128), scales in prop::array::uniform3(-1074..=1020_i32),
    ) {
        let [bx, by, bz, cx, cy, cz, dx, dy, dz] = std::array::from_fn(|i| n[i + 3] - n[i % 3]);
        let truth = (bx * (cy * dz - cz * dy) - by * (cx * dz - cz * dx)
            + bz * (cx * dy - cy * dx)).cmp(&0);
        let power = |e: i32| f64::powi(2.0, e.max(-1000)) * f64::powi(2.0, (e + 1000).min(0));
        let points: [Point; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|k| n[3 * i + k] as f64 * power(scales[k]))
        });
        let [a, b, c, d] = points.each_ref();
        prop_assert_eq!(orient3d(a, b, c, d, &tight_filter([a, b, c, d])), truth);
        prop_assert_eq!(integer::orient3d([a, b, c, d]), truth);
        let flat = points.map(|[x, y, _]| [x, y]);
        let [a, b, c, _] = flat.each_ref();
        prop_assert_eq!(orient2d(a, b, c), (bx * cy - by * cx).cmp(&0));
    }
}
