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
    fn area(&self) -> f64 {
        self.size[0] * self.size[1]
    }
}

/// Over a convex polygon in the ground of a room, up to a plane within its height.
#[derive(Clone, Debug)]
pub struct Column {
    corners: std::ops::Range<u32>,
    pub low: Point2,
    pub high: Point2,
    /// 1 under a triangle that faces up, -1 under one that faces down.
    pub sign: f64,
    /// A point of the plane, and its slopes.
    foot: Point,
    slopes: Point2,
    heights: [f64; 2],
    /// Bounds on the errors of a height, and of a place.
    pub height_error: f64,
    pub place_error: f64,
}

impl Column {
    #[inline]
    pub fn height(&self, [x, y]: &Point2) -> f64 {
        let [at_x, at_y, at_z] = self.foot;
        let height = at_z + self.slopes[0] * (x - at_x) + self.slopes[1] * (y - at_y);
        height.clamp(self.heights[0], self.heights[1])
    }

    pub fn highest(&self) -> f64 {
        self.heights[1]
    }
}

/// The columns of a mesh, their corners one after another. Holds its memory.
#[derive(Debug, Default)]
pub struct Columns {
    pub all: Vec<Column>,
    corners: Vec<Point2>,
    /// What the result loses with triangles that are not exactly where they should be, or are left
    /// out, m³.
    pub error: f64,
    polygon: Vec<Point>,
    room: Vec<Point>,
}

impl Columns {
    pub fn clear(&mut self) {
        self.all.clear();
        self.corners.clear();
        self.error = 0.0;
    }

    pub fn corners(&self, column: &Column) -> &[Point2] {
        &self.corners[column.corners.start as usize..column.corners.end as usize]
    }

    /// The columns under a triangle, as far as they are in the room: one up to it, and one up to the
    /// ceiling where it is above.
    pub fn add(&mut self, triangle: &Triangle, room: &Room) {
        let local = triangle.map(|p| [0, 1, 2].map(|k| p[k] - room.low[k]));
        let outside = |k: usize| {
            local.iter().all(|p| p[k] <= 0.0) || local.iter().all(|p| p[k] >= room.size[k])
        };
        if outside(0) || outside(1) || local.iter().all(|p| p[2] <= 0.0) {
            return;
        }
        let Some(slant) = Slant::of(&local) else {
            // Upright, or so nearly that its sign is not certain: it covers next to nothing.
            self.error += 16.0 * ROUNDOFF * square_of_span(&local).min(room.area()) * room.size[2];
            return;
        };
        // Both its places and their rounding move the surface by some units of the last place.
        let reach = local.as_flattened().iter().fold(0.0, |most: f64, c| most.max(c.abs()));
        self.error += 2.0 * ROUNDOFF * reach * slant.area.min(2.0 * room.area() + room.size[2].powi(2));
        self.fill(&local, &slant, room);
    }

    fn fill(&mut self, local: &Triangle, slant: &Slant, room: &Room) {
        let (mut polygon, mut left) =
            (std::mem::take(&mut self.polygon), std::mem::take(&mut self.room));
        polygon.clear();
        polygon.extend(if slant.sign > 0.0 { *local } else { [local[0], local[2], local[1]] });
        let [width, depth, height] = room.size;
        let walls = [(0, 1.0, 0.0), (0, -1.0, width), (1, 1.0, 0.0), (1, -1.0, depth)];
        for (axis, inward, from) in walls.into_iter().chain([(2, 1.0, 0.0)]) {
            clip(&polygon, |p| from + inward * p[axis], &mut left);
            std::mem::swap(&mut polygon, &mut left);
        }
        if polygon.iter().all(|p| p[2] <= height) {
            self.push(&polygon, local, slant);
        } else {
            clip(&polygon, |p| height - p[2], &mut left);
            self.push(&left, local, slant);
            clip(&polygon, |p| p[2] - height, &mut left);
            left.iter_mut().for_each(|p| p[2] = height);
            self.push(&left, local, &Slant { slopes: [0.0; 2], height_error: 0.0, ..*slant });
        }
        (self.polygon, self.room) = (polygon, left);
    }

    fn push(&mut self, polygon: &[Point], local: &Triangle, slant: &Slant) {
        let Some(&first) = polygon.first() else { return };
        let from = self.corners.len() as u32;
        self.corners.extend(polygon.iter().map(|p| [p[0], p[1]]));
        let (low, high) = bounds(polygon);
        let flat = slant.slopes == [0.0; 2];
        let reach = local.iter().fold(0.0, |most: f64, p| most.max(p[0].abs()).max(p[1].abs()));
        self.all.push(Column {
            corners: from..self.corners.len() as u32,
            low: [low[0], low[1]],
            high: [high[0], high[1]],
            sign: slant.sign,
            foot: if flat { first } else { local[0] },
            slopes: slant.slopes,
            heights: [low[2], high[2]],
            height_error: slant.height_error.min(high[2] - low[2]),
            place_error: 8.0 * ROUNDOFF * reach,
        });
    }
}

/// The square of the longest side of the box round a triangle's shadow.
fn square_of_span(triangle: &Triangle) -> f64 {
    let (low, high) = bounds(triangle);
    (high[0] - low[0]).max(high[1] - low[1]).powi(2)
}

/// How a triangle leans.
#[derive(Clone, Copy)]
struct Slant {
    sign: f64,
    slopes: Point2,
    /// Bound on the error of a height computed from a corner and the slopes.
    height_error: f64,
    area: f64,
}

impl Slant {
    /// `None`: upright, to rounding.
    fn of(triangle: &Triangle) -> Option<Self> {
        let [a, b, c] = triangle.map(|p| [p[0], p[1]]);
        let span = square_of_span(triangle);
        let shadow = twice_area(&a, &b, &c);
        if shadow.abs() <= 16.0 * ROUNDOFF * span {
            return None;
        }
        let [a, b, c] = triangle;
        let ([bx, by, bz], [cx, cy, cz]) =
            ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let slopes = [(bz * cy - cz * by) / shadow, (cz * bx - bz * cx) / shadow];
        let steepness = slopes[0].abs() + slopes[1].abs();
        // Relative to the products that a slope and the shadow are made of, times the way to a
        // point of the triangle.
        let rise = bz.abs().max(cz.abs());
        let of_slopes = span.sqrt() * (span.sqrt() * rise + steepness * span) / shadow.abs();
        let reach = triangle.iter().fold(0.0, |most: f64, p| most.max(p[0].abs()).max(p[1].abs()));
        let height = triangle.iter().fold(0.0, |most: f64, p| most.max(p[2].abs()));
        Some(Self {
            sign: shadow.signum(),
            slopes,
            height_error: 8.0 * ROUNDOFF * (of_slopes + steepness * reach + height),
            area: 0.5 * shadow.abs() * (1.0 + slopes[0].powi(2) + slopes[1].powi(2)).sqrt(),
        })
    }
}
