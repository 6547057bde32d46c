//! Which leaves meet: turned box against turned box, one pair a lane (Gottschalk 2000, chapter 5).
//!
//! # The bounds
//! `S` is the sum of all half extents of both boxes in the fixed unit, `u` = 2^-24, `d` = 2.5e-7
//! bounds |Q^T Q - I| of a leaf's axes, `p` = |R^T R - I| of the rotation. Only leaves that meet
//! can be called apart wrongly; then their centers are at most S apart.
//!
//! The centers' distance is taken in 64 bits and rounded once. In the fixed leaf's frame it has an
//! error of 4uS (that rounding, one product and two sums). The rotation from frame to frame, two
//! matrix products of entries that are at most 1, has one of 10u in each entry. Then on an axis of
//! the fixed box the errors are below 20uS, on one of the moving box, a column of three entries,
//! below 50uS, on a product of both below 49uS. What is not quite orthonormal adds at most
//! `9.4 d S + 2.5 p S` (see [`crate::tree::placement`]): together less than `2^-17 S + 4 p S`.
//!
//! **Error of a moving corner in the fixed leaf's frame.** What the triangle tests compare are
//! images of the contract's vertices under the fixed leaf's axes as they are, a linear map, which
//! changes no intersection. With `a` and `b` the sums of half extents of the two boxes: the frame's
//! inverse replaced by its transpose, 4.3ub; rounding of the stored corner, 1ub; the rotation, 10ub;
//! products and sums, 4ub + 3u(a + b); the centers' distance, 4.1u(a + b). That is below
//! u(27 b + 8 a), and a stored corner of the fixed leaf is off by 1ua. What is inexact in 64 bits is
//! in `inexact`.

use super::node::LeafBox;
use super::place::LeafPlace;
use crate::geometry::simd::{Lanes, three};

/// Leaf pairs side by side, and for each the transform of the moving leaf's corners.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// From the moving leaf's frame to the fixed one's, row major; with the scale.
    pub matrix: [[f32; 16]; 9],
    pub offset: [[f32; 16]; 3],
    /// Half extents of the moving box along the fixed one's axes.
    pub reach: [[f32; 16]; 3],
    /// Sums of the half extents of each box.
    pub fixed_size: [f32; 16],
    pub moving_size: [f32; 16],
    pub inexact: f32,
}

impl Meeting {
    pub const NONE: Self = Self {
        matrix: [[0.0; 16]; 9],
        offset: [[0.0; 16]; 3],
        reach: [[0.0; 16]; 3],
        fixed_size: [0.0; 16],
        moving_size: [0.0; 16],
        inexact: 0.0,
    };
}

/// Both boxes of each pair in the frame of the fixed one, in the fixed unit.
pub struct Turned<L: Lanes> {
    pub fixed_half: [L::F; 3],
    pub moving_half: [L::F; 3],
    /// From the fixed center to the moving one.
    pub between: [L::F; 3],
    /// Axes of the moving box as columns.
    pub axes: [[L::F; 3]; 3],
    pub absolute: [[L::F; 3]; 3],
    /// Half extents of the moving box along the fixed one's axes.
    pub reach: [L::F; 3],
    /// Sums of the half extents.
    pub fixed_size: L::F,
    pub moving_size: L::F,
}

impl<L: Lanes> Turned<L> {
    #[inline(always)]
    pub fn new(l: L, place: &LeafPlace, fixed: &[&[f32; 16]], moving: &[&[f32; 16]]) -> Self {
        let a = l.transpose(fixed);
        let b = l.transpose(moving);
        let scale = l.splat(place.scale);
        let fixed_half = [a[12], a[13], a[14]];
        let moving_half = three!(i => l.mul(b[12 + i], scale));
        let between = between_centers(l, place, &[a[9], a[10], a[11]], &[b[9], b[10], b[11]]);
        let axes_a = three!(j => [a[3 * j], a[3 * j + 1], a[3 * j + 2]]);
        let axes_b = three!(i => [b[3 * i], b[3 * i + 1], b[3 * i + 2]]);
        let r = &place.rotation;
        let columns = three!(i => [l.splat(r[0][i]), l.splat(r[1][i]), l.splat(r[2][i])]);
        let turned = three!(j => three!(i => dot(l, &axes_a[j], &columns[i])));
        let axes = three!(j => three!(i => dot(l, &turned[j], &axes_b[i])));
        let absolute = three!(j => three!(i => l.abs(axes[j][i])));
        Self {
            between: three!(j => dot(l, &axes_a[j], &between)),
            reach: three!(j => dot(l, &absolute[j], &moving_half)),
            fixed_size: sum(l, &fixed_half),
            moving_size: sum(l, &moving_half),
            fixed_half,
            moving_half,
            axes,
            absolute,
        }
    }

