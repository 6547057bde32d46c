//! Random pairs, and pairs that are degenerate or nearly so by construction.

use bumper::geometry::contact::{Kind, certified, plain_f32, plain_f64};
use bumper::geometry::{Point, Triangle};
use proptest::prelude::*;

use crate::{ORDERS, fault};

fn assert_right(a: &Triangle, b: &Triangle) -> Result<(), TestCaseError> {
    let fault = fault(a, b);
    prop_assert!(fault.is_none(), "{a:?} {b:?}: {fault:?}");
    Ok(())
}

fn points(
    coordinate: impl Strategy<Value = f64> + Clone,
) -> impl Strategy<Value = Triangle> + Clone {
    prop::array::uniform3(prop::array::uniform3(coordinate))
}

fn anywhere() -> impl Strategy<Value = Triangle> + Clone {
    points(-1.0..1.0)
}

/// Few different values: most triples share planes, lines and vertices.
fn on_grid() -> impl Strategy<Value = Triangle> + Clone {
    points((0..4_i32).prop_map(f64::from))
}

/// Integers, of which more triangles overlap in more corners than on the small grid.
fn on_wide_grid() -> impl Strategy<Value = Triangle> + Clone {
    points((-20..20_i32).prop_map(f64::from))
}

/// A triangle, a segment or a point.
fn of_any_dimension() -> impl Strategy<Value = Triangle> {
    (prop_oneof![anywhere(), on_grid()], 0..4, 0..=8).prop_map(|([p, q, r], shape, eighths)| {
        match shape {
            0 => [p; 3],
            1 => [p, q, q],
            2 => [p, at(&[p, q, r], [8 - eighths, eighths]), q],
            _ => [p, q, r],
        }
    })
}

/// The point with these two weights in eighths and a third that makes eight, as f64 rounds it.
fn at([p, q, r]: &Triangle, [u, v]: [i32; 2]) -> Point {
    let [u, v, w] = [u, v, 8 - u - v].map(|weight| f64::from(weight) / 8.0);
    [0, 1, 2].map(|k| u * p[k] + v * q[k] + w * r[k])
}

/// Eighths, most of them within the triangle, many on its edges.
fn weights() -> impl Strategy<Value = [i32; 2]> {
    prop_oneof![
        (0..=8, 0..=8).prop_map(|(u, v): (i32, i32)| [u.min(8 - v), v]),
        prop::array::uniform2(-8..=8)
    ]
}

fn nudged(x: f64, ulps: i64) -> f64 {
    (0..ulps.abs()).fold(x, |x, _| if ulps < 0 { x.next_down() } else { x.next_up() })
}

/// All magnitudes side by side, from one subnormal to the largest number.
fn of_mixed_scale() -> impl Strategy<Value = f64> + Clone {
    const SCALES: [i32; 9] = [-1074, -1070, -1022, -360, -52, 0, 1, 340, 1020];
    (-3..=3_i32, prop::sample::select(&SCALES)).prop_map(|(n, scale)| {
        f64::from(n) * f64::powi(2.0, scale.max(-1000)) * f64::powi(2.0, (scale + 1000).min(0))
    })
}

