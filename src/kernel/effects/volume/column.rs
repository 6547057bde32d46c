//! The upright columns between the ground of a box and the triangles of a mesh.

use super::polygon::{clip, twice_area};
use crate::geometry::boxes::bounds;
use crate::geometry::predicates::Point2;
use crate::geometry::{Point, Triangle};

/// Unit roundoff of f64.
pub const ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// Where both meshes are: `low` is the origin of all coordinates below, so that digits are not spent
/// on where the meshes are.
#[derive(Clone, Copy, Debug, Default)]
pub struct Room {
    pub low: Point,
    pub size: Point,
}

impl Room {
    fn ground(&self) -> f64 {
        self.size[0] * self.size[1]
    }

    /// Leaves of a polygon what is between the walls.
    pub fn clip(&self, polygon: &mut Vec<Point2>, left: &mut Vec<Point2>) {
        for (axis, inward, from) in
            [(0, 1.0, 0.0), (0, -1.0, self.size[0]), (1, 1.0, 0.0), (1, -1.0, self.size[1])]
        {
            clip(polygon, |p| from + inward * p[axis], left);
            std::mem::swap(polygon, left);
        }
    }
}

/// Between the ground and a triangle, which may reach out of the room and under its ground.
#[derive(Clone, Debug)]
pub struct Column {
    /// Of the triangle's shadow on the ground, counterclockwise.
    pub corners: [Point2; 3],
    /// Bounds of the shadow, within the room.
    pub low: Point2,
    pub high: Point2,
    /// The shadow reaches out of the room.
    pub is_cut: bool,
    /// 1 under a triangle that faces up, -1 under one that faces down.
    pub sign: f64,
    /// Of the first corner.
    height: f64,
    slopes: Point2,
    /// The lowest and the highest of the triangle.
    pub heights: [f64; 2],
    /// Bounds on the errors of a height, and of a place.
    pub height_error: f64,
    pub place_error: f64,
}

impl Column {
    #[inline]
    pub fn height(&self, [x, y]: &Point2) -> f64 {
        let [from_x, from_y] = self.corners[0];
        let height = self.height + self.slopes[0] * (x - from_x) + self.slopes[1] * (y - from_y);
        height.clamp(self.heights[0], self.heights[1])
    }
}

/// The columns of a mesh.
#[derive(Debug, Default)]
pub struct Columns {
    pub all: Vec<Column>,
    /// What the volume in common loses with triangles that are not exactly where they should be, or
    /// are left out, m³.
    pub error: f64,
}

impl Columns {
    pub fn clear(&mut self) {
        self.all.clear();
        self.error = 0.0;
    }

    /// The column under a triangle, if any of it is in the room.
    pub fn add(&mut self, triangle: &Triangle, room: &Room) {
        let local = triangle.map(|p| [0, 1, 2].map(|k| p[k] - room.low[k]));
        let (low, high) = bounds(&local);
        let outside = |k: usize| high[k] <= 0.0 || low[k] >= room.size[k];
        if outside(0) || outside(1) || high[2] <= 0.0 {
            return;
        }
        let span = (high[0] - low[0]).max(high[1] - low[1]);
        let rise = high[2] - low[2];
        let shadow = twice_area(&flat(local[0]), &flat(local[1]), &flat(local[2]));
        if shadow.abs() <= 16.0 * ROUNDOFF * span * span {
            // Upright, or so nearly that the sign is not certain: it covers next to nothing.
            self.error += 16.0 * ROUNDOFF * (span * span).min(room.ground()) * room.size[2];
            return;
        }
        let [a, b, c] = if shadow > 0.0 { local } else { [local[0], local[2], local[1]] };
        let slopes = slopes([a, b, c], shadow.abs());
        let steepness = slopes[0].abs() + slopes[1].abs();
        let farthest = |axes: std::ops::Range<usize>| {
            axes.map(|k| low[k].abs().max(high[k].abs())).fold(0.0, f64::max)
        };
        let reach = farthest(0..2);
        // Of the slopes, relative to the products that they and the shadow are made of, on the way
        // to a point of the triangle; of the place; of the sum.
        let of_slopes = span * (span * rise + steepness * span * span) / shadow.abs();
        let height_error = 8.0 * ROUNDOFF * (of_slopes + steepness * reach + farthest(2..3));
        let area = 0.5 * shadow.abs() * (1.0 + slopes[0].powi(2) + slopes[1].powi(2)).sqrt();
        let most = 2.0 * room.ground() + room.size[2].powi(2);
        self.error += 2.0 * ROUNDOFF * farthest(0..3) * area.min(most);
        self.all.push(Column {
            corners: [a, b, c].map(flat),
            low: [0, 1].map(|k| low[k].max(0.0)),
            high: [0, 1].map(|k| high[k].min(room.size[k])),
            is_cut: (0..2).any(|k| low[k] < 0.0 || high[k] > room.size[k]),
            sign: shadow.signum(),
            height: a[2],
            slopes,
            heights: [low[2], high[2]],
            height_error: height_error.min(rise),
            place_error: 8.0 * ROUNDOFF * reach,
        });
    }
}

fn flat([x, y, _]: Point) -> Point2 {
    [x, y]
}

/// Along x and y; `shadow`: twice its area.
fn slopes([a, b, c]: Triangle, shadow: f64) -> Point2 {
    let [[bx, by, bz], [cx, cy, cz]] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
    [(bz * cy - cz * by) / shadow, (cz * bx - bz * cx) / shadow]
}
