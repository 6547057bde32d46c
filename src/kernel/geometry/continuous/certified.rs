//! What f64 can prove: the cubic's roots are bracketed, and the other conditions are looked at over
//! the whole of a bracket.
//!
//! All is computed for a piece of the motion, from the corners at its two ends, as the coefficients
//! of polynomials in Bernstein form: where all coefficients have one sign, so has the polynomial
//! on the piece, and the first and last are its values at the ends.
//!
//! Let u = 2^-53 and M the largest coordinate of a corner on each axis, at the start or the end.
//! - A corner at a time: its two differences are off by u M, 1 - t by u/2, two products and their
//!   sum by u M each: together less than 5 u M.
//! - A cross product, with A the product of M on its two axes: 20 u A from the corners, 4 u A from
//!   the computation, 2 u A from the mean: less than 32 u A.
//! - A volume, with V the product of all three M: 90 u V from the corners and at most 44 u V from the
//!   computation of a coefficient: less than 160 u V.
//!
//! For M within [2^-300, 2^300] nothing overflows, and what underflow adds is far below what these
//! bounds leave.

use std::array;

use super::TimeOfImpact;
use crate::geometry::Point;
use crate::geometry::predicates::{cross, dot, power_of_two};

pub enum Answer {
    Apart,
    Contact(TimeOfImpact),
    /// Rounding forbids an answer.
    Unsure,
}

const U: f64 = power_of_two(-53);

/// Halvings of the motion after which integers are faster.
const DEEPEST: u32 = 6;

/// `corners`: a convex polygon's at the start and at the end, each coordinate rounded once.
#[inline]
pub fn first_contact<const N: usize>(corners: &[[Point; N]; 2], tolerance: f64) -> Answer {
    if separated(corners, [0.0; 3]) {
        return Answer::Apart;
    }
    match Bounds::of(corners) {
        Some(bounds) => Motion { corners, bounds, tolerance }.search(&Piece::whole(corners), 0),
        None => Answer::Unsure,
    }
}

/// On some axis all corners are beyond the bound at both ends, and so in between.
#[inline]
fn separated<const N: usize>(corners: &[[Point; N]; 2], bound: Point) -> bool {
    let all = |k: usize, beyond: fn(f64, f64) -> bool| {
        corners.as_flattened().iter().fold(true, |all, corner| all & beyond(corner[k], bound[k]))
    };
    (0..3).any(|k| all(k, |x, bound| x > bound) || all(k, |x, bound| x < -bound))
}

/// How far what is computed may be from what it stands for.
struct Bounds {
    coordinates: Point,
    crosses: Point,
    volume: f64,
}

impl Bounds {
    #[inline]
    fn of<const N: usize>(corners: &[[Point; N]; 2]) -> Option<Self> {
        let larger = |m: Point, c: &Point| array::from_fn(|k| m[k].max(c[k].abs()));
        let [x, y, z] = corners.as_flattened().iter().fold([0.0; 3], larger);
        let range = power_of_two(-300)..=power_of_two(300);
        [x, y, z].iter().all(|m| range.contains(m)).then(|| Self {
            coordinates: [x, y, z].map(|m| 8.0 * U * m),
            crosses: [y * z, z * x, x * y].map(|area| 32.0 * U * area),
            volume: 160.0 * U * (x * y * z),
        })
    }
}

/// Some of the motion, and the corners at its ends.
struct Piece<const N: usize> {
    from: f64,
    to: f64,
    corners: [[Point; N]; 2],
}

/// Where the origin is while it is in the polygon's plane.
#[derive(PartialEq)]
enum Side {
    Inside,
    Outside,
    Unsure,
}

impl<const N: usize> Piece<N> {
    #[inline]
    fn whole(corners: &[[Point; N]; 2]) -> Self {
        Self { from: 0.0, to: 1.0, corners: *corners }
    }

    /// The Bernstein coefficients of the volume of the first three corners.
    #[inline]
    fn volume(&self) -> [f64; 4] {
        let [[x0, x1], [y0, y1], [z0, z1]] = [0, 1, 2].map(|i| self.corners.map(|at| at[i]));
        let [start, mixed, end] = crosses([y0, y1], [z0, z1]);
        [
            dot(x0, start),
            (dot(x1, start) + dot(x0, mixed)) / 3.0,
            (dot(x0, end) + dot(x1, mixed)) / 3.0,
            dot(x1, end),
        ]
    }

    /// Requires that polygon and origin are in a plane at the times that count.
    #[inline]
    fn side(&self, bound: Point) -> Side {
        let (mut above, mut below) = ([0; 3], [0; 3]);
        for i in 0..N {
            let [p, q] = [i, (i + 1) % N].map(|i| self.corners.map(|at| at[i]));
            let [start, mixed, end] = crosses(p, q);
            for k in 0..3 {
                let coefficients = [start[k], 0.5 * mixed[k], end[k]];
                above[k] += usize::from(coefficients.iter().all(|&c| c > bound[k]));
                below[k] += usize::from(coefficients.iter().all(|&c| c < -bound[k]));
            }
        }
        if (0..3).any(|k| above[k] > 0 && below[k] > 0) {
            Side::Outside
        } else if above.contains(&N) || below.contains(&N) {
            Side::Inside
        } else {
            Side::Unsure
        }
    }
}

