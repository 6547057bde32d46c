//! Slow answers that cannot be wrong, to hold the fast ones against.
#![allow(dead_code, reason = "each test program that mounts this uses a part of it")]

use bumper::geometry::triangle::{StaticFilter, triangles_intersect};
use bumper::geometry::{Point, Pose, Triangle};

mod simplex;

/// Exact test without any geometry: the hulls meet iff some convex combination of the vertices of
/// `a` equals one of the vertices of `b`, which is linear programming in integers.
pub fn hulls_meet(a: &Triangle, b: &Triangle) -> bool {
    simplex::common_convex_combination(a, b)
}

/// All (i, j) with `fixed[i]` meeting the placed `moving[j]`, sorted, by [`hulls_meet`]: slow.
pub fn pairs_without_rounding(
    fixed: &[Triangle],
    moving: &[Triangle],
    pose: &Pose,
) -> Vec<[u32; 2]> {
    pairs_that_meet(fixed, &placed(moving, pose), hulls_meet)
}

/// All (i, j) with `fixed[i]` meeting the placed `moving[j]`, sorted: the answer that a tree has
/// to give, by trying every pair whose boxes overlap.
pub fn brute_force_pairs(fixed: &[Triangle], moving: &[Triangle], pose: &Pose) -> Vec<[u32; 2]> {
    let placed = placed(moving, pose);
    let filter = tight_filter(fixed.iter().chain(&placed).flatten());
    pairs_that_meet(fixed, &placed, |a, b| triangles_intersect(a, b, &filter))
}

fn placed(moving: &[Triangle], pose: &Pose) -> Vec<Triangle> {
    moving.iter().map(|t| t.map(|p| pose.apply(p))).collect()
}

fn pairs_that_meet(
    fixed: &[Triangle],
    placed: &[Triangle],
    meet: impl Fn(&Triangle, &Triangle) -> bool,
) -> Vec<[u32; 2]> {
    let wholes = [fixed, placed].map(|triangles| bounds(triangles.iter().flatten()));
    let (fixed, placed) = (within(fixed, &wholes[1]), within(placed, &wholes[0]));
    let mut pairs = Vec::new();
    for (i, a, a_bounds) in &fixed {
        for (j, b, b_bounds) in &placed {
            if overlap(a_bounds, b_bounds) && meet(a, b) {
                pairs.push([*i, *j]);
            }
        }
    }
    pairs
}

/// Those whose bounds overlap these, with their numbers and bounds.
fn within<'a>(
    triangles: &'a [Triangle],
    place: &[Point; 2],
) -> Vec<(u32, &'a Triangle, [Point; 2])> {
    let bounded = (0..).zip(triangles).map(|(i, triangle)| (i, triangle, bounds(triangle)));
    bounded.filter(|(_, _, bounds)| overlap(bounds, place)).collect()
}

fn overlap([low, high]: &[Point; 2], [b_low, b_high]: &[Point; 2]) -> bool {
    (0..3).all(|k| low[k] <= b_high[k] && b_low[k] <= high[k])
}

/// The filter for tests among these points.
pub fn tight_filter<'a>(points: impl IntoIterator<Item = &'a Point>) -> StaticFilter {
    let [low, high] = bounds(points);
    StaticFilter::for_extent([0, 1, 2].map(|k| high[k] - low[k]))
}

fn bounds<'a>(points: impl IntoIterator<Item = &'a Point>) -> [Point; 2] {
    points.into_iter().fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |[low, high], p| {
        [[0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k]))]
    })
}
