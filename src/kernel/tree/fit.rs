//! Boxes around sets of triangles (section 6.1 of the paper).

use super::node::AXES_TOLERANCE;
use super::split::Interval;
use crate::geometry::{Point, Triangle};

/// Rows are the axes of a box.
pub type Axes = [[f32; 3]; 3];

pub const IDENTITY: Axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Axes by coordinates, so that a point is projected on all of them at once. The fourth lane is no
/// axis: it makes vectors of what would be loops.
pub struct Projection([[f64; 4]; 3]);

impl Projection {
    pub fn on(axes: &Axes) -> Self {
        let mut columns = [[0.0; 4]; 3];
        for (axis, row) in axes.iter().enumerate() {
            for k in 0..3 {
                columns[k][axis] = f64::from(row[k]);
            }
        }
        Self(columns)
    }

    #[inline(always)]
    pub fn of(&self, v: &Point) -> [f64; 4] {
        let mut along = [0.0; 4];
        for (axis, along) in along.iter_mut().enumerate() {
            *along = v[0] * self.0[0][axis] + v[1] * self.0[1][axis] + v[2] * self.0[2][axis];
        }
        along
    }

    #[inline(always)]
    fn interval(&self, [a, b, c]: &Triangle) -> ([f64; 4], [f64; 4]) {
        let (a, b, c) = (self.of(a), self.of(b), self.of(c));
        (least(least(a, b), c), most(most(a, b), c))
    }
}

/// Of numbers; unlike [`f64::min`] this is one instruction.
#[inline(always)]
pub fn least(mut a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    for k in 0..4 {
        a[k] = if b[k] < a[k] { b[k] } else { a[k] };
    }
    a
}

#[inline(always)]
pub fn most(mut a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    for k in 0..4 {
        a[k] = if b[k] > a[k] { b[k] } else { a[k] };
    }
    a
}

/// Fit of points with a Gaussian distribution (Eberly 2001): the eigenvectors of the covariance of
/// all vertices.
pub fn gaussian_axes(triangles: &[Triangle], ids: &[u32]) -> Axes {
    let Some(&first) = ids.first() else { return IDENTITY };
    // From one of the points, so that nothing is lost where the set is small and far away.
    let origin = triangles[first as usize][0];
    let (mut sum, mut products) = ([0.0; 3], [0.0; 6]);
    for &id in ids {
        for v in &triangles[id as usize] {
            let [x, y, z] = [v[0] - origin[0], v[1] - origin[1], v[2] - origin[2]];
            let of_v = [x * x, y * y, z * z, y * z, z * x, x * y];
            for (sum, of_v) in sum.iter_mut().zip([x, y, z]) {
                *sum += of_v;
            }
            for (product, of_v) in products.iter_mut().zip(of_v) {
                *product += of_v;
            }
        }
    }
    let count = 3.0 * ids.len() as f64;
    let covariance = |i: usize, j: usize, products: f64| products - sum[i] * sum[j] / count;
    let [xx, yy, zz, yz, zx, xy] = products;
    let diagonal = [covariance(0, 0, xx), covariance(1, 1, yy), covariance(2, 2, zz)];
    let opposite = [covariance(1, 2, yz), covariance(2, 0, zx), covariance(0, 1, xy)];
    let vectors = eigenvectors(diagonal, opposite);
    checked(vectors.map(|row| row.map(|x| x as f32)))
}

