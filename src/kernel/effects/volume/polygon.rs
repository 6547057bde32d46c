//! Convex polygons in the plane, counterclockwise.

use crate::geometry::predicates::Point2;

/// What is left of a line's left side, and where the line is crossed. `value` is not negative to the
/// left, and linear.
///
/// Each crossing is computed from the corner that stays to the one that goes, so that it is the same
/// for both polygons beside an edge (Sutherland & Hodgman 1974).
pub fn clip<const N: usize>(
    polygon: &[[f64; N]],
    value: impl Fn(&[f64; N]) -> f64,
    left: &mut Vec<[f64; N]>,
) {
    left.clear();
    let Some(mut last) = polygon.last() else { return };
    let mut last_value = value(last);
    for corner in polygon {
        let corner_value = value(corner);
        if (last_value >= 0.0) != (corner_value >= 0.0) {
            left.push(if last_value >= 0.0 {
                between(last, corner, last_value / (last_value - corner_value))
            } else {
                between(corner, last, corner_value / (corner_value - last_value))
            });
        }
        if corner_value >= 0.0 {
            left.push(*corner);
        }
        (last, last_value) = (corner, corner_value);
    }
}

fn between<const N: usize>(from: &[f64; N], to: &[f64; N], t: f64) -> [f64; N] {
    std::array::from_fn(|k| from[k] + t * (to[k] - from[k]))
}

/// Twice the area of a triangle, negative if it is clockwise.
pub fn twice_area(a: &Point2, b: &Point2, c: &Point2) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Leaves in `polygon` what it has in common with `other`; `room` is for its work.
pub fn intersect(polygon: &mut Vec<Point2>, other: &[Point2], room: &mut Vec<Point2>) {
    let Some(mut from) = other.last() else { return polygon.clear() };
    for to in other {
        clip(polygon, |point| twice_area(from, to, point), room);
        std::mem::swap(polygon, room);
        from = to;
    }
}

/// The integrals of 1 and of the lesser of two functions over a convex polygon, the functions given
/// by their values at its corners and linear between.
pub fn integrate_lesser(polygon: &[Point2], values: impl Fn(&Point2) -> [f64; 2]) -> [f64; 2] {
    let [first, rest @ ..] = polygon else { return [0.0; 2] };
    let first_values = values(first);
    let mut integrals = [0.0; 2];
    let Some((second, rest)) = rest.split_first() else { return integrals };
    let (mut last, mut last_values) = (second, values(second));
    for corner in rest {
        let corner_values = values(corner);
        let area = 0.5 * twice_area(first, last, corner).max(0.0);
        let at_corners = [first_values, last_values, corner_values];
        let mean = (at_corners[0][0] + at_corners[1][0] + at_corners[2][0]) / 3.0;
        integrals[0] += area;
        integrals[1] += area * (mean - mean_excess(at_corners.map(|[a, b]| a - b)));
        (last, last_values) = (corner, corner_values);
    }
    integrals
}

/// The mean over a triangle of the positive part of a linear function with these values at its
/// corners.
fn mean_excess(at_corners: [f64; 3]) -> f64 {
    let [a, b, c] = at_corners;
    // Over the corner triangle in which the sign is that of the corner alone.
    let alone =
        |v: f64, others: [f64; 2]| v.abs() / 3.0 * (v / (v - others[0])) * (v / (v - others[1]));
    let mean = (a + b + c) / 3.0;
    match at_corners.map(|v| v > 0.0) {
        [false, false, false] => 0.0,
        [true, true, true] => mean,
        [true, false, false] => alone(a, [b, c]),
        [false, true, false] => alone(b, [c, a]),
        [false, false, true] => alone(c, [a, b]),
        [false, true, true] => mean + alone(a, [b, c]),
        [true, false, true] => mean + alone(b, [c, a]),
        [true, true, false] => mean + alone(c, [a, b]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [Point2; 4] = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];

    #[test]
    fn a_square_turned_by_an_eighth_leaves_an_octagon() {
        let diamond = [[1.0, -0.5], [2.5, 1.0], [1.0, 2.5], [-0.5, 1.0]];
        let (mut polygon, mut room) = (SQUARE.to_vec(), Vec::new());
        intersect(&mut polygon, &diamond, &mut room);
        assert_eq!(polygon.len(), 8);
        let [area, integral] = integrate_lesser(&polygon, |_| [3.0, 7.0]);
        assert_eq!((area, integral), (3.5, 10.5));
    }

    #[test]
    fn the_lesser_of_two_slopes_is_integrated_across_their_crossing() {
        // The lesser of x and 2 - x over the square: a roof of height 1.
        let [area, integral] = integrate_lesser(&SQUARE, |&[x, _]| [x, 2.0 - x]);
        assert_eq!((area, integral), (4.0, 2.0));
        let [_, other_way] = integrate_lesser(&SQUARE, |&[x, _]| [2.0 - x, x]);
        assert_eq!(other_way, 2.0);
        // The lesser of x and 1.5 over the square.
        let [_, cut] = integrate_lesser(&SQUARE, |&[x, _]| [x, 1.5]);
        assert!((cut - (4.0 - 0.25)).abs() < 1e-15);
    }

    #[test]
    fn polygons_apart_leave_nothing() {
        let (mut polygon, mut room) = (SQUARE.map(|[x, y]| [x + 3.0, y]).to_vec(), Vec::new());
        intersect(&mut polygon, &SQUARE, &mut room);
        assert_eq!(integrate_lesser(&polygon, |_| [1.0; 2]), [0.0; 2]);
    }
}
