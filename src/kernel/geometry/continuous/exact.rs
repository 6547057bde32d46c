//! The conditions on polynomials with integer coefficients, at times that are algebraic numbers.
//!
//! The times of contact are a closed set. So the first is t = 0, or one right before which some
//! condition fails: a root of the polynomial of that condition. That is the volume, unless it is zero
//! all along, and then any other.

use std::array;
use std::cmp::Ordering;

use num_bigint::BigInt;

use super::polynomial::Polynomial;
use super::{Differences, TimeOfImpact};
use crate::geometry::predicates::integer::decompose;

#[cold]
#[inline(never)]
pub fn first_contact<const N: usize>(
    differences: &Differences<'_, N>,
    tolerance: f64,
) -> Option<TimeOfImpact> {
    let motion = Motion::of(differences);
    let at_end = |sign: fn(&Polynomial) -> Ordering, time| {
        let in_contact = sign(&motion.volume).is_eq() && motion.in_contact(sign);
        in_contact.then_some(TimeOfImpact { earliest: time, latest: time })
    };
    at_end(Polynomial::sign_at_start, 0.0)
        .or_else(|| motion.first_within(tolerance))
        .or_else(|| at_end(Polynomial::sign_at_end, 1.0))
}

/// A polygon that moves, each axis times its own power of two: that changes no condition.
struct Motion<const N: usize> {
    corners: [[Polynomial; 3]; N],
    /// Cross products of each corner with the next.
    crosses: [[Polynomial; 3]; N],
    /// Of the first three corners.
    volume: Polynomial,
}

impl<const N: usize> Motion<N> {
    fn of(differences: &Differences<'_, N>) -> Self {
        let axes: [[Polynomial; N]; 3] = array::from_fn(|k| along_axis(differences, k));
        let corners: [[Polynomial; 3]; N] =
            array::from_fn(|i| array::from_fn(|k| axes[k][i].clone()));
        let crosses: [[Polynomial; 3]; N] = array::from_fn(|i| {
            let (p, q) = (&corners[i], &corners[(i + 1) % N]);
            array::from_fn(|k| {
                let [y, z] = [(k + 1) % 3, (k + 2) % 3];
                &(&p[y] * &q[z]) - &(&p[z] * &q[y])
            })
        });
        let terms: [Polynomial; 3] = array::from_fn(|k| &corners[0][k] * &crosses[1][k]);
        let volume = &(&terms[0] + &terms[1]) + &terms[2];
        Self { corners, crosses, volume }
    }

    /// At the time at which polynomials have these signs, and the volume none.
    fn in_contact(&self, mut sign: impl FnMut(&Polynomial) -> Ordering) -> bool {
        (0..3).all(|k| {
            let corners = self.corners.each_ref().map(|corner| sign(&corner[k]));
            let on_one_side =
                corners.iter().all(|s| s.is_gt()) || corners.iter().all(|s| s.is_lt());
            if on_one_side {
                return false;
            }
            let crosses = self.crosses.each_ref().map(|cross| sign(&cross[k]));
            !(crosses.iter().any(|s| s.is_gt()) && crosses.iter().any(|s| s.is_lt()))
        })
    }

    /// The first contact after the start and before the end.
    fn first_within(&self, tolerance: f64) -> Option<TimeOfImpact> {
        let mut first: Option<TimeOfImpact> = None;
        for mut root in self.turning_points().into_iter().flat_map(Polynomial::roots) {
            root.refine(tolerance);
            let later = first.is_some_and(|first| root.bounds()[0] >= first.latest);
            if later || !self.in_contact(|polynomial| root.sign_of(polynomial)) {
                continue;
            }
            let [from, to] = root.bounds();
            // The first of both is within what is the first of their bounds.
            first = Some(first.map_or(TimeOfImpact { earliest: from, latest: to }, |first| {
                TimeOfImpact { earliest: first.earliest.min(from), latest: first.latest.min(to) }
            }));
        }
        first
    }

    /// Contact begins only at roots of these, and the volume is zero there.
    fn turning_points(&self) -> Vec<&Polynomial> {
        if !self.volume.is_zero() {
            return vec![&self.volume];
        }
        let conditions = self.corners.as_flattened().iter().chain(self.crosses.as_flattened());
        conditions.filter(|polynomial| !polynomial.is_zero()).collect()
    }
}

/// The corners' coordinates on an axis, as integers by one power of two.
fn along_axis<const N: usize>(differences: &Differences<'_, N>, k: usize) -> [Polynomial; N] {
    let parts = differences.map(|end| end.map(|pair| pair.map(|point| decompose(point[k]))));
    let nonzero = parts.as_flattened().as_flattened().iter().filter(|part| part.0 != 0);
    let lowest = nonzero.map(|part| part.1).min().unwrap_or(0);
    let integer = |(m, e): (i64, u32)| BigInt::from(m) << e.saturating_sub(lowest);
    array::from_fn(|i| {
        let [start, end] = [0, 1].map(|end| {
            let [minuend, subtrahend] = parts[end][i].map(integer);
            minuend - subtrahend
        });
        Polynomial::linear(start, end)
    })
}
