//! Directions worth trying.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use super::{Bodies, Direction};
use crate::geometry::{Pose, Triangle};
use crate::tree::descent::Pair;

/// Most pairs whose normals are tried one by one.
const PAIRS: usize = 16;

/// From the contacts' normals: their mean, their principal axes, some of themselves; and the axes of
/// coordinates.
pub fn seeds<B: Bodies>(bodies: &B, pose: &Pose, pairs: &[Pair]) -> Vec<Direction> {
    let (mut mean, mut spread) = (Vector3::zeros(), Matrix3::zeros());
    let mut single = Vec::new();
    let stride = pairs.len().div_ceil(PAIRS).max(1);
    for (i, pair) in pairs.iter().enumerate() {
        let [a, b] = bodies.triangles(*pair);
        // Out of the fixed mesh, and into the moving one.
        let normals = [normal(&a), -normal(&b.map(|p| pose.apply(p)))];
        for normal in normals {
            mean += normal;
            spread += normal * normal.transpose();
        }
        if i % stride == 0 {
            single.extend(normals);
        }
    }
    let axes = (0..3).map(|k| Vector3::ith(k, 1.0));
    let spread = SymmetricEigen::new(spread).eigenvectors;
    let both_ways = spread.column_iter().map(|axis| axis.into_owned()).chain(axes);
    let vectors = [mean].into_iter().chain(single).chain(both_ways.flat_map(|v| [v, -v]));
    vectors.filter_map(Direction::of).collect()
}

/// Of unit length, or zero of a degenerate triangle.
fn normal([a, b, c]: &Triangle) -> Vector3<f64> {
    let [a, b, c] = [a, b, c].map(|p| Vector3::from(*p));
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default()
}

/// One of a sequence that covers the sphere ever more densely (Roberts' additive sequence of the
/// plastic number, mapped with equal areas), so that more directions are always the same and more.
pub fn spread_over_sphere(index: u32) -> Direction {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let [u, v] = [PLASTIC.recip(), PLASTIC.powi(-2)].map(|a| (0.5 + a * f64::from(index)).fract());
    let (z, angle) = (1.0 - 2.0 * u, std::f64::consts::TAU * v);
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let vector = Vector3::new(radius * angle.cos(), radius * angle.sin(), z);
    Direction::of(vector).expect("it is of unit length")
}
