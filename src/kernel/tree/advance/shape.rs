//! Boxes and triangles as their trajectories carry them, and how long two of them stay apart.

use nalgebra::Vector3;

use super::boxes::MeshBox;
use crate::geometry::Triangle;
use crate::geometry::motion::{Carried, Span, earliest_crossing};

/// A convex set at an instant, in world axes: the points, and around each of them the same box.
pub struct Shape {
    /// A box's centre, or a triangle's corners.
    points: [Carried; 3],
    count: usize,
    /// Along each axis (any vectors) half the box's extent.
    axes: [Vector3<f64>; 3],
    half: [f64; 3],
    /// Directions along which it may be apart from others, of unit length; zero for none.
    faces: [Vector3<f64>; 3],
    /// Radius of a ball that a box fits in; 0 for a triangle, which has no children.
    pub size: f64,
}

/// What is certain of two shapes.
#[derive(Clone, Copy, Debug)]
pub struct Separation {
    /// They are at least so far from each other now.
    pub gap: f64,
    /// They stay apart for at least so long, in seconds from now: 0 if they may meet now.
    pub time: f64,
}

/// What is taken off every bound.
#[derive(Clone, Copy, Debug)]
pub struct Margin {
    /// Shapes nearer than this count as met; all errors of positions are in it.
    pub gap_m: f64,
    /// Errors of speeds.
    pub speed_m_s: f64,
}

impl Shape {
    pub fn of_box(b: &MeshBox, span: &Span) -> Self {
        let size = b.half.norm();
        let center = span.carry(&b.center, size);
        let rotation = nalgebra::Matrix3::from_row_slice(&span.pose().rotation);
        let axes = [0, 1, 2].map(|k| rotation * b.axes.column(k));
        Self {
            points: [center; 3],
            count: 1,
            axes,
            half: b.half.into(),
            faces: axes.map(unit),
            size,
        }
    }

    pub fn of_triangle(corners: &Triangle, span: &Span) -> Self {
        let points = corners.map(|corner| span.carry(&corner.into(), 0.0));
        let [p, q, r] = points.map(|point| point.position);
        let none = Vector3::zeros();
        Self {
            points,
            count: 3,
            axes: [none; 3],
            half: [0.0; 3],
            faces: [unit((q - p).cross(&(r - p))), none, none],
            size: 0.0,
        }
    }

    /// A triangle's corners.
    pub fn corners(&self) -> Triangle {
        self.points.map(|point| point.position.into())
    }

    pub fn normal(&self) -> Vector3<f64> {
        self.faces[0]
    }

    pub fn middle(&self) -> Vector3<f64> {
        self.mean(|point| point.position)
    }

    pub fn mean_velocity(&self) -> Vector3<f64> {
        self.mean(|point| point.velocity)
    }

    fn mean(&self, of: impl Fn(&Carried) -> Vector3<f64>) -> Vector3<f64> {
        self.points().iter().map(of).sum::<Vector3<f64>>() / self.count as f64
    }

    fn points(&self) -> &[Carried] {
        &self.points[..self.count]
    }

    fn radius(&self, n: &Vector3<f64>) -> f64 {
        (0..3).map(|k| self.half[k] * self.axes[k].dot(n).abs()).sum()
    }

    /// The longest time that any of a few directions proves: the faces of both, from one to the other,
    /// and one that is given.
    pub fn separation(
        &self,
        other: &Self,
        along: Option<Vector3<f64>>,
        margin: Margin,
    ) -> Separation {
        let between = other.middle() - self.middle();
        let directions = self.faces.into_iter().chain(other.faces).chain([unit(between)]);
        let mut best = Separation { gap: 0.0, time: 0.0 };
        for n in directions.chain(along) {
            let n = if n.dot(&between) < 0.0 { -n } else { n };
            let gap = self.gap(other, &n);
            if gap > margin.gap_m {
                best.gap = best.gap.max(gap);
                best.time = best.time.max(self.time(other, &n, margin));
            }
        }
        best
    }

    /// How far apart they are along a direction, from this one to the other.
    fn gap(&self, other: &Self, n: &Vector3<f64>) -> f64 {
        let along = |point: &Carried| point.position.dot(n);
        let last = self.points().iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        let first = other.points().iter().map(along).fold(f64::INFINITY, f64::min);
        first - last - self.radius(n) - other.radius(n)
    }

    /// How long a gap along a direction lasts: each point of this shape stays below each of the other.
    /// Velocities in a rigid motion are linear in the point, so that a triangle's corners bound it.
    fn time(&self, other: &Self, n: &Vector3<f64>, margin: Margin) -> f64 {
        let back = -n;
        let radii = self.radius(n) + other.radius(n) + margin.gap_m;
        let mut least = f64::INFINITY;
        for a in self.points() {
            let from_a = a.growth(n);
            for b in other.points() {
                let gap = (b.position - a.position).dot(n) - radii;
                let from_b = b.growth(&back);
                let crossing = |k: usize| {
                    let speed = from_a[k].speed + from_b[k].speed + margin.speed_m_s;
                    earliest_crossing(gap, speed, from_a[k].acceleration + from_b[k].acceleration)
                };
                least = least.min(crossing(0).max(crossing(1)));
            }
        }
        least
    }
}

/// The squares of what is shorter have too few digits.
const SHORTEST: f64 = 1e-140;

/// Of unit length, or zero where there is no direction.
pub fn unit(v: Vector3<f64>) -> Vector3<f64> {
    v.try_normalize(SHORTEST).unwrap_or_else(Vector3::zeros)
}
