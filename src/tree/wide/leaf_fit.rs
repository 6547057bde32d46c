//! The turned box of a leaf and its triangles in that box's frame.

use super::node::{LeafBox, LeafRows, WIDTH};
use crate::geometry::boxes::dot;
use crate::geometry::{Point, Triangle};
use crate::tree::fit::{Axes, IDENTITY, Projection, gaussian_axes, least, most, triangle_axes};
use crate::tree::node::{AXES_TOLERANCE, round_up, widen};

/// Of the fits tried, the box with the least surface.
pub fn fit_leaf(triangles: &[Triangle], ids: &[u32], first: u32) -> (LeafBox, LeafRows) {
    let areas = ids.iter().map(|&id| (doubled_area(&triangles[id as usize]), id));
    let largest = areas.max_by(|a, b| a.0.total_cmp(&b.0));
    let along_largest = largest.map_or(IDENTITY, |(_, id)| triangle_axes(&triangles[id as usize]));
    let fits = [IDENTITY, along_largest, gaussian_axes(triangles, ids)];
    let fits = fits.map(|axes| fit(triangles, ids, axes));
    let best = fits.iter().min_by(|a, b| surface(&a.half).total_cmp(&surface(&b.half)));
    leaf_in(best.unwrap_or(&fits[0]), triangles, ids, first)
}

/// A leaf that has its turned box whose triangles have moved: along the same axes, as long as that
/// does not make the box much larger. `unit`: that of the lengths in the leaf, in today's.
pub fn refit_leaf(triangles: &[Triangle], unit: f64, leaf: &mut LeafBox, rows: &mut LeafRows) {
    /// A box has to be that much larger for other axes to pay.
    const GROWTH: f64 = 1.5;
    const LANES: [u32; WIDTH] = [0, 1, 2, 3, 4, 5, 6, 7];
    let lanes = &LANES[..triangles.len()];
    let kept = fit(triangles, lanes, leaf.axes);
    let before = surface(&widen(leaf.half).map(|h| h * unit));
    let (first, ids) = (leaf.first, rows.ids);
    (*leaf, *rows) = if surface(&kept.half) > GROWTH * before {
        fit_leaf(triangles, lanes, first)
    } else {
        leaf_in(&kept, triangles, lanes, first)
    };
    rows.ids = ids;
}

fn leaf_in(fit: &Fit, triangles: &[Triangle], ids: &[u32], first: u32) -> (LeafBox, LeafRows) {
    let half = round_up(containing(&fit.half));
    let leaf = LeafBox { axes: fit.axes, center: fit.center, half, first };
    (leaf, rows_of(triangles, ids, fit))
}

struct Fit {
    axes: Axes,
    center: [f32; 3],
    /// Of what is projected on the axes.
    half: Point,
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

/// Projections of the vertices, taken from the center, on the axes.
fn rows_of(triangles: &[Triangle], ids: &[u32], fit: &Fit) -> LeafRows {
    let mut rows = LeafRows::EMPTY;
    let (projection, center) = (Projection::on(&fit.axes), widen(fit.center));
    for (lane, &id) in ids.iter().enumerate() {
        rows.ids[lane] = id;
        for (corner, v) in triangles[id as usize].iter().enumerate() {
            let from_center = [v[0] - center[0], v[1] - center[1], v[2] - center[2]];
            let along = projection.of(&from_center);
            for k in 0..3 {
                let along = along[k] as f32;
                match corner {
                    0 => rows.first_two[k][lane] = along,
                    1 => rows.first_two[k][8 + lane] = along,
                    _ => rows.third[k][lane] = along,
                }
            }
        }
    }
    rows
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
