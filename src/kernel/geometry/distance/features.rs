//! Edges and faces, and the points on them that are nearest to something.

use crate::geometry::predicates::{cross, dot, sub};
use crate::geometry::{Point, Triangle};

/// The nearest pair of points so far.
pub struct Least {
    /// Of their distance.
    pub squared: f64,
    pub points: [Point; 2],
}

impl Least {
    pub const NONE: Self = Self { squared: f64::INFINITY, points: [[0.0; 3]; 2] };

    #[inline(always)]
    pub fn offer(&mut self, p: Point, q: Point) {
        let between = sub(&p, &q);
        let squared = dot(between, between);
        if squared < self.squared {
            *self = Self { squared, points: [p, q] };
        }
    }

    /// Where the lines of two edges are nearest, or as near to there as the first reaches. Not of
    /// parallel ones: of these an end is as near as anything.
    #[inline(always)]
    pub fn offer_crossing(&mut self, first: &Edge, second: &Edge) {
        let normal = cross(first.along, second.along);
        let squared = dot(normal, normal);
        if squared > 0.0 {
            let between = sub(&second.from, &first.from);
            let at = dot(cross(between, second.along), normal) / squared;
            let p = first.at(at.clamp(0.0, 1.0));
            self.offer(p, second.nearest(&p));
        }
    }
}

#[derive(Clone, Copy)]
pub struct Edge {
    from: Point,
    along: Point,
    squared: f64,
}

impl Edge {
    /// In the triangle's order.
    pub fn all([a, b, c]: &Triangle) -> [Self; 3] {
        [Self::new(a, b), Self::new(b, c), Self::new(c, a)]
    }

    fn new(from: &Point, to: &Point) -> Self {
        let along = sub(to, from);
        Self { from: *from, along, squared: dot(along, along) }
    }

    #[inline(always)]
    fn at(&self, part: f64) -> Point {
        [0, 1, 2].map(|k| self.from[k] + part * self.along[k])
    }

    #[inline(always)]
    pub fn nearest(&self, p: &Point) -> Point {
        self.nearest_up_to(p, 1.0)
    }

    /// On the part of the edge that begins it.
    #[inline(always)]
    fn nearest_up_to(&self, p: &Point, part: f64) -> Point {
        if self.squared > 0.0 {
            let at = dot(sub(p, &self.from), self.along) / self.squared;
            self.at(at.clamp(0.0, part))
        } else {
            self.from
        }
    }
}

/// A face by its longest edge and the one from where this begins to the third vertex.
pub struct Face {
    longest: Edge,
    to_apex: Point,
    normal: Point,
    squared: f64,
}

impl Face {
    /// `None` without an area.
    pub fn of(edges: &[Edge; 3]) -> Option<Self> {
        let longest =
            (1..3).fold(0, |best, i| if edges[i].squared > edges[best].squared { i } else { best });
        let to_apex = edges[(longest + 2) % 3].along.map(|c| -c);
        let longest = edges[longest];
        let normal = cross(longest.along, to_apex);
        let squared = dot(normal, normal);
        (squared > 0.0).then_some(Self { longest, to_apex, normal, squared })
    }

    /// Of the chord along the longest edge that is as far up as `p`.
    #[inline(always)]
    pub fn nearest(&self, p: &Point) -> Point {
        let Self { longest, to_apex, normal, squared } = self;
        let from = sub(p, &longest.from);
        let up = (dot(cross(longest.along, from), *normal) / squared).clamp(0.0, 1.0);
        let start = [0, 1, 2].map(|k| longest.from[k] + up * to_apex[k]);
        Edge { from: start, ..*longest }.nearest_up_to(p, 1.0 - up)
    }
}
