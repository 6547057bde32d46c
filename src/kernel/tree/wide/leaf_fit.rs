//! The turned box of a leaf and its triangles in that box's frame.

use super::node::{LeafBox, LeafRows, WIDTH};
use crate::geometry::boxes::dot;
use crate::geometry::{Point, Triangle};
use crate::tree::fit::{Axes, IDENTITY, Projection, gaussian_axes, least, most, triangle_axes};
use crate::tree::node::{AXES_TOLERANCE, round_up, widen};

/// The box with the least surface of those that are tried, and the triangles in its frame.
pub fn fit_leaf(triangles: &[Triangle], ids: &[u32], first: u32) -> (LeafBox, LeafRows) {
    let fit = best_fit(triangles, ids);
    let mut rows = LeafRows::EMPTY;
    rows.ids[..ids.len()].copy_from_slice(ids);
    set_corners(&mut rows, triangles, ids, &fit);
    (fit.leaf(first), rows)
}

/// A leaf that has its turned box whose triangles have moved: along the same axes, as long as that
/// does not make the box much larger. `unit`: that of the lengths in the leaf, in today's.
pub fn refit_leaf(triangles: &[Triangle], unit: f64, leaf: &mut LeafBox, rows: &mut LeafRows) {
    /// A box has to be that much larger for other axes to pay.
    const GROWTH: f64 = 1.5;
    const LANES: [u32; WIDTH] = [0, 1, 2, 3, 4, 5, 6, 7];
    let lanes = &LANES[..triangles.len()];
    let mut kept = fit(triangles, lanes, leaf.axes);
    if surface(&kept.half) > GROWTH * surface(&widen(leaf.half).map(|h| h * unit)) {
        kept = best_fit(triangles, lanes);
    }
    *leaf = kept.leaf(leaf.first);
    set_corners(rows, triangles, lanes, &kept);
}

fn best_fit(triangles: &[Triangle], ids: &[u32]) -> Fit {
    let areas = ids.iter().map(|&id| (doubled_area(&triangles[id as usize]), id));
    let largest = areas.max_by(|a, b| a.0.total_cmp(&b.0));
    let along_largest = largest.map_or(IDENTITY, |(_, id)| triangle_axes(&triangles[id as usize]));
    let others = [along_largest, gaussian_axes(triangles, ids)];
    others.into_iter().fold(fit(triangles, ids, IDENTITY), |best, axes| {
        let next = fit(triangles, ids, axes);
        // Of equal ones the first.
        if surface(&next.half) < surface(&best.half) { next } else { best }
    })
}

struct Fit {
    axes: Axes,
    center: [f32; 3],
    /// Of what is projected on the axes.
    half: Point,
}

impl Fit {
    fn leaf(&self, first: u32) -> LeafBox {
        let half = round_up(containing(&self.half));
        LeafBox { axes: self.axes, center: self.center, half, first }
    }
}

/// Half extents of the box `center + sum_i s_i axes[i]` from those of the projections on its axes,
/// see [`crate::tree::fit::fit_box`].
fn containing(half: &Point) -> Point {
    let radius = half.iter().map(|h| h * h).sum::<f64>().sqrt();
    half.map(|h| h + 1.01 * AXES_TOLERANCE * radius)
}

fn fit(triangles: &[Triangle], ids: &[u32], axes: Axes) -> Fit {
    let projection = Projection::on(&axes);
    let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
    for &id in ids {
        for v in &triangles[id as usize] {
            let along = projection.of(v);
            low = least(low, along);
            high = most(high, along);
        }
    }
    let wide = axes.map(widen);
    let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let center = [0, 1, 2].map(|i| (0..3).map(|k| wide[k][i] * middle[k]).sum::<f64>() as f32);
    let projected = wide.map(|row| dot(&row, &widen(center)));
    let half = [0, 1, 2].map(|k| (high[k] - projected[k]).max(projected[k] - low[k]));
    Fit { axes, center, half }
}

/// To the projections of the vertices, taken from the center, on the axes.
fn set_corners(rows: &mut LeafRows, triangles: &[Triangle], ids: &[u32], fit: &Fit) {
    let (projection, center) = (Projection::on(&fit.axes), widen(fit.center));
    let LeafRows { first_two, third, .. } = rows;
    for (lane, &id) in ids.iter().enumerate() {
        let along =
            |v: &Point| projection.of(&[v[0] - center[0], v[1] - center[1], v[2] - center[2]]);
        let [a, b, c] = &triangles[id as usize];
        let (a, b, c) = (along(a), along(b), along(c));
        for k in 0..3 {
            first_two[k][lane] = a[k] as f32;
            first_two[k][WIDTH + lane] = b[k] as f32;
            third[k][lane] = c[k] as f32;
        }
    }
}

fn surface(h: &Point) -> f64 {
    h[0] * h[1] + h[1] * h[2] + h[2] * h[0]
}

fn doubled_area([a, b, c]: &Triangle) -> f64 {
    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    dot(&n, &n)
}