/// The cross product of two points that move, at the start, at the end, and between those twice the
/// middle coefficient.
#[inline]
fn crosses([p0, p1]: [Point; 2], [q0, q1]: [Point; 2]) -> [Point; 3] {
    let (left, right) = (cross(p0, q1), cross(p1, q0));
    [cross(p0, q0), array::from_fn(|k| left[k] + right[k]), cross(p1, q1)]
}

struct Motion<'a, const N: usize> {
    corners: &'a [[Point; N]; 2],
    bounds: Bounds,
    tolerance: f64,
}

impl<const N: usize> Motion<'_, N> {
    /// The first contact in a piece that is what is left after `depth` halvings.
    fn search(&self, piece: &Piece<N>, depth: u32) -> Answer {
        let (volume, bound) = (piece.volume(), self.bounds.volume);
        if volume.iter().all(|&v| v > bound) || volume.iter().all(|&v| v < -bound) {
            return Answer::Apart;
        }
        if let Some(rising) = passes_zero_once(volume, bound) {
            return self.at_root(piece, volume, rising);
        }
        if separated(&piece.corners, self.bounds.coordinates)
            || piece.side(self.bounds.crosses) == Side::Outside
        {
            return Answer::Apart;
        }
        if depth == DEEPEST {
            return Answer::Unsure;
        }
        let middle = 0.5 * (piece.from + piece.to);
        match self.search(&self.piece(piece.from, middle), depth + 1) {
            Answer::Apart => self.search(&self.piece(middle, piece.to), depth + 1),
            answer => answer,
        }
    }

    /// The piece's volume is zero at one time only. If it is `rising`, from below.
    fn at_root(&self, piece: &Piece<N>, volume: [f64; 4], rising: bool) -> Answer {
        let (root, slope) = approximate_root(volume);
        let length = piece.to - piece.from;
        let (middle, margin) = (
            piece.from + root * length,
            4.0 * self.bounds.volume / slope.abs() * length + power_of_two(-51),
        );
        let bracket =
            self.piece((middle - margin).max(piece.from), (middle + margin).min(piece.to));
        let [first, .., last] = bracket.volume();
        let (low, high) = if rising { (first, last) } else { (last, first) };
        let contains_root = low < -self.bounds.volume && high > self.bounds.volume;
        let (earliest, latest) = (bracket.from, bracket.to);
        match bracket.side(self.bounds.crosses) {
            Side::Outside if contains_root => Answer::Apart,
            Side::Inside if contains_root && latest - earliest <= self.tolerance => {
                Answer::Contact(TimeOfImpact { earliest, latest })
            }
            _ => Answer::Unsure,
        }
    }

    #[inline]
    fn piece(&self, from: f64, to: f64) -> Piece<N> {
        let [start, end] = self.corners;
        let corners = [from, to].map(|t| -> [Point; N] {
            array::from_fn(|i| array::from_fn(|k| (1.0 - t) * start[i][k] + t * end[i][k]))
        });
        Piece { from, to, corners }
    }
}

/// Whether the polynomial with Bernstein coefficients that are at most `bound` from these rises
/// (`true`) or falls through zero at one time only; `None` if that is not certain.
///
/// Its ends have different signs, and so the coefficients change sign once or three times.
#[inline]
fn passes_zero_once([a, b, c, d]: [f64; 4], bound: f64) -> Option<bool> {
    let rises = |[a, b, c, d]: [f64; 4]| a < -bound && d > bound && (b < -bound || c > bound);
    if rises([a, b, c, d]) { Some(true) } else { rises([-a, -b, -c, -d]).then_some(false) }
}

/// A root in [0, 1] of a polynomial with these Bernstein coefficients, whose ends differ in sign, and
/// the slope there; by Newton's method kept between what is below and what is above zero.
fn approximate_root(coefficients: [f64; 4]) -> (f64, f64) {
    const MOST_STEPS: u32 = 40;
    let [first, .., last] = coefficients;
    let (mut low, mut high) = (0.0, 1.0);
    let mut t = first / (first - last);
    for _ in 0..MOST_STEPS {
        let (value, slope) = value_and_slope(coefficients, t);
        if (value < 0.0) == (first < 0.0) {
            low = t
        } else {
            high = t
        }
        let newton = t - value / slope;
        let next = if low <= newton && newton <= high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= U {
            return (t, slope);
        }
        t = next;
    }
    (t, value_and_slope(coefficients, t).1)
}

#[inline]
fn value_and_slope([a, b, c, d]: [f64; 4], t: f64) -> (f64, f64) {
    let mean = |a: f64, b: f64| (1.0 - t) * a + t * b;
    let [ab, bc, cd] = [mean(a, b), mean(b, c), mean(c, d)];
    let [abc, bcd] = [mean(ab, bc), mean(bc, cd)];
    (mean(abc, bcd), 3.0 * (bcd - abc))
}
