//! Separating-axis tests of boxes (Gottschalk 2000, chapter 5): "apart" is only said when certain.
//!
//! All work in the frame of box A: A is `|y_j| <= ha[j]`; B is `t + sum_i s_i C_i`,
//! `|s_i| <= hb[i]`, with the columns `C_i` of the matrix `c` (row major). `slack` is added to the
//! radii on every axis and must bound all errors of `ha`, `hb`, `t` and `c` as well as how far `c`
//! is from a rotation; whoever calls states why it does.
//!
//! Plain arithmetic spelled out: these are the innermost lines of the descent, and closures over
//! arrays were not inlined there.

use super::Point;

/// Row major.
pub type Matrix = [Point; 3];

#[inline(always)]
pub fn dot(a: &Point, b: &Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Least and greatest coordinates per axis; infinite and the wrong way round for no points.
pub fn bounds<'a>(points: impl IntoIterator<Item = &'a Point>) -> (Point, Point) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in points {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    (low, high)
}

#[inline(always)]
pub fn apply(m: &Matrix, v: &Point) -> Point {
    [dot(&m[0], v), dot(&m[1], v), dot(&m[2], v)]
}

#[inline(always)]
fn weighted_abs(h: &Point, x: f64, y: f64, z: f64) -> f64 {
    h[0] * x.abs() + h[1] * y.abs() + h[2] * z.abs()
}

/// On axis `j` of A, from `t[j]` and row `j` of `c`. Valid for any matrix `c`.
#[inline(always)]
pub fn apart_on_axis_of_a(ha: f64, hb: &Point, t: f64, row: &Point, slack: f64) -> bool {
    t.abs() > ha + weighted_abs(hb, row[0], row[1], row[2]) + slack
}

/// On the three axes of B, for `c` a rotation to within what `slack` allows.
#[inline(always)]
pub fn apart_on_axes_of_b(ha: &Point, hb: &Point, t: &Point, c: &Matrix, slack: f64) -> bool {
    let on = |i: usize| {
        let along = t[0] * c[0][i] + t[1] * c[1][i] + t[2] * c[2][i];
        along.abs() > hb[i] + weighted_abs(ha, c[0][i], c[1][i], c[2][i]) + slack
    };
    on(0) || on(1) || on(2)
}

/// On the nine products of an axis of A and an axis of B, for `c` a rotation to within what
/// `slack` allows.
#[inline(always)]
pub fn apart_on_products(ha: &Point, hb: &Point, t: &Point, c: &Matrix, slack: f64) -> bool {
    let on = |j: usize, i: usize| {
        let (k, l) = ((j + 1) % 3, (j + 2) % 3);
        let (m, n) = ((i + 1) % 3, (i + 2) % 3);
        let ra = ha[k] * c[l][i].abs() + ha[l] * c[k][i].abs();
        let rb = hb[m] * c[j][n].abs() + hb[n] * c[j][m].abs();
        (t[l] * c[k][i] - t[k] * c[l][i]).abs() > ra + rb + slack
    };
    on(0, 0)
        || on(0, 1)
        || on(0, 2)
        || on(1, 0)
        || on(1, 1)
        || on(1, 2)
        || on(2, 0)
        || on(2, 1)
        || on(2, 2)
}