/// Rows are orthonormal eigenvectors of the symmetric matrix with this diagonal and, for each `i`,
/// `opposite[i]` in the row and column that are not `i`: Jacobi's method, which turns one such
/// number to zero after the other. Square by square they vanish, so a few rounds do.
fn eigenvectors(mut diagonal: Point, mut opposite: Point) -> [Point; 3] {
    const ROUNDS: usize = 12;
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let trace: f64 = diagonal.iter().sum();
    for _ in 0..ROUNDS {
        let mut turned = false;
        for r in 0..3 {
            let (p, q) = ((r + 1) % 3, (r + 2) % 3);
            let square = opposite[r] * opposite[r];
            // What is left turns no axis by more than its rounding to 32 bits does.
            if square <= 1e-18 * diagonal[p] * diagonal[q] + 1e-30 * trace * trace {
                continue;
            }
            turned = true;
            let difference = diagonal[q] - diagonal[p];
            let root = (difference * difference + 4.0 * square).sqrt();
            let tangent = 2.0 * opposite[r] / (difference + root.copysign(difference));
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            diagonal[p] -= tangent * opposite[r];
            diagonal[q] += tangent * opposite[r];
            opposite[r] = 0.0;
            // The numbers at (r, p) and (r, q).
            let (rp, rq) = (opposite[q], opposite[p]);
            opposite[q] = cosine * rp - sine * rq;
            opposite[p] = sine * rp + cosine * rq;
            let (vp, vq) = (vectors[p], vectors[q]);
            let sum = |a: f64, v: &Point, b: f64, w: &Point| {
                [a * v[0] + b * w[0], a * v[1] + b * w[1], a * v[2] + b * w[2]]
            };
            vectors[p] = sum(cosine, &vp, -sine, &vq);
            vectors[q] = sum(sine, &vp, cosine, &vq);
        }
        if !turned {
            break;
        }
    }
    vectors
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

impl Fit {
    /// The least box along `axes` that contains what has its projections on them within these bounds.
    ///
    /// The box is `center + U s` with the rounded axes as columns of `U`, and what is projected is
    /// `U^T (v - center)`, which differs from the `s` of `v` by at most the norm of `U^T U - I` times
    /// the radius: the extents grow by that much.
    fn around(axes: &Axes, low: &[f64; 4], high: &[f64; 4]) -> Self {
        let wide = axes.map(|row| row.map(f64::from));
        let middle = [0, 1, 2].map(|i| 0.5 * (low[i] + high[i]));
        let center = [0, 1, 2].map(|k| {
            (wide[0][k] * middle[0] + wide[1][k] * middle[1] + wide[2][k] * middle[2]) as f32
        });
        let projected = wide.map(|row| (0..3).map(|k| row[k] * f64::from(center[k])).sum::<f64>());
        let half = [0, 1, 2].map(|i| (high[i] - projected[i]).max(projected[i] - low[i]));
        let radius = half.iter().map(|h| h * h).sum::<f64>().sqrt();
        Self { center, half: half.map(|h| h + 1.01 * AXES_TOLERANCE * radius) }
    }
}

/// The least box along `axes` that contains the triangles; writes their projections.
pub fn fit_box(triangles: &[Triangle], ids: &[u32], axes: &Axes, out: &mut [Interval]) -> Fit {
    let projection = Projection::on(axes);
    let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
    for (&id, interval) in ids.iter().zip(out) {
        let (from, to) = projection.interval(&triangles[id as usize]);
        for axis in 0..3 {
            interval.low[axis] = from[axis] as f32;
            interval.high[axis] = to[axis] as f32;
        }
        low = least(low, from);
        high = most(high, to);
    }
    Fit::around(axes, &low, &high)
}

/// [`fit_box`] of all of these, of which no projections are wanted.
pub fn fit_all(triangles: &[Triangle], axes: &Axes) -> Fit {
    let projection = Projection::on(axes);
    let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
    for triangle in triangles {
        let (from, to) = projection.interval(triangle);
        low = least(low, from);
        high = most(high, to);
    }
    Fit::around(axes, &low, &high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the matrix with this diagonal and these numbers opposite to it, times `v`.
    fn times(d: Point, o: Point, v: Point) -> Point {
        [
            d[0] * v[0] + o[2] * v[1] + o[1] * v[2],
            o[2] * v[0] + d[1] * v[1] + o[0] * v[2],
            o[1] * v[0] + o[0] * v[1] + d[2] * v[2],
        ]
    }

    #[test]
    fn eigenvectors_are_orthonormal_and_only_stretched_by_their_matrix() {
        let wave = |i: u32, k: u32| f64::from((i * 37 + k * k * 101 + k * 13) % 83) / 83.0 - 0.5;
        for i in 0..500 {
            // A sum of outer products, as a covariance is; of one or two of them it is flat.
            let (mut d, mut o) = ([0.0; 3], [0.0; 3]);
            for j in 0..1 + i % 4 {
                let v = [0, 1, 2].map(|k| wave(i, 3 * j + k) * 0.03_f64.powi((i % 5 * k) as i32));
                (0..3).for_each(|k| d[k] += v[k] * v[k]);
                (0..3).for_each(|k| o[k] += v[(k + 1) % 3] * v[(k + 2) % 3]);
            }
            let trace: f64 = d.iter().sum();
            let vectors = eigenvectors(d, o);
            for (a, v) in vectors.iter().enumerate() {
                for (b, w) in vectors.iter().enumerate() {
                    let dot: f64 = (0..3).map(|k| v[k] * w[k]).sum();
                    assert!((dot - f64::from(u8::from(a == b))).abs() < 1e-14, "{i}: {dot}");
                    let image = times(d, o, *v);
                    let across: f64 = (0..3).map(|k| image[k] * w[k]).sum();
                    assert!(a == b || across.abs() <= 2e-9 * trace, "{i}: {across}");
                }
            }
        }
    }
}
