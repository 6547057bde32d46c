//! What one pose means for all pairs of nodes: the moving image's node coordinates in the fixed
//! one's, and how much every box test must allow for error.
//!
//! **The bound.** Let `A`, `B` be the rounded axes of two nodes (columns), `R` the rotation,
//! `d` = [`AXES_TOLERANCE`] >= |A^T A - I|, |B^T B - I|, and `p` = |R^T R - I|. Boxes are what
//! `A y`, `|y_j| <= ha_j` reaches, so exact tests would use `A^-1`; they use `A^T`, off by at most
//! `1.01 d`. Only boxes that meet can be called apart wrongly, and their centres are at most the
//! sum `S` of both boxes' half extents from each other. Then the errors, relative to `S`, are at
//! most `1.01 d` for the translation, `2.1 d` for each radius, `2.1 d + p` for `C^T C - I` and 2.5
//! times that for a product of two columns of `C` against the third: together below
//! `9.4 d + 2.5 p < 2^-18 + 4 p`. Rounding in 64 bits, of the contract's transform and of what is
//! computed here, is at most 2^-45 of the largest number involved, which is below 2^5 units.

use super::TreeView;
use super::node::{AabbNode, Node, ObbNode, widen};
use crate::geometry::boxes::{
    Matrix, apart_on_axes_of_b, apart_on_axis_of_a, apart_on_products, apply,
};
use crate::geometry::triangle::StaticFilter;
use crate::geometry::{Point, Pose};

const RELATIVE_SLACK: f64 = 1.0 / (1_u64 << 18) as f64;
const ABSOLUTE_SLACK: f64 = 1.0 / (1_u64 << 40) as f64;

/// Beyond this |R^T R - I| only the tests that hold for any matrix are made.
const RIGID: f64 = 1.0 / 1024.0;

/// Lengths are in `unit`s chosen so that nothing over- or underflows.
#[derive(Clone, Debug)]
pub struct Placement {
    pub(super) rotation: Matrix,
    /// From the fixed image's origin to the placed origin of the moving one.
    offset: Point,
    pub(super) fixed_scale: f64,
    pub(super) moving_scale: f64,
    pub(super) relative_slack: f64,
    /// Bound on how much longer the rotation makes a vector.
    stretch: f64,
    pub(super) rigid: bool,
    leaf_reach: f64,
    /// In metres.
    pub(super) unit: f64,
}

impl Placement {
    pub fn new(fixed: &TreeView<'_>, moving: &TreeView<'_>, pose: &Pose) -> Self {
        let (a, b) = (fixed.header(), moving.header());
        let r = &pose.rotation;
        let rotation = [[r[0], r[1], r[2]], [r[3], r[4], r[5]], [r[6], r[7], r[8]]];
        let deviation = deviation_from_rotation(&rotation);
        // Not `>`: an overflowed norm is not rigid either.
        let rigid = deviation <= RIGID;
        let norm = r.iter().map(|c| c * c).sum::<f64>().sqrt();
        let stretch = if rigid { 1.0 + RIGID } else { norm };
        let unit = super::power_of_two_above(
            largest(&a.origin)
                + 2.0 * a.unit
                + 3.0 * stretch * (largest(&b.origin) + 2.0 * b.unit)
                + largest(&pose.translation),
        );
        let turned = apply(&rotation, &b.origin.map(|c| c / unit));
        let offset = [0, 1, 2].map(|i| turned[i] + pose.translation[i] / unit - a.origin[i] / unit);
        let (fixed_scale, moving_scale) = (a.unit / unit, b.unit / unit);
        // Two leaves are compared only if they overlap along the three axes of the fixed one's box;
        // then no vertex of one is further from a vertex of the other than this.
        let leaf_reach =
            fixed_scale * a.leaf_diameter + 1.75 * stretch * moving_scale * b.leaf_diameter;
        Self {
            rotation,
            offset,
            fixed_scale,
            moving_scale,
            relative_slack: RELATIVE_SLACK + 4.0 * deviation.min(RIGID),
            stretch,
            rigid,
            leaf_reach: (leaf_reach * 1.001 + ABSOLUTE_SLACK) * unit,
            unit,
        }
    }

    /// The predicates' filter for every pair of leaves that the box tests let through.
    pub fn static_filter(&self) -> StaticFilter {
        StaticFilter::for_extent([self.leaf_reach; 3])
    }

