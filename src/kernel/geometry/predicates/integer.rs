//! The last stage: determinants in integers without limit, for coordinates of any exponents.

use std::cmp::Ordering;

use num_bigint::BigInt;

use super::Point2;
use crate::geometry::Point;

pub fn orient2d([a, b, c]: [&Point2; 3]) -> Ordering {
    let [[bx, cx], [by, cy]] = [0, 1].map(|i| differences([b[i], c[i]], a[i]));
    (bx * cy).cmp(&(by * cx))
}

pub fn orient3d([a, b, c, d]: [&Point; 4]) -> Ordering {
    let [[bx, cx, dx], [by, cy, dy], [bz, cz, dz]] =
        [0, 1, 2].map(|i| differences([b[i], c[i], d[i]], a[i]));
    let determinant =
        dx * (&by * &cz - &bz * &cy) + dy * (&bz * &cx - &bx * &cz) + dz * (bx * cy - by * cx);
    determinant.cmp(&BigInt::ZERO)
}

/// The coordinates minus `origin`, times a power of two that makes all of them integers: each
/// axis may have its own, as that does not change the sign of a determinant.
fn differences<const N: usize>(coordinates: [f64; N], origin: f64) -> [BigInt; N] {
    let parts = coordinates.map(decompose);
    let origin = decompose(origin);
    let nonzero = parts.iter().chain([&origin]).filter(|part| part.0 != 0);
    let lowest = nonzero.map(|part| part.1).min().unwrap_or(0);
    let integer = |(m, e): (i64, u32)| BigInt::from(m) << e.saturating_sub(lowest);
    parts.map(|part| integer(part) - integer(origin))
}

/// An odd integer m, or zero, and e such that `x` = m 2^(e - 1074).
pub fn decompose(x: f64) -> (i64, u32) {
    const HIDDEN_BIT: u64 = 1 << 52;
    let bits = x.to_bits();
    let (fraction, biased) = (bits & (HIDDEN_BIT - 1), (bits >> 52 & 0x7ff) as u32);
    let (magnitude, exponent) =
        if biased == 0 { (fraction, 0) } else { (fraction | HIDDEN_BIT, biased - 1) };
    if magnitude == 0 {
        return (0, 0);
    }
    let zeros = magnitude.trailing_zeros();
    let magnitude = (magnitude >> zeros) as i64;
    (if x < 0.0 { -magnitude } else { magnitude }, exponent + zeros)
}
