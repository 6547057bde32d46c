//! What one pose means for 32-bit tests: transforms, and how much every test must allow for error.
//!
//! Throughout, `u` = 2^-24 bounds the relative rounding of a 32-bit operation. Bounds are counted
//! with a rounding after every product and every sum, so that they hold with and without FMA.

use super::node::WIDTH;
use crate::geometry::boxes::{Matrix, apply};
use crate::geometry::simd::Row;
use crate::geometry::{Point, Pose};
use crate::tree::TreeView;
use crate::tree::placement::deviation_from_rotation;

/// Beyond this |R^T R - I|, and beyond this ratio of units or distance, all work is done in 64
/// bits.
const RIGID: f64 = 1.0 / (1 << 14) as f64;
const RATIO: f64 = 1024.0;
const FAR: f64 = 4096.0;

const U: f64 = 1.0 / (1 << 24) as f64;

/// A pose of two trees, for the 32-bit tests.
pub struct Place {
    /// Moving boxes against children of fixed nodes, in the fixed tree's frame and unit.
    pub into_fixed: Way,
    /// Fixed boxes against children of moving nodes.
    pub into_moving: Way,
    pub leaves: LeafPlace,
}

/// From the frame and unit of a tree Y to those of a tree X.
///
/// # The slack
/// Node coordinates are at most 1. With `G` as in [`Way::new`], a bound on every coordinate that
/// comes up, the center of Y's box has after its transform an error of 5uG (one rounding of each
/// matrix entry, three products, three sums), the distance of centers 7uG, a radius from Y's half
/// extents 5uG. Along an axis of X that and the last sums make less than 16uG. Along an axis of Y,
/// whose absolute entries sum up to at most sqrt(3): 12uG times that for the distance, 5u times
/// that for the radius from X's half extents, and 4uG of sums: less than 34uG. Allowed are 40uG.
/// R^T stands for the inverse of R, which adds 3.1 times |R^T R - I| of Y's unit. What the
/// contract's own rounding and that of 64-bit numbers here add is in `inexact`.
pub struct Way {
    /// Row major, to X's unit; as all that follows once a lane, ready to be loaded.
    pub matrix: [[Row; 3]; 3],
    pub absolute: [[Row; 3]; 3],
    /// Y's axes in X's frame: row i is axis i.
    pub axes: [[Row; 3]; 3],
    pub absolute_axes: [[Row; 3]; 3],
    pub offset: [Row; 3],
    /// X's units in one of Y's: a power of two.
    pub scale: f32,
    /// X's units squared in one of Y's, to compare areas.
    pub scale_squared: f32,
    pub slack: f32,
}

/// Moving leaves into the fixed tree's frame and unit.
pub struct LeafPlace {
    pub rotation: [[f32; 3]; 3],
    /// Row major, rotation and scale.
    pub matrix: Matrix,
    pub offset: Point,
    pub scale: f32,
    /// Relative to both boxes' half extents, see [`super::leaf_boxes`].
    pub relative_slack: f32,
    /// In the fixed tree's unit.
    pub inexact: f32,
}

impl Place {
    /// `None` for a pose or trees that 32 bits are not made for.
    pub fn new(fixed: &TreeView<'_>, moving: &TreeView<'_>, pose: &Pose) -> Option<Self> {
        let (a, b) = (fixed.header(), moving.header());
        let r = &pose.rotation;
        let rotation = [[r[0], r[1], r[2]], [r[3], r[4], r[5]], [r[6], r[7], r[8]]];
        let deviation = deviation_from_rotation(&rotation);
        let scale = b.unit / a.unit;
        // Everything that the contract's transform and the offset add up, in the fixed unit.
        let sum = (0..3)
            .map(|i| {
                let turned = (0..3).map(|k| rotation[i][k].abs() * (b.origin[k].abs() + b.unit));
                (turned.sum::<f64>() + pose.translation[i].abs() + a.origin[i].abs()) / a.unit
            })
            .fold(1.0, f64::max);
        let turned = apply(&rotation, &b.origin);
        let offset = [0, 1, 2].map(|i| ((turned[i] + pose.translation[i]) - a.origin[i]) / a.unit);
        let usable = deviation <= RIGID
            && (1.0 / RATIO..=RATIO).contains(&scale)
            && offset.iter().all(|c| c.abs() <= FAR)
            && sum <= 1.0 / f64::EPSILON;
        if !usable {
            return None;
        }
        // Less than a hundred roundings in 64 bits of at most `sum`; the second term is for
        // numbers too small to be rounded relatively.
        let inexact = sum * f64::EPSILON * 64.0 + 1.0 / (1_u64 << 60) as f64;
        let back = transposed(&rotation);
        let away = apply(&back, &offset).map(|c| -c / scale);
        Some(Self {
            into_fixed: Way::new(&rotation, &offset, scale, deviation, inexact),
            into_moving: Way::new(
                &back,
                &away,
                1.0 / scale,
                // Going back with R^T instead of the inverse also moves centers and the offset.
                deviation * (2.0 + largest(&offset)),
                inexact / scale,
            ),
            leaves: LeafPlace {
                rotation: rotation.map(|row| row.map(|x| x as f32)),
                matrix: rotation.map(|row| row.map(|x| x * scale)),
                offset,
                scale: scale as f32,
                relative_slack: (1.0 / f64::from(1 << 17) + 4.0 * deviation) as f32,
                inexact: inexact as f32,
            },
        })
    }
}

impl Way {
    fn new(rotation: &Matrix, offset: &Point, scale: f64, deviation: f64, inexact: f64) -> Self {
        let matrix = rotation.map(|row| row.map(|x| x * scale));
        let reach = |i: usize| matrix[i].iter().map(|x| x.abs()).sum::<f64>() + offset[i].abs();
        let g = 1.02 * (1.0 + reach(0).max(reach(1)).max(reach(2)));
        let slack = 40.0 * U * g + 3.1 * deviation * scale + inexact;
        let axes = transposed(rotation);
        let lanes = |m: &Matrix| m.map(|row| row.map(|x| [x as f32; WIDTH]));
        let absolute = |m: &Matrix| m.map(|row| row.map(|x| [x.abs() as f32; WIDTH]));
        Self {
            matrix: lanes(&matrix),
            absolute: absolute(&matrix),
            axes: lanes(&axes),
            absolute_axes: absolute(&axes),
            offset: offset.map(|x| [x as f32; WIDTH]),
            scale: scale as f32,
            scale_squared: (scale * scale) as f32,
            slack: slack as f32,
        }
    }
}

fn transposed(m: &Matrix) -> Matrix {
    [0, 1, 2].map(|i| [m[0][i], m[1][i], m[2][i]])
}

fn largest(v: &Point) -> f64 {
    v.iter().fold(0.0, |most, c| most.max(c.abs()))
}
