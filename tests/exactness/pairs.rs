//! Random and nearly degenerate triangles.

use bumper::geometry::triangle::triangles_intersect;
use bumper::geometry::{Point, Triangle};
use proptest::prelude::*;

use super::oracle::tight_filter;
use super::{assert_agrees, config};

fn intersect(a: &Triangle, b: &Triangle) -> bool {
    triangles_intersect(a, b, &tight_filter(a.iter().chain(b)))
}

pub fn points(
    coordinate: impl Strategy<Value = f64> + Clone,
) -> impl Strategy<Value = Triangle> + Clone {
    prop::array::uniform3(prop::array::uniform3(coordinate))
}

/// Few different values: most triples share planes, lines and vertices.
pub fn on_grid() -> impl Strategy<Value = Triangle> + Clone {
    points((0..4_i32).prop_map(f64::from))
}

pub fn anywhere() -> impl Strategy<Value = Triangle> + Clone {
    points(-1.0..1.0)
}

/// A triangle, a segment or a point.
pub fn of_any_dimension() -> impl Strategy<Value = Triangle> {
    (prop_oneof![anywhere(), on_grid()], 0..4, 0..=8).prop_map(|([p, q, r], shape, eighths)| {
        let between = at(&[p, q, r], [8 - eighths, eighths, 0]);
        match shape {
            0 => [p; 3],
            1 => [p, q, q],
            2 => [p, between, q],
            _ => [p, q, r],
        }
    })
}

/// The point with these weights in eighths, as f64 rounds it.
pub fn at(triangle: &Triangle, weights: [i32; 3]) -> Point {
    let [u, v, w] = weights.map(|weight| f64::from(weight) / 8.0);
    let [p, q, r] = triangle;
    [0, 1, 2].map(|k| u * p[k] + v * q[k] + w * r[k])
}

/// Weights in eighths; zeros put the point on an edge or a vertex.
pub fn weights() -> impl Strategy<Value = [i32; 3]> {
    (0..=8, 0..=8).prop_map(|(u, v)| if u + v <= 8 { [u, v, 8 - u - v] } else { [u, 8 - u, 0] })
}

pub fn nudged(x: f64, ulps: i64) -> f64 {
    (0..ulps.abs()).fold(x, |x, _| if ulps < 0 { x.next_down() } else { x.next_up() })
}

/// All magnitudes side by side, from one subnormal to the largest number.
fn of_mixed_scale() -> impl Strategy<Value = f64> + Clone {
    const SCALES: [i32; 9] = [-1074, -1070, -1022, -360, -52, 0, 1, 340, 1020];
    (-3..=3_i32, prop::sample::select(&SCALES)).prop_map(|(n, scale)| {
        f64::from(n) * f64::powi(2.0, scale.max(-1000)) * f64::powi(2.0, (scale + 1000).min(0))
    })
}

proptest! {
    #![proptest_config(config(400))]

    #[test]
    fn random_pairs(a in anywhere(), b in anywhere()) {
        assert_agrees(&a, &b)?;
    }

    #[test]
    fn pairs_on_a_small_grid(a in on_grid(), b in on_grid()) {
        assert_agrees(&a, &b)?;
    }

    #[test]
    fn coplanar_pairs(a in on_grid(), b in on_grid(), axis in 0..3_usize, slope in 0..3) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let flat = |t: Triangle| t.map(|mut p| {
            p[axis] = f64::from(slope) * p[u] - p[v] + 1.0;
            p
        });
        assert_agrees(&flat(a), &flat(b))?;
    }

    #[test]
    fn segments_points_and_triangles(a in of_any_dimension(), b in of_any_dimension()) {
        assert_agrees(&a, &b)?;
    }

    #[test]
    fn degenerate_on_a_triangle(
        a in of_any_dimension(), from in weights(), to in weights(), middle in 0..=8,
        elsewhere in prop::option::of(prop::array::uniform3(-1.0..1.0)),
    ) {
        let (p, q) = (at(&a, from), elsewhere.unwrap_or_else(|| at(&a, to)));
        assert_agrees(&a, &[p, at(&[p, q, q], [middle, 8 - middle, 0]), q])?;
    }

    #[test]
    fn vertex_within_ulps_of_a_triangle(
        a in anywhere(), b in anywhere(), w in weights(), ulps in prop::array::uniform3(-2..=2_i64),
    ) {
        let touching = at(&a, w);
        assert_agrees(&a, &[[0, 1, 2].map(|k| nudged(touching[k], ulps[k])), b[1], b[2]])?;
    }

    #[test]
    fn edges_within_ulps_of_crossing(
        a in anywhere(), b in anywhere(), eighths in 0..=8, ulps in -2..=2_i64,
    ) {
        let [p, q] = [at(&a, [eighths, 8 - eighths, 0]), b[0]];
        let beyond = [nudged(2.0 * p[0] - q[0], ulps), 2.0 * p[1] - q[1], 2.0 * p[2] - q[2]];
        assert_agrees(&a, &[q, beyond, b[2]])?;
    }

    #[test]
    fn nearly_coplanar_pairs(
        a in anywhere(), weights in prop::array::uniform3(prop::array::uniform3(-8..=8)),
        ulps in prop::array::uniform3(-2..=2_i64),
    ) {
        let b = [0, 1, 2].map(|i| {
            let [u, v, _] = weights[i];
            let [x, y, z] = at(&a, [u, v, 8 - u - v]);
            [x, y, nudged(z, ulps[i])]
        });
        assert_agrees(&a, &b)?;
    }

    #[test]
    fn far_from_the_origin(a in on_grid(), b in on_grid(), offset in 0..60) {
        let moved = |t: Triangle| t.map(|p| p.map(|c| c * 0.1 + f64::powi(2.0, offset)));
        assert_agrees(&moved(a), &moved(b))?;
    }

    #[test]
    fn symmetries(a in of_any_dimension(), b in of_any_dimension(), scale in -900..900) {
        let expected = intersect(&a, &b);
        prop_assert_eq!(intersect(&b, &a), expected);
        let turned = |[p, q, r]: Triangle| [q, r, p];
        let mirrored = |[p, q, r]: Triangle| [q, p, r];
        prop_assert_eq!(intersect(&turned(a), &b), expected);
        prop_assert_eq!(intersect(&mirrored(a), &turned(b)), expected);
        let other_axes = |t: Triangle| t.map(|[x, y, z]| [-z, x, y]);
        prop_assert_eq!(intersect(&other_axes(a), &other_axes(b)), expected);
        let scaled = |t: Triangle| t.map(|p| p.map(|c| c * f64::powi(2.0, scale)));
        prop_assert_eq!(intersect(&scaled(a), &scaled(b)), expected);
    }

    #[test]
    fn every_triangle_meets_itself_and_its_parts(a in of_any_dimension(), part in 0..3_usize) {
        prop_assert!(intersect(&a, &a));
        prop_assert!(intersect(&a, &[a[part]; 3]));
        prop_assert!(intersect(&a, &[a[part], a[(part + 1) % 3], a[part]]));
    }
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn mixed_scales(a in points(of_mixed_scale()), b in points(of_mixed_scale())) {
        assert_agrees(&a, &b)?;
    }

    #[test]
    fn arbitrary_finite_bits(
        a in points(any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite())),
        b in points(any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite())),
    ) {
        assert_agrees(&a, &b)?;
    }
}
