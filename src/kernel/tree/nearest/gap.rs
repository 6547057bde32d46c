//! Lower bounds of the distance of two boxes, in 64 bits.

use crate::geometry::Point;
use crate::geometry::boxes::{Matrix, apply};
use crate::tree::node::{AabbNode, ObbNode, widen};
use crate::tree::placement::{BoxNode, Placement, scaled};

/// A box that keeps a distance from another.
pub trait Gap: BoxNode {
    /// Not more than the distance of any two rounded vertices, one in each box, in metres.
    ///
    /// The gaps along the three axes of one box are those of the other box's bounds along them, and
    /// together a distance. The slack of [`Placement`] bounds their errors however far apart the
    /// boxes are: the distance of centers along an axis, as it is stored, has only errors of 64 bits.
    /// That the axes are not quite orthonormal is allowed for at the end.
    fn gap(&self, other: &Self, placement: &Placement) -> f64;
}

impl Gap for ObbNode {
    fn gap(&self, other: &Self, placement: &Placement) -> f64 {
        let axes = self.axes.map(widen);
        let between = placement.between_centers(&self.center, &other.center);
        let turned = other.axes.map(|axis| apply(&placement.rotation, &widen(axis)));
        let c = axes.map(|axis| apply(&turned, &axis));
        gap(placement, [&self.half, &other.half], &apply(&axes, &between), &c)
    }
}

impl Gap for AabbNode {
    fn gap(&self, other: &Self, placement: &Placement) -> f64 {
        let between = placement.between_centers(&self.center, &other.center);
        gap(placement, [&self.half, &other.half], &between, &placement.rotation)
    }
}

/// As in [`crate::geometry::boxes`]: B's axes are the columns of `c`, its center is at `t`.
fn gap(placement: &Placement, [half_a, half_b]: [&[f32; 3]; 2], t: &Point, c: &Matrix) -> f64 {
    let (ha, hb) = (scaled(half_a, placement.fixed_scale), scaled(half_b, placement.moving_scale));
    let slack = placement.slack(&ha, &hb);
    let mut squared: f64 = (0..3)
        .map(|j| {
            let reach = hb[0] * c[j][0].abs() + hb[1] * c[j][1].abs() + hb[2] * c[j][2].abs();
            squared_gap(t[j], ha[j] + reach + slack)
        })
        .sum();
    if placement.rigid {
        let along_b = (0..3).map(|i| {
            let along = t[0] * c[0][i] + t[1] * c[1][i] + t[2] * c[2][i];
            let reach = ha[0] * c[0][i].abs() + ha[1] * c[1][i].abs() + ha[2] * c[2][i].abs();
            squared_gap(along, hb[i] + reach + slack)
        });
        squared = squared.max(along_b.sum());
    }
    squared.sqrt() * (1.0 - placement.relative_slack) * placement.unit
}

fn squared_gap(distance: f64, radius: f64) -> f64 {
    let gap = (distance.abs() - radius).max(0.0);
    gap * gap
}
