use std::cmp::Ordering;

use crate::geometry::Point;
use crate::geometry::predicates::{Point2, orient2d};

/// A polygon seen along one axis, from the side on which it runs counterclockwise.
pub struct Outline(Vec<Point2>);

impl Outline {
    /// Along the axis closest to the normal, where the outline is largest. The normal is rounded:
    /// polygons thinner than some 1e-15 of their length may be seen from the wrong side.
    pub fn of(corners: Vec<Point>) -> Self {
        let normal = newell_normal(&corners);
        let dominant = (0..3).max_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs()));
        let k = dominant.expect("three axes");
        let [i, j] = [(k + 1) % 3, (k + 2) % 3];
        let [i, j] = if normal[k] < 0.0 { [j, i] } else { [i, j] };
        Self(corners.into_iter().map(|p| [p[i], p[j]]).collect())
    }

    pub fn points(&self) -> &[Point2] {
        &self.0
    }

    /// No turn to the right, and once around: one way up and one way down in the order of
    /// coordinates. A repeated corner would hide a turn.
    pub fn is_convex(&self) -> bool {
        let mut points: Vec<&Point2> = self.0.iter().collect();
        points.dedup();
        while points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        let n = points.len();
        let at = |i: usize| points[i % n];
        let turns_right = |i| orient2d(at(i), at(i + 1), at(i + 2)) == Ordering::Less;
        let is_up = |i| at(i) < at(i + 1);
        !(0..n).any(turns_right) && (0..n).filter(|&i| is_up(i) != is_up(i + 1)).count() <= 2
    }
}

/// Twice the polygon's area along its normal, in units of its largest extent: M. E. Newell's
/// method, relative to the first corner.
fn newell_normal(corners: &[Point]) -> Point {
    let first = corners[0];
    let relative = |p: &Point| -> Point {
        // Coordinates at both ends of the range are further apart than any number.
        [0, 1, 2].map(|k| (p[k] - first[k]).clamp(-f64::MAX, f64::MAX))
    };
    let largest = corners.iter().flat_map(relative).fold(0.0, |m: f64, c| m.max(c.abs()));
    if largest == 0.0 {
        return [0.0; 3];
    }
    let mut normal = [0.0; 3];
    for edge in corners.windows(2) {
        let [u, v] = [&edge[0], &edge[1]].map(|p| relative(p).map(|c| c / largest));
        for (k, sum) in normal.iter_mut().enumerate() {
            let [i, j] = [(k + 1) % 3, (k + 2) % 3];
            *sum += u[i] * v[j] - u[j] * v[i];
        }
    }
    normal
}
