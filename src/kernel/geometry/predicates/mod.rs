//! Signs of the orientation predicates, never wrong for any finite coordinates.
//!
//! A sign is decided by the first stage that can prove it:
//! 1. the determinant in plain f64 against a [`StaticFilter`] (Meyer & Pion 2008), in two
//!    dimensions against a bound from its own two products;
//! 2. two equal points, or all on a plane across an axis: zero; in two dimensions, signs of
//!    differences that show which product is greater;
//! 3. plain f64 where all coordinates are on a `grid` so coarse that nothing is rounded;
//! 4. expansions, as long as the points need them (Shewchuk 1997, crate `robust`), while nothing
//!    in them can under- or overflow;
//! 5. integers without limit.

mod filter;
mod grid;
pub(super) mod integer;
mod plane;
mod signs;
mod tally;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use robust::{Coord, Coord3D};

use super::Point;
pub use filter::StaticFilter;
pub use plane::{Plane, Sides};
pub use signs::{Certain, FaceValue, Scalar, Signs};
pub use tally::{Stage, StageCounter, StageCounts, Tally, Untold};

/// A point of one of the three coordinate planes.
pub type Point2 = [f64; 2];

/// Where `d` lies from the plane through `a`, `b`, `c`: the sign of (b-a) x (c-a) . (d-a).
///
/// `Greater` is the side from which `a`, `b`, `c` are seen counterclockwise; `Equal` also if
/// `a`, `b`, `c` are collinear. Requires `filter` to hold for the four points.
#[inline]
pub fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point, filter: &StaticFilter) -> Ordering {
    orient3d_told(a, b, c, d, filter, Untold)
}

#[inline]
fn orient3d_told<T: Tally>(
    a: &Point,
    b: &Point,
    c: &Point,
    d: &Point,
    filter: &StaticFilter,
    tally: T,
) -> Ordering {
    let determinant = dot(cross(sub(b, a), sub(c, a)), sub(d, a));
    if filter.is_positive(determinant) {
        tally.decided(Stage::Filter, 1);
        Ordering::Greater
    } else if filter.is_negative(determinant) {
        tally.decided(Stage::Filter, 1);
        Ordering::Less
    } else {
        orient3d_exact([a, b, c, d], tally)
    }
}

/// [`orient3d`] for points that no filter has decided.
#[cold]
#[inline(never)]
fn orient3d_exact<T: Tally>(points: [&Point; 4], tally: T) -> Ordering {
    let [a, b, c, d] = points;
    if (0..3).any(|k| a[k] == b[k] && a[k] == c[k] && a[k] == d[k]) {
        tally.decided(Stage::Structure, 1);
        return Ordering::Equal;
    }
    if let Some(order) = grid::orient3d(points) {
        tally.decided(Stage::Grid, 1);
        return order;
    }
    if a == b || a == c || a == d || b == c || b == d || c == d {
        tally.decided(Stage::Structure, 1);
        return Ordering::Equal;
    }
    // Lowest bits of coordinates are at least 2^-332, of three's product 2^-996: far enough above
    // 2^-1074 for the error bounds of the expansions to be normal numbers as well. The largest sum
    // stays below 2^1000.
    const WINDOW: [f64; 2] = [power_of_two(-280), power_of_two(330)];
    if !all_within(WINDOW, points.into_iter().flatten()) {
        tally.decided(Stage::Integers, 1);
        return integer::orient3d(points);
    }
    tally.decided(Stage::Expansions, 1);
    let [a, b, c, d] = points.map(|&[x, y, z]| Coord3D { x, y, z });
    // Shewchuk's orientation is positive on the other side.
    sign(robust::orient3d(a, b, c, d)).reverse()
}

/// Where `c` lies from the line from `a` to `b`: `Greater` to its left, `Equal` also if `a` is
/// `b`.
pub fn orient2d(a: &Point2, b: &Point2, c: &Point2) -> Ordering {
    orient2d_told(a, b, c, Untold)
}

/// The determinant is `left - right`, each a product of two differences.
///
/// - A difference is zero only between equals, and its sign is right even if it overflows: where
///   the products' signs, made of those, differ, they decide.
/// - Where they are the same, and with u = 2^-53: each product is off by at most 3.01u of itself,
///   two roundings of factors and one of its own, as long as it is a normal number; subtracting
///   rounds once more. So a difference beyond 4.05u (|left| + |right|) has the right sign. The
///   lower end of the range leaves in that bound more than underflow of the smaller product adds;
///   at the upper end the comparison with infinity, or with what is no number, fails.
#[inline]
fn orient2d_told<T: Tally>(a: &Point2, b: &Point2, c: &Point2, tally: T) -> Ordering {
    let (bx, by) = (b[0] - a[0], b[1] - a[1]);
    let (cx, cy) = (c[0] - a[0], c[1] - a[1]);
    let (left_sign, right_sign) = (side(bx) * side(cy), side(by) * side(cx));
    if left_sign != right_sign || left_sign == 0 {
        tally.decided(Stage::Structure, 1);
        return left_sign.cmp(&right_sign);
    }
    let (left, right) = (bx * cy, by * cx);
    let (difference, sum) = (left - right, (left + right).abs());
    if difference.abs() > 4.5e-16 * sum && sum > 1e-250 {
        tally.decided(Stage::Filter, 1);
        return sign(difference);
    }
    orient2d_exact([a, b, c], tally)
}

#[inline]
fn side(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

/// [`orient2d`] for points that no filter has decided.
#[cold]
#[inline(never)]
fn orient2d_exact<T: Tally>(points: [&Point2; 3], tally: T) -> Ordering {
    let [a, b, c] = points;
    if b == c {
        tally.decided(Stage::Structure, 1);
        return Ordering::Equal;
    }
    if let Some(order) = grid::orient2d(points) {
        tally.decided(Stage::Grid, 1);
        return order;
    }
    // As in orient3d: lowest bits of coordinates are at least 2^-502, of their products 2^-1004.
    const WINDOW: [f64; 2] = [power_of_two(-450), power_of_two(480)];
    if !all_within(WINDOW, points.into_iter().flatten()) {
        tally.decided(Stage::Integers, 1);
        return integer::orient2d(points);
    }
    tally.decided(Stage::Expansions, 1);
    let [a, b, c] = [a, b, c].map(|&[x, y]| Coord { x, y });
    sign(robust::orient2d(a, b, c))
}

#[inline]
pub(super) fn sub<S: Scalar>(a: &[S; 3], b: &[S; 3]) -> [S; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(super) fn cross<S: Scalar>(a: [S; 3], b: [S; 3]) -> [S; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub(super) fn dot<S: Scalar>(a: [S; 3], b: [S; 3]) -> S {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sign(determinant: f64) -> Ordering {
    determinant.partial_cmp(&0.0).expect("a determinant of numbers within a window is a number")
}

fn all_within<'a>([low, high]: [f64; 2], coordinates: impl Iterator<Item = &'a f64>) -> bool {
    coordinates.map(|c| c.abs()).all(|c| c == 0.0 || (low <= c && c <= high))
}

/// 2^exponent, for exponents of normal numbers.
pub const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}