fn finite() -> impl Strategy<Value = f64> + Clone {
    any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn random_pairs(a in anywhere(), b in anywhere()) {
        assert_right(&a, &b)?;
    }

    #[test]
    fn pairs_on_a_small_grid(a in on_grid(), b in on_grid()) {
        assert_right(&a, &b)?;
    }

    #[test]
    fn polygons_of_coplanar_pairs(
        a in on_wide_grid(), b in on_wide_grid(), axis in 0..3_usize, slope in 0..3,
        thirds in any::<bool>(),
    ) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let flat = |t: Triangle| t.map(|mut p| {
            p[axis] = f64::from(slope) * p[u] - p[v] + 1.0;
            // No longer of one plane, but nearly.
            if thirds { p.map(|c| c / 3.0) } else { p }
        });
        assert_right(&flat(a), &flat(b))?;
    }

    #[test]
    fn segments_points_and_triangles(a in of_any_dimension(), b in of_any_dimension()) {
        assert_right(&a, &b)?;
    }

    #[test]
    fn a_vertex_within_ulps_of_a_triangle(
        a in of_any_dimension(), b in of_any_dimension(), w in weights(),
        ulps in prop::array::uniform3(-2..=2_i64),
    ) {
        let touching = at(&a, w);
        assert_right(&a, &[[0, 1, 2].map(|k| nudged(touching[k], ulps[k])), b[1], b[2]])?;
    }

    #[test]
    fn nearly_coplanar_pairs(
        a in anywhere(), w in prop::array::uniform3(weights()),
        ulps in prop::array::uniform3(-2..=2_i64),
    ) {
        let b = [0, 1, 2].map(|i| {
            let [x, y, z] = at(&a, w[i]);
            [x, y, nudged(z, ulps[i])]
        });
        assert_right(&a, &b)?;
        assert_right(&b, &a)?;
    }

    #[test]
    fn needles(a in anywhere(), b in anywhere(), width in -50..=-20_i32) {
        let thin = |[p, q, r]: Triangle| {
            [p, q, [0, 1, 2].map(|k| (p[k] + q[k]) / 2.0 + r[k] * f64::powi(2.0, width))]
        };
        assert_right(&thin(a), &b)?;
        assert_right(&thin(a), &thin(b))?;
        let flat = |t: Triangle| t.map(|[x, y, _]| [x, y, 0.5]);
        assert_right(&flat(thin(a)), &flat(thin(b)))?;
    }

    #[test]
    fn far_from_the_origin(a in on_grid(), b in on_grid(), offset in 0..60) {
        let moved = |t: Triangle| t.map(|p| p.map(|c| c * 0.1 + f64::powi(2.0, offset)));
        assert_right(&moved(a), &moved(b))?;
    }

    #[test]
    fn any_power_of_two(a in of_any_dimension(), b in on_grid(), scale in -1000..900) {
        let scaled = |t: Triangle| t.map(|p| p.map(|c| c * f64::powi(2.0, scale)));
        assert_right(&scaled(a), &scaled(b))?;
    }

    #[test]
    fn every_order_of_vertices_and_operands_is_within_its_error(
        a in of_any_dimension(), b in of_any_dimension(),
    ) {
        for order in ORDERS {
            let turned = order.map(|i| b[i]);
            assert_right(&a, &turned)?;
            assert_right(&turned, &a)?;
        }
    }

    /// The bound says something: a few units in the last place, where planes cross well.
    #[test]
    fn ordinary_pairs_have_small_errors(
        plane in prop::array::uniform2(0.2..0.8_f64), heights in prop::array::uniform3(0.2..0.8_f64),
        far in 0..30_i32,
    ) {
        let shift = f64::powi(2.0, far) - 1.0;
        let moved = |t: Triangle| t.map(|p| p.map(|c| c + shift));
        let a = moved([[0.0, 0.0, 0.0], [1.0, 0.0, plane[0] / 4.0], [0.0, 1.0, plane[1] / 4.0]]);
        let b = moved([
            [0.3, 0.1, -heights[0]], [0.1, 0.3, 0.5 + heights[1]], [0.9, 0.9, heights[2] - 1.0],
        ]);
        let contact = certified(&a, &b);
        prop_assert!(contact.is_some());
        let contact = contact.unwrap();
        prop_assert_eq!(contact.kind(), Kind::Segment);
        prop_assert!(contact.error() > 0.0);
        let size = 1.0 + shift;
        prop_assert!(contact.error() <= 40.0 * f64::EPSILON + 2.0 * size * f64::EPSILON);
        assert_right(&a, &b)?;
        let exact = contact.corners();
        let plain = [(plain_f64(&a, &b), 1e-14 * size), (plain_f32(&a, &b), 1e-5 * size)];
        for (found, tolerance) in plain {
            // So far away 32 bits tell nothing apart.
            prop_assert!(found.is_some() || far > 10);
            if let Some(found) = found && far <= 10 {
                let ends = found.points();
                prop_assert_eq!(ends.len(), 2);
                let is_near = |turn: usize| {
                    (0..2).all(|i| (0..3).all(|k| {
                        (ends[i][k] - exact[(i + turn) % 2][k]).abs() <= tolerance
                    }))
                };
                prop_assert!(is_near(0) || is_near(1), "{:?} {:?}", exact, ends);
            }
        }
    }
}

/// The rounded volumes of both ends of an edge are the same, not zero: a division by zero.
#[test]
fn an_edge_that_rounding_makes_parallel_to_the_plane() {
    let third = |t: [[f64; 3]; 3]| t.map(|p| p.map(|c| c / 3.0));
    let a = third([[7.0, 18.0, 12.0], [3.0, -28.0, -13.0], [-12.0, -19.0, -16.0]]);
    let b = third([[-8.0, 23.0, 7.0], [3.0, -14.0, -6.0], [0.0, 1.0, 0.0]]);
    assert_eq!(fault(&a, &b), None);
}

/// Two triangles that cut off all corners of each other.
#[test]
fn plain_arithmetic_finds_a_hexagon() {
    let a = [[0.0, 0.0, 1.0], [3.0, 0.0, 1.0], [0.0, 3.0, 1.0]];
    let b = [[2.0, 2.0, 1.0], [-1.0, 2.0, 1.0], [2.0, -1.0, 1.0]];
    assert_eq!(fault(&a, &b), None);
    let exact = certified(&a, &b).unwrap();
    assert_eq!(exact.corners().len(), 6);
    for plain in [plain_f64(&a, &b), plain_f32(&a, &b)] {
        let plain = plain.unwrap();
        assert_eq!(plain.points().len(), 6);
        assert!(plain.points().iter().all(|p| exact.corners().contains(p)), "{plain:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300, max_global_rejects: 10_000, ..ProptestConfig::default()
    })]

    #[test]
    fn mixed_scales(a in points(of_mixed_scale()), b in points(of_mixed_scale())) {
        assert_right(&a, &b)?;
    }

    #[test]
    fn arbitrary_finite_bits(a in points(finite()), b in points(finite()), w in weights()) {
        assert_right(&a, &b)?;
        let touching = at(&a, w);
        if touching.iter().all(|c| c.is_finite()) {
            assert_right(&a, &[touching, b[1], b[2]])?;
        }
    }
}
