//! Signs in plain f64 where nothing is rounded: points on a common grid, as those of parts that
//! were drawn in whole steps and stand on each other.
//!
//! Let `q` be a power of two and let all coordinates be whole multiples of `q`, below 2^51 q. Then
//! their differences are exact. If these are at most M = 2^17 q, so is all that follows: a product
//! of two is at most 2^34 qq, a difference of two such 2^35 qq, times a third difference 2^52 qqq,
//! and the sum of two of those at most 2^53 qqq, all whole multiples of a power of q. The last sum
//! may be rounded, which changes no sign.

use std::cmp::Ordering;
use std::ops::RangeInclusive;

use super::{Point2, cross, dot, power_of_two, sign, sub};
use crate::geometry::Point;

/// Exponents of the largest difference for which no product above can under- or overflow.
const RANGE: RangeInclusive<f64> = power_of_two(-250)..=power_of_two(250);

/// `None`: the points are on no such grid.
#[inline]
pub fn orient3d([a, b, c, d]: [&Point; 4]) -> Option<Ordering> {
    let edges = [sub(b, a), sub(c, a), sub(d, a)];
    let [[bx, by, bz], [cx, cy, cz], [dx, dy, dz]] = edges;
    let on_grid = Grid::below([bx, by, bz, cx, cy, cz, dx, dy, dz])?;
    (on_grid.has(a) & on_grid.has(b) & on_grid.has(c) & on_grid.has(d))
        .then(|| sign(dot(cross(edges[0], edges[1]), edges[2])))
}

/// `None`: the points are on no such grid.
#[inline]
pub fn orient2d([a, b, c]: [&Point2; 3]) -> Option<Ordering> {
    let [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
    let on_grid = Grid::below([bx, by, cx, cy])?;
    (on_grid.has(a) & on_grid.has(b) & on_grid.has(c)).then(|| sign(bx * cy - by * cx))
}

/// Multiples of a power of two `q`.
struct Grid {
    /// 1.5 * 2^52 q: what is added to it is rounded to a multiple of q.
    rounder: f64,
    /// 2^51 q.
    limit: f64,
}

impl Grid {
    /// The finest on which no difference is beyond 2^17 q.
    #[inline]
    fn below<const N: usize>(differences: [f64; N]) -> Option<Self> {
        let larger = |most: f64, d: f64| if d.abs() > most { d.abs() } else { most };
        let largest = differences.into_iter().fold(0.0, larger);
        if !RANGE.contains(&largest) {
            return None;
        }
        // The power of two below the largest: that is less than 2 * 2^16 q.
        let power = f64::from_bits(largest.to_bits() & (0x7ff << 52));
        let q = power * power_of_two(-16);
        Some(Self { rounder: 1.5 * power_of_two(52) * q, limit: power_of_two(51) * q })
    }

    #[inline]
    fn has<const N: usize>(&self, point: &[f64; N]) -> bool {
        // All coordinates, without a branch each.
        point.iter().fold(true, |all, &x| {
            all & (x.abs() < self.limit) & ((x + self.rounder) - self.rounder == x)
        })
    }
}
