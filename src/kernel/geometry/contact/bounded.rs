//! Crossings in f64 with running bounds on their error (Higham, "Accuracy and Stability of
//! Numerical Algorithms", 2002, chapter 3).

use super::crossing::{Crossing, Divider};
use crate::geometry::Point;
use crate::geometry::predicates::{power_of_two, sub};

/// Half a unit in the last place of 1: the most a rounding adds to 1.
const U: f64 = f64::EPSILON / 2.0;

/// More than what underflow adds to a volume or area of differences below [`WIDEST`]: six products
/// with an error of 2^-1075 each, times a difference. And more than what it adds to a coordinate.
const UNDERFLOW: f64 = power_of_two(-960);
/// Of the triangles' extent. Nothing overflows below, and above the least one [`UNDERFLOW`] is
/// nothing beside the volumes and areas of well-conditioned crossings.
const LEAST: f64 = power_of_two(-200);
const WIDEST: f64 = power_of_two(100);

/// Relative to the extent, the error that f64 may have beyond that of rounding the coordinates.
const TOLERANCE: f64 = power_of_two(-40);

/// What of an error is acceptable, for the crossings of two triangles.
#[derive(Clone, Copy)]
pub struct Limit(f64);

/// A number and at least how far it is from the true one.
struct Bounded {
    value: f64,
    error: f64,
}

impl Limit {
    /// `extent`: the greatest of the rounded differences of coordinates; `None` where the bounds do
    /// not hold.
    pub fn for_extent(extent: f64) -> Option<Self> {
        (LEAST..=WIDEST).contains(&extent).then_some(Self(extent * TOLERANCE))
    }
}

/// The crossing, and at most how far each coordinate is off; `None` if that is beyond the limit
/// and rounding.
///
/// # Why the bound holds
/// Let e bound the errors of d(p) and d(q), D be the rounded d(p) - d(q) and t the rounded
/// d(p) / D. The true parameter is the same for all multiples of d, and where d(p) is off by x,
/// d(q) by y and D by z more, it is off by ((1 - t) x + t y - t z) / D: at most e / D and a
/// rounding, u t. With those of the quotient, t is off by e / D + 3 u t. The direction q - p has
/// one rounding and its product with t another, together 5 u t |q - p| and e / D |q - p|; the sum
/// adds u times itself. The sixth u is for terms of second order, and with the roundings of the
/// bound, far below a 2^-20th of it, which [`distance_bound`] adds.
#[inline]
pub fn crossing(at: &Crossing<'_>, limit: Limit) -> Option<(Point, [f64; 3])> {
    let [p, q] = at.ends;
    let [d_p, d_q] = at.divider.bounded_distances(at.ends);
    // From the nearer end, which keeps t small.
    let from_p = d_p.value.abs() <= d_q.value.abs();
    let (from, to, d, other) =
        if from_p { (p, q, d_p.value, d_q.value) } else { (q, p, d_q.value, d_p.value) };
    let reciprocal = 1.0 / (d - other);
    let t = d * reciprocal;
    let t_error = d_p.error.max(d_q.error) * reciprocal.abs();
    let along = sub(to, from);
    let point = [from[0] + t * along[0], from[1] + t * along[1], from[2] + t * along[2]];
    let ill = t_error * largest(along);
    let acceptable = ill <= limit.0.max(U * largest(*from));
    // Not so either if the difference is zero.
    if !acceptable {
        return None;
    }
    let along_error = t_error + 6.0 * U * t.abs();
    Some((
        point,
        [0, 1, 2].map(|k| along[k].abs() * along_error + (U * point[k].abs() + UNDERFLOW)),
    ))
}

/// A bound of the Euclidean distance from the bounds of its coordinates.
pub fn distance_bound(coordinates: [f64; 3]) -> f64 {
    const SLACK: f64 = 1.0 + power_of_two(-20);
    let length = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z).sqrt() * SLACK;
    let most = largest(coordinates);
    if most == 0.0 {
        0.0
    } else if (power_of_two(-400)..power_of_two(400)).contains(&most) {
        length(coordinates)
    } else {
        // The next number, as the product may be subnormal, and round by much.
        (most * length(coordinates.map(|c| c / most))).next_up()
    }
}

impl Divider<'_> {
    /// The volumes or areas with two points. Each of their products of coordinates takes part in at
    /// most eight (four) roundings: of its differences, itself and of sums.
    #[inline]
    fn bounded_distances(&self, points: [&Point; 2]) -> [Bounded; 2] {
        match *self {
            Divider::Plane([a, b, c]) => {
                let [u, v] = [sub(b, a), sub(c, a)];
                let [x, y, z] = [[1, 2], [2, 0], [0, 1]].map(|[i, j]| (u[i] * v[j], u[j] * v[i]));
                let normal = [x.0 - x.1, y.0 - y.1, z.0 - z.1];
                let sizes = [x, y, z].map(|(plus, minus)| plus.abs() + minus.abs());
                points.map(|p| {
                    let w = sub(p, a);
                    let value = normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2];
                    let size =
                        sizes[0] * w[0].abs() + sizes[1] * w[1].abs() + sizes[2] * w[2].abs();
                    Bounded { value, error: 9.0 * U * size + UNDERFLOW }
                })
            }
            Divider::Line([a, b], [x, y]) => {
                let u = [b[x] - a[x], b[y] - a[y]];
                points.map(|p| {
                    let (plus, minus) = (u[0] * (p[y] - a[y]), u[1] * (p[x] - a[x]));
                    let size = plus.abs() + minus.abs();
                    Bounded { value: plus - minus, error: 5.0 * U * size + UNDERFLOW }
                })
            }
        }
    }
}

#[inline]
fn largest(values: [f64; 3]) -> f64 {
    values[0].abs().max(values[1].abs()).max(values[2].abs())
}
