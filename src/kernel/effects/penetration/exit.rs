//! How far one triangle has to go to lose touch with another.

use nalgebra::{Vector2, Vector3};

use super::Direction;
use crate::geometry::Triangle;

/// The greatest s for which `a` and `b + s direction` touch, if they touch at some s: at all s from
/// there up to this one, since these s are an interval. In plain f64; what rounding loses is a few
/// units of the last place, more where the triangles slide along each other.
///
/// All differences of a point of `a` and one of `b` are the hull of the nine differences of their
/// corners. Seen along the direction, the answer is the height of this hull above the origin: that
/// of a triangle of three corners, or, where the hull is seen from its edge, of a segment or point.
pub fn exit_distance(a: &Triangle, b: &Triangle, direction: &Direction) -> Option<f64> {
    let view = View::along(direction);
    view.exit(&view.seen(a), &view.seen(b))
}

/// Axes across a direction, and along it.
pub(super) struct View {
    across: [Vector3<f64>; 2],
    along: Vector3<f64>,
}

/// A triangle seen along the direction; z is along it.
type Seen = [Vector3<f64>; 3];

impl View {
    pub fn along(direction: &Direction) -> Self {
        Self { across: direction.across(), along: *direction.vector() }
    }

    pub fn seen(&self, triangle: &Triangle) -> Seen {
        triangle.map(|p| {
            let p = Vector3::from(p);
            Vector3::new(p.dot(&self.across[0]), p.dot(&self.across[1]), p.dot(&self.along))
        })
    }

    /// No exit of `b` from `a` is farther.
    pub fn bound(&self, a: &Triangle, b: &Triangle) -> f64 {
        let heights = |t: &Triangle| t.map(|p| Vector3::from(p).dot(&self.along));
        let highest = heights(a).into_iter().fold(f64::NEG_INFINITY, f64::max);
        highest - heights(b).into_iter().fold(f64::INFINITY, f64::min)
    }

    pub fn exit(&self, a: &Seen, b: &Seen) -> Option<f64> {
        Hull::of(std::array::from_fn(|i| a[i / 3] - b[i % 3])).height()
    }
}

struct Hull {
    /// As they are along the direction, and across it so large that the farthest is at 1.
    corners: [Vector3<f64>; 9],
    /// Of each two corners, seen from the origin, twice the area between.
    turns: [[f64; 9]; 9],
}

impl Hull {
    /// What is nearer than this is seen in one place: far more than rounding does.
    const NEAR: f64 = 1.5e-11;

    fn of(mut corners: [Vector3<f64>; 9]) -> Self {
        let size = corners.iter().map(|c| c.x.abs().max(c.y.abs())).fold(0.0, f64::max);
        let scale = if size > 1e-300 { size.recip() } else { 1.0 };
        corners.iter_mut().for_each(|corner| {
            corner.x *= scale;
            corner.y *= scale;
        });
        let mut turns = [[0.0; 9]; 9];
        for i in 0..9 {
            for j in 0..i {
                let turn = corners[i].x * corners[j].y - corners[i].y * corners[j].x;
                (turns[i][j], turns[j][i]) = (turn, -turn);
            }
        }
        Self { corners, turns }
    }

    fn height(&self) -> Option<f64> {
        let mut highest: Option<f64> = None;
        let mut meet = |height: Option<f64>| {
            if let Some(height) = height {
                highest = Some(highest.map_or(height, |highest| highest.max(height)));
            }
        };
        for i in 0..9 {
            meet(self.of_corner(i));
            for j in 0..i {
                meet(self.of_segment(i, j));
                for k in 0..j {
                    meet(self.of_triangle([i, j, k]));
                }
            }
        }
        highest
    }

    fn of_corner(&self, i: usize) -> Option<f64> {
        let corner = &self.corners[i];
        (corner.x.abs() <= Self::NEAR && corner.y.abs() <= Self::NEAR).then_some(corner.z)
    }

    fn of_segment(&self, i: usize, j: usize) -> Option<f64> {
        let (from, to) = (&self.corners[i], &self.corners[j]);
        let way = to - from;
        let way = Vector2::new(way.x, way.y);
        let length = way.norm();
        if length <= Self::NEAR || self.turns[i][j].abs() > Self::NEAR * length {
            return None;
        }
        let t = -(from.x * way.x + from.y * way.y) / (length * length);
        (0.0..=1.0).contains(&t).then(|| from.z + t * (to.z - from.z))
    }

    fn of_triangle(&self, [i, j, k]: [usize; 3]) -> Option<f64> {
        let [of_i, of_j, of_k] = [self.turns[j][k], self.turns[k][i], self.turns[i][j]];
        let round = (of_i >= 0.0 && of_j >= 0.0 && of_k >= 0.0)
            || (of_i <= 0.0 && of_j <= 0.0 && of_k <= 0.0);
        if !round {
            return None;
        }
        let [a, b, c] = [i, j, k].map(|i| &self.corners[i]);
        let side = |p: &Vector3<f64>, q: &Vector3<f64>| (p.x - q.x).abs().max((p.y - q.y).abs());
        let area = of_i + of_j + of_k;
        let narrow = area.abs() <= Self::NEAR * side(a, b).max(side(b, c)).max(side(c, a));
        (!narrow).then(|| (of_i * a.z + of_j * b.z + of_k * c.z) / area)
    }
}
