//! Shapes whose distance is known.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use bumper::geometry::distance::RELATIVE_ERROR;
use bumper::geometry::{Point, Pose, Triangle};
use bumper::tree::TreeKind;
use bumper::tree::nearest::{Clearance, Near};

use super::{images, mesh, smallest};

/// Around the origin, each face divided into `2 n n` triangles.
fn cuboid(half: Point, n: u32) -> Vec<Triangle> {
    let mut all = Vec::new();
    let at = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let corner = |i: u32, j: u32| {
                let mut p = [0.0; 3];
                p[axis] = side * half[axis];
                p[(axis + 1) % 3] = at(i) * half[(axis + 1) % 3];
                p[(axis + 2) % 3] = at(j) * half[(axis + 2) % 3];
                p
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                all.push([corner(i, j), corner(i + 1, j), corner(i, j + 1)]);
                all.push([corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
            }
        }
    }
    all
}

/// Vertices on the unit sphere.
fn sphere(rings: u32) -> Vec<Triangle> {
    let at = |ring: u32, step: u32| {
        let (polar, around) =
            (PI * f64::from(ring) / f64::from(rings), PI * f64::from(step) / f64::from(rings));
        [polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()]
    };
    let mut all = Vec::new();
    for (ring, step) in (0..rings).flat_map(|r| (0..2 * rings).map(move |s| (r, s))) {
        let [a, b] = [at(ring, step), at(ring, step + 1)];
        let [c, d] = [at(ring + 1, step), at(ring + 1, step + 1)];
        all.extend([[a, c, b], [b, c, d]]);
    }
    all
}

fn nearest(a: &[Triangle], b: &[Triangle], pose: &Pose) -> Near {
    let (a, b) = (mesh(a), mesh(b));
    let all = TreeKind::ALL
        .map(|kind| smallest(&mut Clearance::default(), &images([&a, &b], kind), pose).nearest);
    assert_eq!(all[0], all[1]);
    assert_eq!(all[1], all[2]);
    all[0]
}

#[test]
fn boxes_are_as_far_apart_as_their_gaps_say() {
    let (a, b) = (cuboid([1.0, 2.0, 0.5], 4), cuboid([0.5, 0.25, 1.0], 3));
    for gaps in [[3.0, 0.0, 0.0], [0.0, 1e-6, 0.0], [2.0, 3.0, 6.0], [0.0, 0.0, 0.0]] {
        let shift = [0, 1, 2].map(|k| [1.5, 2.25, 1.5][k] + gaps[k]);
        let found = nearest(&a, &b, &Pose { translation: shift, ..Pose::IDENTITY });
        let expected = gaps.iter().map(|g| g * g).sum::<f64>().sqrt();
        assert!((found.distance_m - expected).abs() <= 16.0 * RELATIVE_ERROR, "{found:?}");
        assert_eq!(found.distance_m == 0.0, expected == 0.0);
    }
}

#[test]
fn edges_of_boxes_that_cross_are_as_far_apart_as_they_are() {
    // Both stand on an edge along x; the second, turned by a quarter, crosses above the first.
    let on_edge = |p: Point| [p[0], (p[1] - p[2]) * FRAC_1_SQRT_2, (p[1] + p[2]) * FRAC_1_SQRT_2];
    let block = cuboid([2.0, 1.0, 1.0], 3);
    let block = super::mapped(&block, on_edge);
    let height = 2.0 * 2.0_f64.sqrt() + 0.001;
    let turn = Pose::from_quaternion([FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2], [0.1, 0.2, height]);
    let found = nearest(&block, &block, &turn);
    assert!((found.distance_m - 0.001).abs() <= 1e-14, "{found:?}");
    let expected = [[0.1, 0.0, 2.0_f64.sqrt()], [0.1, 0.0, 2.0_f64.sqrt() + 0.001]];
    for (p, q) in found.points.iter().zip(expected) {
        assert!((0..3).all(|k| (p[k] - q[k]).abs() < 1e-12), "{p:?} is not {q:?}");
    }
}

#[test]
fn spheres_are_as_far_apart_as_their_centers_less_their_radii() {
    let ball = sphere(10);
    // No face is further inside than this.
    let sagitta = 2.0 * (1.0 - (PI / 10.0).cos());
    for (centers, seed) in [(2.3, 1), (4.0, 2), (50.0, 3)] {
        let mut random = super::Random::new(seed);
        let turn = random.pose(0.0);
        let direction = random.point();
        let length = direction.iter().map(|c| c * c).sum::<f64>().sqrt();
        let translation = direction.map(|c| c * centers / length);
        let found = nearest(&ball, &ball, &Pose { translation, ..turn }).distance_m;
        let exact = centers - 2.0;
        assert!((exact - 1e-12..=exact + sagitta).contains(&found), "{found} is not {exact}");
    }
}
