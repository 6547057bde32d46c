//! The common set in floating point at face value, as other engines compute it: no bounds, signs as
//! they come out. For measuring what exactness costs, and what it is worth.

use std::ops::Div;

use super::Corners;
use crate::geometry::predicates::{Scalar, cross, dot, sub};
use crate::geometry::{Point, Triangle};

/// What a plain engine in 64 bits finds, right or wrong.
pub fn plain_f64(a: &Triangle, b: &Triangle) -> Option<Corners> {
    intersection(a, b)
}

/// What a plain engine in 32 bits finds, right or wrong; the vertices are rounded first.
pub fn plain_f32(a: &Triangle, b: &Triangle) -> Option<Corners> {
    let [a, b] = [a, b].map(|t| t.map(|p| p.map(|c| c as f32)));
    intersection(&a, &b)
}

/// What it takes beyond signs.
trait Real: Scalar + Into<f64> + Div<Output = Self> {
    fn abs(self) -> Self;
}

impl Real for f32 {
    fn abs(self) -> Self {
        self.abs()
    }
}

impl Real for f64 {
    fn abs(self) -> Self {
        self.abs()
    }
}

type Vector<S> = [S; 3];

/// Möller, "A fast triangle-triangle intersection test" (1997), with the segment.
fn intersection<S: Real>(a: &[Vector<S>; 3], b: &[Vector<S>; 3]) -> Option<Corners> {
    let (normal_a, normal_b) = (normal(a), normal(b));
    let distances_a = a.map(|p| dot(normal_b, sub(&p, &b[0])));
    let distances_b = b.map(|p| dot(normal_a, sub(&p, &a[0])));
    let zero = S::default();
    for distances in [distances_a, distances_b] {
        if distances.iter().all(|&d| d > zero) || distances.iter().all(|&d| d < zero) {
            return None;
        }
    }
    if distances_a == [zero; 3] || distances_b == [zero; 3] {
        return clipped(a, b, normal_a);
    }
    let axis = largest_axis(cross(normal_a, normal_b));
    let [low_a, high_a] = interval(a, distances_a, axis)?;
    let [low_b, high_b] = interval(b, distances_b, axis)?;
    let low = if low_a[axis] < low_b[axis] { low_b } else { low_a };
    let high = if high_a[axis] < high_b[axis] { high_a } else { high_b };
    if low[axis] > high[axis] {
        return None;
    }
    let mut corners = Corners::NONE;
    corners.push(low.map(Into::into));
    if low[axis] < high[axis] {
        corners.push(high.map(Into::into));
    }
    Some(corners)
}

/// Where a triangle meets the other's plane, the end with the smaller coordinate first.
fn interval<S: Real>(
    triangle: &[Vector<S>; 3],
    distances: [S; 3],
    axis: usize,
) -> Option<[Vector<S>; 2]> {
    let zero = S::default();
    let mut ends: Option<[Vector<S>; 2]> = None;
    let mut add = |p: Vector<S>| {
        let [low, high] = ends.unwrap_or([p, p]);
        let low = if p[axis] < low[axis] { p } else { low };
        let high = if p[axis] > high[axis] { p } else { high };
        ends = Some([low, high]);
    };
    for i in 0..3 {
        let (d, e) = (distances[i], distances[(i + 1) % 3]);
        if d == zero {
            add(triangle[i]);
        } else if d < zero && e > zero || d > zero && e < zero {
            add(between(triangle[i], triangle[(i + 1) % 3], d, e));
        }
    }
    ends
}

/// Sutherland & Hodgman's clipping (1974) of `b` by the edges of `a` in their plane.
fn clipped<S: Real>(a: &[Vector<S>; 3], b: &[Vector<S>; 3], normal: Vector<S>) -> Option<Corners> {
    let mut polygon = Ring::of(b);
    for i in 0..3 {
        let (from, along) = (a[i], sub(&a[(i + 1) % 3], &a[i]));
        let inwards = cross(normal, along);
        let mut rest = Ring::of(&[]);
        for k in 0..polygon.count {
            let (p, q) = (polygon.points[k], polygon.points[(k + 1) % polygon.count]);
            let [d, e] = [p, q].map(|x| dot(inwards, sub(&x, &from)));
            if d >= S::default() {
                rest.push(p);
            }
            if d < S::default() && e > S::default() || d > S::default() && e < S::default() {
                rest.push(between(p, q, d, e));
            }
        }
        polygon = rest;
    }
    let mut corners = Corners::NONE;
    for p in &polygon.points[..polygon.count] {
        let p: Point = p.map(Into::into);
        if !corners.points().contains(&p) && corners.points().len() < Corners::MOST {
            corners.push(p);
        }
    }
    (!corners.points().is_empty()).then_some(corners)
}

/// Corners in order; of more than there is room for, which only rounding makes, the last are lost.
struct Ring<S> {
    points: [Vector<S>; 9],
    count: usize,
}

impl<S: Real> Ring<S> {
    fn of(points: &[Vector<S>]) -> Self {
        let mut ring = Self { points: [[S::default(); 3]; 9], count: 0 };
        points.iter().for_each(|&p| ring.push(p));
        ring
    }

    fn push(&mut self, point: Vector<S>) {
        if self.count < self.points.len() {
            self.points[self.count] = point;
            self.count += 1;
        }
    }
}

/// The point from `p` to `q` where a function that is `d` and `e` there vanishes.
fn between<S: Real>(p: Vector<S>, q: Vector<S>, d: S, e: S) -> Vector<S> {
    let t = d / (d - e);
    let along = sub(&q, &p);
    [p[0] + along[0] * t, p[1] + along[1] * t, p[2] + along[2] * t]
}

fn normal<S: Real>([p, q, r]: &[Vector<S>; 3]) -> Vector<S> {
    cross(sub(q, p), sub(r, p))
}

fn largest_axis<S: Real>(v: Vector<S>) -> usize {
    let larger = |i: usize, j: usize| if v[j].abs() > v[i].abs() { j } else { i };
    larger(larger(0, 1), 2)
}