    /// Whether what is certain of leaves' triangles in 32 bits ([`super::wide`]) is far from what
    /// over- and underflow make of determinants in plain f64.
    ///
    /// In 32 bits only determinants beyond 2^-120 are certain, in cubes of the fixed image's unit, and
    /// only where nothing is more than 2^52 such units away. That makes less than 2^17 of them in the
    /// reach: with the least one that is allowed, such a determinant is beyond 2^-920. What underflow
    /// takes from one, and the reach that nothing overflows below, are in [`StaticFilter`].
    pub fn suits_plain_f64(&self) -> bool {
        (1e-75..=1e102).contains(&self.leaf_reach)
    }

    #[inline(always)]
    pub(super) fn slack(&self, ha: &Point, hb: &Point) -> f64 {
        let sum = ha[0] + ha[1] + ha[2] + self.stretch * (hb[0] + hb[1] + hb[2]);
        self.relative_slack * sum + ABSOLUTE_SLACK
    }

    /// Which of two nodes to open: the one with the longer box.
    #[inline(always)]
    pub fn first_is_larger<N: Node>(&self, a: &N, b: &N) -> bool {
        let (ha, hb) = (a.half(), b.half());
        (ha[0] + ha[1] + ha[2]) * self.fixed_scale >= (hb[0] + hb[1] + hb[2]) * self.moving_scale
    }

    #[inline(always)]
    pub(super) fn between_centers(&self, a: &[f32; 3], b: &[f32; 3]) -> Point {
        let a = scaled(a, self.fixed_scale);
        let turned = apply(&self.rotation, &scaled(b, self.moving_scale));
        [
            turned[0] + self.offset[0] - a[0],
            turned[1] + self.offset[1] - a[1],
            turned[2] + self.offset[2] - a[2],
        ]
    }
}

fn largest(v: &Point) -> f64 {
    v.iter().fold(0.0, |most, c| most.max(c.abs()))
}

pub(super) fn deviation_from_rotation(m: &Matrix) -> f64 {
    let mut squares = 0.0;
    for i in 0..3 {
        for j in 0..3 {
            let dot: f64 = (0..3).map(|k| m[k][i] * m[k][j]).sum();
            let error = dot - f64::from(u8::from(i == j));
            squares += error * error;
        }
    }
    squares.sqrt()
}

/// A node that can be tested against another of its kind.
pub trait BoxNode: Node {
    /// True only if the boxes, and all rounded vertices in them, are certainly apart.
    fn apart(&self, other: &Self, placement: &Placement) -> bool;
}

impl BoxNode for ObbNode {
    #[inline(always)]
    fn apart(&self, other: &Self, placement: &Placement) -> bool {
        let ha = scaled(&self.half, placement.fixed_scale);
        let hb = scaled(&other.half, placement.moving_scale);
        let slack = placement.slack(&ha, &hb);
        let axes = [widen(self.axes[0]), widen(self.axes[1]), widen(self.axes[2])];
        let between = placement.between_centers(&self.center, &other.center);
        let t = apply(&axes, &between);
        let turned = [
            apply(&placement.rotation, &widen(other.axes[0])),
            apply(&placement.rotation, &widen(other.axes[1])),
            apply(&placement.rotation, &widen(other.axes[2])),
        ];
        // A row only when it is needed: most boxes that are apart are so on the first axis or two.
        let mut c = [[0.0; 3]; 3];
        for j in 0..3 {
            c[j] = apply(&turned, &axes[j]);
            if apart_on_axis_of_a(ha[j], &hb, t[j], &c[j], slack) {
                return true;
            }
        }
        placement.rigid
            && (apart_on_axes_of_b(&ha, &hb, &t, &c, slack)
                || apart_on_products(&ha, &hb, &t, &c, slack))
    }
}

impl BoxNode for AabbNode {
    /// Without the products of axes: they are apart on them alone too seldom to pay for the test.
    #[inline(always)]
    fn apart(&self, other: &Self, placement: &Placement) -> bool {
        let ha = scaled(&self.half, placement.fixed_scale);
        let hb = scaled(&other.half, placement.moving_scale);
        let slack = placement.slack(&ha, &hb);
        let t = placement.between_centers(&self.center, &other.center);
        let c = &placement.rotation;
        let on = |j: usize| apart_on_axis_of_a(ha[j], &hb, t[j], &c[j], slack);
        on(0) || on(1) || on(2) || placement.rigid && apart_on_axes_of_b(&ha, &hb, &t, c, slack)
    }
}

#[inline(always)]
pub(super) fn scaled(v: &[f32; 3], scale: f64) -> Point {
    [f64::from(v[0]) * scale, f64::from(v[1]) * scale, f64::from(v[2]) * scale]
}
