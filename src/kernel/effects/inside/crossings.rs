//! Where points are from a closed surface, by the crossings of a ray from each.
//!
//! The rays go up, along z, from points moved aside by (e, e²) for an e smaller than any number:
//! a point off the surface stays on its side of it, and a ray from there meets no edge, no vertex
//! and no upright triangle ("simulation of simplicity", Edelsbrunner & Mücke 1990). Every sign is
//! exact.

use std::cmp::Ordering;

use crate::geometry::boxes::bounds;
use crate::geometry::predicates::{Point2, StaticFilter, orient2d, orient3d};
use crate::geometry::triangle::triangles_intersect;
use crate::geometry::{Point, Triangle};
use crate::mesh::closed::Shells;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    Outside,
    /// On a triangle of a closed part.
    On,
    Inside,
}

/// Locates many points in one pass over a surface. Holds its memory between queries.
#[derive(Debug, Default)]
pub struct Locator {
    /// Positions in `points`, by x; and the x of each.
    order: Vec<u32>,
    xs: Vec<f64>,
    /// In the same order.
    counts: Vec<Count>,
    locations: Vec<Location>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Count {
    /// How often the parts that are solid wind round the point.
    winding: i32,
    /// Of crossings of the current one of the other parts.
    odd: bool,
    inside: bool,
    on: bool,
}

impl Locator {
    /// The location of each of `points`, finite, from the closed parts of `shells`, whose points are
    /// `placed`, finite; parts that are not closed do not count.
    ///
    /// Inside is what solid parts wind round, be it more than once, as where parts of a model
    /// overlap; in a cavity, whose triangles face the other way, they wind not at all. A closed part
    /// with turned triangles has the points inside whose rays cross it an odd number of times.
    pub fn locate(&mut self, points: &[Point], shells: &Shells, placed: &[Point]) -> &[Location] {
        self.sort(points);
        for part in shells.parts().iter().filter(|part| part.is_closed()) {
            let (low, high) = bounds(&placed[shells.points_of(part)]);
            if !self.any_may_cross(points, &low, &high) {
                continue;
            }
            for face in shells.faces(part) {
                let triangle = face.map(|corner| placed[corner as usize]);
                self.cross(points, &triangle, part.is_solid());
            }
            if !part.is_solid() {
                for count in &mut self.counts {
                    count.inside |= std::mem::take(&mut count.odd);
                }
            }
        }
        self.locations.clear();
        self.locations.resize(points.len(), Location::Outside);
        for (&i, count) in self.order.iter().zip(&self.counts) {
            self.locations[i as usize] = match count {
                Count { on: true, .. } => Location::On,
                Count { winding: 0, inside: false, .. } => Location::Outside,
                _ => Location::Inside,
            };
        }
        &self.locations
    }

    fn sort(&mut self, points: &[Point]) {
        self.order.clear();
        self.order.extend(0..points.len() as u32);
        self.order
            .sort_unstable_by(|&i, &j| points[i as usize][0].total_cmp(&points[j as usize][0]));
        self.xs.clear();
        self.xs.extend(self.order.iter().map(|&i| points[i as usize][0]));
        self.counts.clear();
        self.counts.resize(points.len(), Count::default());
    }

    /// Whether the ray from any of the points may meet what is within bounds.
    fn any_may_cross(&self, points: &[Point], low: &Point, high: &Point) -> bool {
        let from = self.xs.partition_point(|x| *x < low[0]);
        let beside = self.xs[from..].iter().zip(&self.order[from..]);
        let beside = beside.take_while(|(x, _)| **x <= high[0]);
        beside
            .map(|(_, &i)| &points[i as usize])
            .any(|point| low[1] <= point[1] && point[1] <= high[1] && point[2] <= high[2])
    }

    #[inline]
    fn cross(&mut self, points: &[Point], triangle: &Triangle, solid: bool) {
        let [a, b, c] = triangle;
        let (low, high) = (a[0].min(b[0]).min(c[0]), a[0].max(b[0]).max(c[0]));
        let (Some(first), Some(last)) = (self.xs.first(), self.xs.last()) else { return };
        if high < *first || low > *last {
            return;
        }
        let from = self.xs.partition_point(|x| *x < low);
        for at in from..self.xs.len() {
            if self.xs[at] > high {
                break;
            }
            let point = &points[self.order[at] as usize];
            match crossing(point, triangle) {
                Crossing::None => {}
                Crossing::On => self.counts[at].on = true,
                Crossing::Through { .. } if !solid => self.counts[at].odd ^= true,
                Crossing::Through { up } => self.counts[at].winding += if up { 1 } else { -1 },
            }
        }
    }
}

enum Crossing {
    None,
    /// The point is on the closed triangle.
    On,
    /// The triangle faces up, or down.
    Through {
        up: bool,
    },
}

fn crossing(point: &Point, triangle: &Triangle) -> Crossing {
    let (low, high) = bounds(triangle);
    if (0..2).any(|k| point[k] < low[k] || point[k] > high[k]) || point[2] > high[2] {
        return Crossing::None;
    }
    let filter = || {
        let extent = [0, 1, 2].map(|k| high[k].max(point[k]) - low[k].min(point[k]));
        StaticFilter::for_extent(extent)
    };
    let beside = point[2] >= low[2];
    if beside && triangles_intersect(&[*point; 3], triangle, &filter()) {
        return Crossing::On;
    }
    let [a, b, c] = triangle.map(|[x, y, _]| [x, y]);
    let aside = [point[0], point[1]];
    let turn = side_of_moved(&a, &b, &aside);
    if turn.is_eq() || [(b, c), (c, a)].iter().any(|(u, v)| side_of_moved(u, v, &aside) != turn) {
        return Crossing::None;
    }
    // In the plane it would be on the triangle.
    let [a, b, c] = triangle;
    if beside && orient3d(a, b, c, point, &filter()) == turn {
        return Crossing::None;
    }
    Crossing::Through { up: turn.is_gt() }
}

/// [`orient2d`] of `u`, `v` and `point` + (e, e²), by its derivatives where it is zero; `Equal` only
/// if `u` is `v`.
fn side_of_moved(u: &Point2, v: &Point2, point: &Point2) -> Ordering {
    let order = |x: f64, y: f64| x.partial_cmp(&y).expect("coordinates are numbers");
    orient2d(u, v, point).then_with(|| order(u[1], v[1])).then_with(|| order(v[0], u[0]))
}
