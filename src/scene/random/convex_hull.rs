//! Corners of a mesh's convex hull: the few points that decide how far it reaches in a direction.

use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;

use crate::geometry::Point;
use crate::geometry::boxes::{bounds, dot};

/// Points whose convex hull is that of `points`, up to rounding. Where there is no such hull (points
/// in a plane, or a hull that rounding has spoiled) the corners of the bounding box, which contain
/// the points as well, if more loosely.
pub(super) fn hull_corners(points: &[Point]) -> Vec<Point> {
    let vectors: Vec<Vector> = points.iter().map(|&point| Vector::from(point)).collect();
    let hull = try_convex_hull(&vectors).ok();
    let corners = hull.map(|(corners, _)| corners.iter().map(|c| c.to_array()).collect());
    corners
        .filter(|corners: &Vec<Point>| contains(corners, points))
        .unwrap_or_else(|| box_corners(points))
}

/// Whether the corners reach as far as the points, up to a millionth of it, in 26 directions:
/// quickhull returns too few corners for flat input, and says nothing.
fn contains(corners: &[Point], points: &[Point]) -> bool {
    let steps = || (-1..=1).map(f64::from);
    let directions =
        steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
    let reaches = |direction: Point| {
        let (least, most) = (-reach(points, direction.map(|c| -c)), reach(points, direction));
        reach(corners, direction) >= most - (most - least) * 1e-6
    };
    directions.into_iter().all(reaches)
}

/// How far the points reach from the origin in a direction.
pub(super) fn reach(points: &[Point], direction: Point) -> f64 {
    points.iter().map(|point| dot(point, &direction)).fold(f64::NEG_INFINITY, f64::max)
}

fn box_corners(points: &[Point]) -> Vec<Point> {
    let (low, high) = bounds(points);
    let corner = |i: usize| [0, 1, 2].map(|axis| [low, high][i >> axis & 1][axis]);
    (0..8).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_reaches_as_far_as_its_points_with_fewer_of_them() {
        let mut draw = super::super::draw::Draw::of_scenario(3, 0);
        let points: Vec<Point> =
            (0..2000).map(|_| [draw.unit(), 2.0 * draw.unit(), draw.unit()]).collect();
        let corners = hull_corners(&points);
        assert!(corners.len() < points.len() / 4);
        for _ in 0..100 {
            let direction = draw.direction();
            assert!((reach(&points, direction) - reach(&corners, direction)).abs() < 1e-6);
        }
    }

    #[test]
    fn points_without_a_hull_are_contained_all_the_same() {
        let flat: Vec<Point> = (0..9).map(|i| [f64::from(i % 3), f64::from(i / 3), 5.0]).collect();
        let tilted: Vec<Point> = flat.iter().map(|p| [p[0], p[1], 0.3 * p[0] - p[1]]).collect();
        let mut draw = super::super::draw::Draw::of_scenario(4, 0);
        for points in [&flat[..], &tilted, &flat[..1], &flat[..2], &flat[..3]] {
            let corners = hull_corners(points);
            for _ in 0..100 {
                let direction = draw.direction();
                assert!(reach(&corners, direction) >= reach(points, direction) - 1e-5);
            }
        }
    }
}
