//! Boxes around sets of triangles (section 6.1 of the paper).

use nalgebra::{Matrix3, SymmetricEigen};

use super::node::AXES_TOLERANCE;
use super::split::Interval;
use crate::geometry::{Point, Triangle};

/// Rows are the axes of a box.
pub type Axes = [[f32; 3]; 3];

pub const IDENTITY: Axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Fit of points with a Gaussian distribution (Eberly 2001): the eigenvectors of the covariance of
/// all vertices. The identity where that has no usable answer.
pub fn gaussian_axes(triangles: &[Triangle], ids: &[u32]) -> Axes {
    let vertices = || ids.iter().flat_map(|&id| triangles[id as usize]);
    let count = 3.0 * ids.len() as f64;
    let mut mean = [0.0; 3];
    for v in vertices() {
        (0..3).for_each(|i| mean[i] += v[i]);
    }
    let mean = mean.map(|sum| sum / count);
    let mut m = [0.0; 6];
    for v in vertices() {
        let [x, y, z] = [v[0] - mean[0], v[1] - mean[1], v[2] - mean[2]];
        for (sum, product) in m.iter_mut().zip([x * x, x * y, x * z, y * y, y * z, z * z]) {
            *sum += product;
        }
    }
    let covariance = Matrix3::new(m[0], m[1], m[2], m[1], m[3], m[4], m[2], m[4], m[5]);
    let Some(eigen) = SymmetricEigen::try_new(covariance, f64::EPSILON, 64) else {
        return IDENTITY;
    };
    let column = |i: usize| {
        let v = eigen.eigenvectors.column(i);
        [v[0] as f32, v[1] as f32, v[2] as f32]
    };
    checked([column(0), column(1), column(2)])
}

/// A triangle's own frame: along its longest edge, across it, and its normal. The Gaussian fit of
/// three points lies askew in the triangle's plane, and half of all boxes are leaves.
pub fn triangle_axes(triangle: &Triangle) -> Axes {
    let [a, b, c] = triangle.map(nalgebra::Vector3::from);
    let edges = [b - a, c - b, a - c];
    let by_length = |p: &&nalgebra::Vector3<f64>, q: &&nalgebra::Vector3<f64>| {
        p.norm_squared().total_cmp(&q.norm_squared())
    };
    let Some(long) = edges.iter().max_by(by_length) else { return IDENTITY };
    let normal = edges[0].cross(&edges[1]);
    let (Some(u), Some(w)) = (long.try_normalize(0.0), normal.try_normalize(0.0)) else {
        return IDENTITY;
    };
    let v = w.cross(&u);
    let row = |v: nalgebra::Vector3<f64>| [v.x as f32, v.y as f32, v.z as f32];
    checked([row(u), row(v), row(w)])
}

/// `axes`, if they are as orthonormal as every box's containment relies on.
fn checked(axes: Axes) -> Axes {
    let mut squares = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            let dot: f64 = (0..3).map(|k| f64::from(axes[i][k]) * f64::from(axes[j][k])).sum();
            let error = dot - f64::from(u8::from(i == j));
            squares += error * error;
        }
    }
    // The Frobenius norm bounds the spectral one. NaN fails the comparison.
    if squares.sqrt() <= AXES_TOLERANCE { axes } else { IDENTITY }
}

/// Center and half extents of a box.
pub struct Fit {
    pub center: [f32; 3],
    pub half: Point,
}

/// The least box along `axes` that contains the triangles; writes their projections.
///
/// The box is `center + U s` with the rounded axes as columns of `U`, and what is projected is
/// `U^T (v - center)`, which differs from the `s` of `v` by at most the norm of `U^T U - I` times
/// the radius: the extents grow by that much.
pub fn fit_box(triangles: &[Triangle], ids: &[u32], axes: &Axes, out: &mut [Interval]) -> Fit {
    let wide = axes.map(|row| row.map(f64::from));
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for (&id, interval) in ids.iter().zip(out) {
        let triangle = &triangles[id as usize];
        for (axis, row) in wide.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| v[0] * row[0] + v[1] * row[1] + v[2] * row[2]);
            let (least, most) = (a.min(b).min(c), a.max(b).max(c));
            interval.low[axis] = least as f32;
            interval.high[axis] = most as f32;
            low[axis] = low[axis].min(least);
            high[axis] = high[axis].max(most);
        }
    }
    let middle = [0, 1, 2].map(|i| 0.5 * (low[i] + high[i]));
    let center = [0, 1, 2]
        .map(|k| (wide[0][k] * middle[0] + wide[1][k] * middle[1] + wide[2][k] * middle[2]) as f32);
    let projected = wide.map(|row| (0..3).map(|k| row[k] * f64::from(center[k])).sum::<f64>());
    let half = [0, 1, 2].map(|i| (high[i] - projected[i]).max(projected[i] - low[i]));
    let radius = half.iter().map(|h| h * h).sum::<f64>().sqrt();
    Fit { center, half: half.map(|h| h + 1.01 * AXES_TOLERANCE * radius) }
}
