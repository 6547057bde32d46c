//! The test of [`super::triangles::decide`] without its bounds: every sign as 32 bits have it.
//! Nothing overflows in a leaf's frame; a corner that is no number would fail a comparison, and so make
//! no pair.

use super::triangles::{Lead, Vector, cross, dot, dot_add, negated, sub};
use crate::geometry::simd::{Lanes, three};

/// Bits of the pairs that meet, and of those to be tested one by one: the triangles in one plane,
/// and what is less than a triangle.
#[inline(always)]
pub fn decide<L: Lanes>(l: L, a: &[Vector<L>; 3], b: &[Vector<L>; 3], valid: u32) -> [u32; 2] {
    let between = sub(l, &b[0], &a[0]);

    let normal = cross(l, &a[1], &a[2]);
    let first = dot(l, &normal, &between);
    let sides_b = [first, dot_add(l, &normal, &b[1], first), dot_add(l, &normal, &b[2], first)];
    let of_b = Sides::of(l, &sides_b);

    let normal = cross(l, &b[1], &b[2]);
    let first = negated(l, dot(l, &normal, &between));
    let sides_a = [first, dot_add(l, &normal, &a[1], first), dot_add(l, &normal, &a[2], first)];
    let of_a = Sides::of(l, &sides_a);

    let alive = valid & !l.bits(l.or(of_a.strictly_one, of_b.strictly_one));
    let open = alive & l.bits(l.or(of_a.on_plane, of_b.on_plane));
    let across = alive & !open;
    if across == 0 {
        return [0, open];
    }

    let a = Lead::of(l, a, of_a.below);
    let b = Lead::of(l, b, of_b.below);
    let between = sub(l, &three!(k => l.add(between[k], b.corner[k])), &a.corner);
    let [q1, r1] = a.edges_in_order(l, b.below);
    let [q2, r2] = b.edges_in_order(l, a.below);
    let begins = negated(l, dot(l, &cross(l, &q1, &q2), &between));
    let ends = dot(l, &cross(l, &r1, &r2), &between);
    let nothing = l.splat(0.0);
    [across & l.bits(l.and(l.le(begins, nothing), l.le(ends, nothing))), open]
}

/// Where a triangle's corners lie from a plane.
struct Sides<L: Lanes> {
    strictly_one: L::M,
    on_plane: L::M,
    /// A corner on the plane counts as above if none is, otherwise as below: then one corner is
    /// alone on its side.
    below: [L::M; 3],
}

impl<L: Lanes> Sides<L> {
    #[inline(always)]
    fn of(l: L, d: &[L::F; 3]) -> Self {
        let nothing = l.splat(0.0);
        let all = l.le(nothing, nothing);
        let not_above = three!(k => l.le(d[k], nothing));
        let not_below = three!(k => l.le(nothing, d[k]));
        let none_above = l.and(l.and(not_above[0], not_above[1]), not_above[2]);
        let none_below = l.and(l.and(not_below[0], not_below[1]), not_below[2]);
        let some_on = l.or(
            l.and(not_above[0], not_below[0]),
            l.or(l.and(not_above[1], not_below[1]), l.and(not_above[2], not_below[2])),
        );
        let some_above = l.xor(none_above, all);
        Self {
            strictly_one: l.and(l.or(none_above, none_below), l.xor(some_on, all)),
            on_plane: l.and(none_above, none_below),
            below: three!(k => {
                l.and(not_above[k], l.or(some_above, l.xor(not_below[k], all)))
            }),
        }
    }
}