    /// Of the distance of the centers along axis `i` of the moving box.
    #[inline(always)]
    pub fn along_moving(&self, l: L, i: usize) -> L::F {
        let c = &self.axes;
        l.abs(dot(l, &[c[0][i], c[1][i], c[2][i]], &self.between))
    }

    /// Half extents of the fixed box along axis `i` of the moving one.
    #[inline(always)]
    pub fn reach_of_fixed(&self, l: L, i: usize) -> L::F {
        let m = &self.absolute;
        dot(l, &[m[0][i], m[1][i], m[2][i]], &self.fixed_half)
    }

    #[inline(always)]
    pub fn store(&self, l: L, place: &LeafPlace, out: &mut Meeting) {
        let scale = l.splat(place.scale);
        l.store(&mut out.fixed_size, self.fixed_size);
        l.store(&mut out.moving_size, self.moving_size);
        out.inexact = place.inexact;
        for j in 0..3 {
            l.store(&mut out.offset[j], self.between[j]);
            l.store(&mut out.reach[j], self.reach[j]);
            for (i, &entry) in self.axes[j].iter().enumerate() {
                l.store(&mut out.matrix[3 * j + i], l.mul(entry, scale));
            }
        }
    }
}

/// Bits of the lanes that meet.
#[inline(always)]
pub fn meet<L: Lanes>(
    l: L,
    place: &LeafPlace,
    fixed: &[&[f32; 16]],
    moving: &[&[f32; 16]],
    out: &mut Meeting,
) -> u32 {
    let turned = Turned::new(l, place, fixed, moving);
    let Turned { fixed_half: ha, moving_half: hb, between: t, axes: c, absolute: m, .. } = &turned;
    let inexact = l.splat(place.inexact);
    let both = l.add(turned.fixed_size, turned.moving_size);
    let slack = l.mul_add(both, l.splat(place.relative_slack), inexact);

    let on_a = three!(j => l.le(l.abs(t[j]), l.add(turned.reach[j], l.add(ha[j], slack))));
    let on_b = three!(i => {
        let radius = l.add(turned.reach_of_fixed(l, i), l.add(hb[i], slack));
        l.le(turned.along_moving(l, i), radius)
    });
    let on_products = three!(j => three!(i => {
        let (k, n) = ((j + 1) % 3, (j + 2) % 3);
        let (v, w) = ((i + 1) % 3, (i + 2) % 3);
        let distance = l.mul_sub(t[n], c[k][i], l.mul(t[k], c[n][i]));
        let radius = l.mul_add(ha[n], m[k][i], l.mul_add(ha[k], m[n][i], slack));
        let radius = l.mul_add(hb[v], m[j][w], l.mul_add(hb[w], m[j][v], radius));
        l.le(l.abs(distance), radius)
    }));
    let mut all = l.and(l.and(on_a[0], on_a[1]), on_a[2]);
    all = l.and(all, l.and(l.and(on_b[0], on_b[1]), on_b[2]));
    for on in on_products {
        all = l.and(all, l.and(l.and(on[0], on[1]), on[2]));
    }
    turned.store(l, place, out);
    l.bits(all)
}

/// From the fixed centers to the placed moving ones.
#[inline(always)]
fn between_centers<L: Lanes>(l: L, place: &LeafPlace, a: &[L::F; 3], b: &[L::F; 3]) -> [L::F; 3] {
    let b = three!(k => l.widen(b[k]));
    three!(j => {
        let a = l.widen(a[j]);
        let row = three!(k => l.splat_d(place.matrix[j][k]));
        let offset = l.splat_d(place.offset[j]);
        let low = affine(l, &row, &[b[0][0], b[1][0], b[2][0]], l.sub_d(offset, a[0]));
        let high = affine(l, &row, &[b[0][1], b[1][1], b[2][1]], l.sub_d(offset, a[1]));
        l.narrow([low, high])
    })
}

#[inline(always)]
fn affine<L: Lanes>(l: L, row: &[L::D; 3], v: &[L::D; 3], start: L::D) -> L::D {
    let with_y = l.mul_add_d(row[1], v[1], l.mul_add_d(row[0], v[0], start));
    l.mul_add_d(row[2], v[2], with_y)
}

#[inline(always)]
fn sum<L: Lanes>(l: L, v: &[L::F; 3]) -> L::F {
    l.add(l.add(v[0], v[1]), v[2])
}

#[inline(always)]
fn dot<L: Lanes>(l: L, a: &[L::F; 3], b: &[L::F; 3]) -> L::F {
    l.mul_add(a[2], b[2], l.mul_add(a[1], b[1], l.mul(a[0], b[0])))
}

/// Words of a leaf's box as [`meet`] takes them: axes, center, half extents.
#[inline(always)]
pub fn words(leaf: &LeafBox) -> &[f32; 16] {
    bytemuck::cast_ref(leaf)
}
