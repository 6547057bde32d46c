//! Crossings as fractions of integers without limit, rounded once.

use num_bigint::{BigInt, BigUint, Sign};

use super::crossing::{Crossing, Divider};
use crate::geometry::Point;
use crate::geometry::predicates::integer::decompose;
use crate::geometry::predicates::power_of_two;

/// The crossing with each coordinate the nearest f64, and at most how far it is off: half a unit
/// in its last place, or nothing.
#[cold]
#[inline(never)]
pub fn crossing(at: &Crossing<'_>) -> (Point, [f64; 3]) {
    let [d_p, d_q] = at.divider.distances(at.ends);
    let difference = &d_p - d_q;
    let [p, q] = at.ends;
    let coordinates = [0, 1, 2].map(|k| {
        let ([p, q], exponent) = aligned([p[k], q[k]]);
        let numerator = &p * &difference + (q - p) * &d_p;
        nearest(numerator, &difference, exponent)
    });
    (coordinates.map(|c| c.0), coordinates.map(|c| c.1))
}

impl Divider<'_> {
    /// The volumes or areas with two points, both times the same power of two.
    fn distances(&self, points: [&Point; 2]) -> [BigInt; 2] {
        let [p, q] = points;
        match *self {
            Divider::Plane([a, b, c]) => {
                let [x, y, z] = [0, 1, 2].map(|k| {
                    let ([a, b, c, p, q], _) = aligned([a[k], b[k], c[k], p[k], q[k]]);
                    [b - &a, c - &a, p - &a, q - &a]
                });
                let minor = |u: &[BigInt; 4], v: &[BigInt; 4]| &u[0] * &v[1] - &v[0] * &u[1];
                let normal = [minor(&y, &z), minor(&z, &x), minor(&x, &y)];
                [2, 3].map(|i| &normal[0] * &x[i] + &normal[1] * &y[i] + &normal[2] * &z[i])
            }
            Divider::Line([a, b], axes) => {
                let [x, y] = axes.map(|k| {
                    let ([a, b, p, q], _) = aligned([a[k], b[k], p[k], q[k]]);
                    [b - &a, p - &a, q - &a]
                });
                [1, 2].map(|i| &x[0] * &y[i] - &y[0] * &x[i])
            }
        }
    }
}

/// Integers n and an exponent e such that each number is its n times 2^e.
fn aligned<const N: usize>(numbers: [f64; N]) -> ([BigInt; N], i32) {
    let parts = numbers.map(decompose);
    let lowest = parts.iter().filter(|part| part.0 != 0).map(|part| part.1).min().unwrap_or(0);
    let integer = |(m, e): (i64, u32)| BigInt::from(m) << e.saturating_sub(lowest);
    (parts.map(integer), lowest as i32 - 1074)
}

/// The f64 nearest to numerator / denominator 2^exponent, and at most how far it is off. Requires
/// that the quotient is at most the greatest f64 and the denominator not zero.
fn nearest(numerator: BigInt, denominator: &BigInt, exponent: i32) -> (f64, f64) {
    const BITS: i32 = f64::MANTISSA_DIGITS as i32;
    const LOWEST: i32 = f64::MIN_EXP - BITS;
    if numerator.sign() == Sign::NoSign {
        return (0.0, 0.0);
    }
    let is_negative = numerator.sign() != denominator.sign();
    let (n, d) = (numerator.magnitude(), denominator.magnitude());
    // The quotient has this many bits before its point, or one more. Two or three beyond those of
    // the result are kept, the lowest of which also says whether anything follows.
    let bits = n.bits() as i32 - d.bits() as i32 + exponent;
    let last = (bits - BITS).max(LOWEST) - 2;
    let quotient = floor_with_sticky_bit(n, d, exponent - last);
    let length = (u64::BITS - quotient.leading_zeros()) as i32;
    let dropped = (length - BITS).max(LOWEST - last);
    let half = 1_u64 << (dropped - 1);
    let rest = quotient & (2 * half - 1);
    let kept = quotient >> dropped;
    let is_up = rest > half || rest == half && kept & 1 == 1;
    let magnitude = scaled((kept + u64::from(is_up)) as f64, last + dropped);
    let error = if rest == 0 { 0.0 } else { scaled(1.0, (last + dropped - 1).max(LOWEST)) };
    (if is_negative { -magnitude } else { magnitude }, error)
}

/// The integer part of n / d 2^shift, its lowest bit set if it is not all. Fits in 64 bits.
fn floor_with_sticky_bit(n: &BigUint, d: &BigUint, shift: i32) -> u64 {
    let by = shift.unsigned_abs();
    let (n, d) = if shift >= 0 { (n << by, d.clone()) } else { (n.clone(), d << by) };
    let quotient = &n / &d;
    let is_inexact = &quotient * &d != n;
    let digits = quotient.iter_u64_digits().next().unwrap_or(0);
    digits | u64::from(is_inexact)
}

/// x 2^exponent, if that is an f64.
fn scaled(x: f64, exponent: i32) -> f64 {
    let half = exponent / 2;
    x * power_of_two(half) * power_of_two(exponent - half)
}
