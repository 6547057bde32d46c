//! Bounds of the distance of a node's boxes and one box.

use crate::geometry::simd::{Lanes, Row, three};
use crate::tree::wide::descend::row_times;
use crate::tree::wide::node::{WIDTH, WideChild, WideNode};
use crate::tree::wide::place::Way;

/// The children of an opened node X that are not certainly beyond the limit of the box Y: bits by
/// what comes next, as in [`crate::tree::wide::descend::Opened`].
pub struct Bounded<'a> {
    pub again: u32,
    pub other: u32,
    pub leaves: u32,
    /// Of the squared distance. Lanes without a bit mean nothing.
    pub bounds: Row,
    pub children: &'a [WideChild; WIDTH],
    pub box_child: WideChild,
}

/// `to_fixed`: squares of the fixed unit in one of X's.
#[inline(always)]
pub fn bound<'a, L: Lanes>(
    l: L,
    way: &Way,
    nodes: &'a [WideNode],
    others: &[WideNode],
    [node, slot]: [u32; 2],
    [to_fixed, limit]: [f32; 2],
) -> Bounded<'a> {
    let x = &nodes[node as usize];
    let (y, lane) = (&others[slot as usize / WIDTH], slot as usize % WIDTH);
    let squared = l.mul(squared_gaps(l, way, x, y, lane), l.splat(to_fixed));
    let mut bounds = [0.0; WIDTH];
    l.store(&mut bounds, squared);
    // No number in lanes that are not used: they are beyond every limit.
    let near = l.bits(l.le(squared, l.splat(limit)));
    let words: &[u32; WIDTH] = bytemuck::cast_ref(&x.child);
    let leaf = l.top_bits(l.load_u(words));
    let area = l.splat(y.area[lane] * way.scale_squared);
    let larger = l.bits(l.le(area, l.load(&x.area)));
    let box_child = y.child[lane];
    let box_is_leaf = 0_u32.wrapping_sub(u32::from(box_child.is_leaf()));
    let again = near & !leaf & (larger | box_is_leaf);
    let leaves = near & leaf & box_is_leaf;
    let other = near & !(again | leaves);
    Bounded { again, other, leaves, bounds, children: &x.child, box_child }
}

/// For each child of `x` a bound of the squared distance to lane `lane` of `y`, in X's unit: from
/// the gaps along the axes of X, or those of Y, whichever is more.
///
/// The slack of [`Way`] bounds the errors of all gaps, for boxes that are apart as for those that
/// meet. That squares and sums are rounded, and that a rotation is not quite one, is allowed for in
/// the limit ([`super::leaves::LeafStage::limit`]).
#[inline(always)]
fn squared_gaps<L: Lanes>(l: L, way: &Way, x: &WideNode, y: &WideNode, lane: usize) -> L::F {
    let slack = l.splat(way.slack);
    let center = three!(k => l.splat(y.center[k][lane]));
    let half = three!(k => l.splat(y.half[k][lane]));
    let halves = three!(k => l.load(&x.half[k]));
    let distance = three!(j => {
        let at = row_times(l, &way.matrix[j], &center, l.load(&way.offset[j]));
        l.sub(at, l.load(&x.center[j]))
    });
    let on_x = three!(j => {
        let radius = row_times(l, &way.absolute[j], &half, slack);
        l.sub(l.abs(distance[j]), l.add(halves[j], radius))
    });
    let on_y = three!(i => {
        let own = l.mul_add(half[i], l.splat(way.scale), slack);
        let radius = row_times(l, &way.absolute_axes[i], &halves, own);
        l.sub(l.abs(row_times(l, &way.axes[i], &distance, l.splat(0.0))), radius)
    });
    l.max(squared_norm(l, &on_x), squared_norm(l, &on_y))
}

/// Of what is positive. A gap that is no number makes it none: the second operand of a maximum wins.
#[inline(always)]
pub fn squared_norm<L: Lanes>(l: L, gaps: &[L::F; 3]) -> L::F {
    let [x, y, z] = three!(k => l.max(l.splat(0.0), gaps[k]));
    l.mul_add(z, z, l.mul_add(y, y, l.mul(x, x)))
}
