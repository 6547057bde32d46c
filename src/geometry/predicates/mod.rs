//! Signs of the orientation predicates, never wrong for any finite coordinates.
//!
//! A sign is decided by the first stage that can prove it:
//! 1. the determinant in plain f64 against a [`StaticFilter`] (Meyer & Pion 2008);
//! 2. two equal points, or all on a plane across an axis: zero;
//! 3. expansions, as long as the points need them (Shewchuk 1997, crate `robust`), while nothing
//!    in them can under- or overflow;
//! 4. integers without limit.

mod filter;
pub(super) mod integer;
mod plane;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use robust::{Coord, Coord3D};

use super::Point;
pub use filter::StaticFilter;
pub use plane::{Plane, Sides};

/// A point of one of the three coordinate planes.
pub type Point2 = [f64; 2];

/// Where `d` lies from the plane through `a`, `b`, `c`: the sign of (b-a) x (c-a) . (d-a).
///
/// `Greater` is the side from which `a`, `b`, `c` are seen counterclockwise; `Equal` also if
/// `a`, `b`, `c` are collinear. Requires `filter` to hold for the four points.
#[inline]
pub fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point, filter: &StaticFilter) -> Ordering {
    let determinant = dot(cross(sub(b, a), sub(c, a)), sub(d, a));
    if filter.is_positive(determinant) {
        Ordering::Greater
    } else if filter.is_negative(determinant) {
        Ordering::Less
    } else {
        orient3d_exact([a, b, c, d])
    }
}

/// Where `c` lies from the line from `a` to `b`: `Greater` to its left, `Equal` also if `a` is
/// `b`.
pub fn orient2d(a: &Point2, b: &Point2, c: &Point2) -> Ordering {
    if a == b || b == c || c == a {
        return Ordering::Equal;
    }
    // Lowest bits of coordinates are at least 2^-502 and of their products 2^-1004: far enough
    // above 2^-1074 for the error bounds of the expansions to be normal numbers as well.
    const WINDOW: [f64; 2] = [power_of_two(-450), power_of_two(480)];
    if !all_within(WINDOW, [a, b, c].into_iter().flatten()) {
        return integer::orient2d([a, b, c]);
    }
    let [a, b, c] = [a, b, c].map(|&[x, y]| Coord { x, y });
    sign(robust::orient2d(a, b, c))
}

/// [`orient3d`] for points that no filter has decided.
#[cold]
#[inline(never)]
fn orient3d_exact(points: [&Point; 4]) -> Ordering {
    let [a, b, c, d] = points;
    let equal_points = a == b || a == c || a == d || b == c || b == d || c == d;
    if equal_points || (0..3).any(|k| a[k] == b[k] && a[k] == c[k] && a[k] == d[k]) {
        return Ordering::Equal;
    }
    // As in orient2d: lowest bits of coordinates are at least 2^-332, of three's product 2^-996;
    // the largest sum stays below 2^1000.
    const WINDOW: [f64; 2] = [power_of_two(-280), power_of_two(330)];
    if !all_within(WINDOW, points.into_iter().flatten()) {
        return integer::orient3d(points);
    }
    let [a, b, c, d] = points.map(|&[x, y, z]| Coord3D { x, y, z });
    // Shewchuk's orientation is positive on the other side.
    sign(robust::orient3d(a, b, c, d)).reverse()
}

#[inline]
fn sub(a: &Point, b: &Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sign(determinant: f64) -> Ordering {
    determinant.partial_cmp(&0.0).expect("a determinant of numbers within a window is a number")
}

fn all_within<'a>([low, high]: [f64; 2], coordinates: impl Iterator<Item = &'a f64>) -> bool {
    coordinates.map(|c| c.abs()).all(|c| c == 0.0 || (low <= c && c <= high))
}

/// 2^exponent, for exponents of normal numbers.
const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}
