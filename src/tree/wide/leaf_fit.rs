//! The turned box of a leaf and its triangles in that box's frame.

use super::node::{LeafBox, LeafRows};
use crate::geometry::boxes::dot;
use crate::geometry::{Point, Triangle};
use crate::tree::fit::{Axes, IDENTITY, gaussian_axes, triangle_axes};
use crate::tree::node::{AXES_TOLERANCE, round_up, widen};

/// Of the fits tried, the box with the least surface.
pub fn fit_leaf(triangles: &[Triangle], ids: &[u32], first: u32) -> (LeafBox, LeafRows) {
    let largest = ids.iter().max_by(|&&a, &&b| {
        doubled_area(&triangles[a as usize]).total_cmp(&doubled_area(&triangles[b as usize]))
    });
    let along_largest = largest.map_or(IDENTITY, |&id| triangle_axes(&triangles[id as usize]));
    let fits = [IDENTITY, along_largest, gaussian_axes(triangles, ids)];
    let fits = fits.map(|axes| fit(triangles, ids, axes));
    let best = fits.iter().min_by(|a, b| surface(&a.half).total_cmp(&surface(&b.half)));
    let best = best.unwrap_or(&fits[0]);
    let rows = rows_of(triangles, ids, best);
    let leaf = LeafBox {
        axes: best.axes,
        center: best.center,
        half: round_up(containing(&best.half)),
        first,
    };
    (leaf, rows)
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
    let wide = axes.map(widen);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for v in ids.iter().flat_map(|&id| triangles[id as usize]) {
        for k in 0..3 {
            let along = dot(&wide[k], &v);
            low[k] = low[k].min(along);
            high[k] = high[k].max(along);
        }
    }
    let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let center = [0, 1, 2].map(|i| (0..3).map(|k| wide[k][i] * middle[k]).sum::<f64>() as f32);
    let projected = wide.map(|row| dot(&row, &widen(center)));
    let half = [0, 1, 2].map(|k| (high[k] - projected[k]).max(projected[k] - low[k]));
    Fit { axes, center, half }
}

/// Projections of the vertices, taken from the center, on the axes.
fn rows_of(triangles: &[Triangle], ids: &[u32], fit: &Fit) -> LeafRows {
    let mut rows = LeafRows::EMPTY;
    let (wide, center) = (fit.axes.map(widen), widen(fit.center));
    for (lane, &id) in ids.iter().enumerate() {
        rows.ids[lane] = id;
        for (corner, v) in triangles[id as usize].iter().enumerate() {
            let from_center = [0, 1, 2].map(|i| v[i] - center[i]);
            for (k, row) in wide.iter().enumerate() {
                let along = dot(row, &from_center) as f32;
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
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|i| p[i] - a[i]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    dot(&n, &n)
}
