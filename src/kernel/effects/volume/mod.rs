//! Volumes of closed meshes and of their overlap.
//!
//! A mesh is the sum of the upright columns under its triangles, those under triangles that face
//! down taken negative; so two meshes have in common the sum over all pairs of columns, each with
//! the sign of both, of what the columns have in common: over the convex polygon that both stand
//! on, up to the lower of their two planes. No intersection of the surfaces has to be known, and
//! nothing is special about faces in one plane (after Cohen & Hickey, "Two algorithms for
//! determining volumes of convex polyhedra", J. ACM 26, 1979).

mod column;
mod effect;
mod grid;
mod polygon;

pub use effect::VolumeEffect;

use super::inside::{OutOfRange, place};
use crate::geometry::boxes::bounds;
use crate::geometry::predicates::Point2;
use crate::geometry::{Point, Pose, Triangle};
use crate::mesh::closed::{Part, Shells};
use column::{Column, Columns, ROUNDOFF, Room};
use grid::Grid;
use polygon::{clip, integrate_lesser, intersect};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    pub cubic_metres: f64,
    /// Bound, to first order in the unit roundoff, on what rounding can have done to it.
    pub error: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VolumeError {
    #[error(
        "the {0} mesh has no closed part whose triangles all face one side, so it has no volume: \
         close its open edges (bumper mesh info counts them)"
    )]
    NotSolid(&'static str),
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    #[error("the volume leaves the range of 64-bit numbers: the meshes are in metres")]
    TooLarge,
}

/// Of the solid parts of a mesh, negative if triangles face inward; space in several parts counts
/// several times, and a cavity not at all.
///
/// The sum of tetrahedra from one point, each with an error of some units of the last place.
pub fn volume(shells: &Shells) -> Volume {
    let (mut sum, mut size) = (Sum::default(), 0.0);
    let origin = shells.points().first().copied().unwrap_or_default();
    for [a, b, c] in solid_triangles(shells, shells.points()) {
        let [a, b, c] = [a, b, c].map(|p| [0, 1, 2].map(|k| p[k] - origin[k]));
        let terms = [0, 1, 2].map(|k| {
            let (l, m) = ((k + 1) % 3, (k + 2) % 3);
            [a[k] * b[l] * c[m], -a[k] * b[m] * c[l]]
        });
        sum.add(terms.as_flattened().iter().sum::<f64>() / 6.0);
        size += terms.as_flattened().iter().map(|term| term.abs() / 6.0).sum::<f64>();
    }
    // Each term: three differences, two products, five sums and a quotient.
    Volume { cubic_metres: sum.value(), error: 16.0 * ROUNDOFF * size }
}

fn solid_parts(shells: &Shells) -> impl Iterator<Item = &Part> {
    shells.parts().iter().filter(|part| part.is_solid())
}

fn solid_triangles<'a>(
    shells: &'a Shells,
    placed: &'a [Point],
) -> impl Iterator<Item = Triangle> + 'a {
    let faces = solid_parts(shells).flat_map(|part| shells.faces(part));
    faces.map(|face| face.map(|corner| placed[corner as usize]))
}

/// Finds volumes of overlap. Holds its memory between queries.
#[derive(Debug, Default)]
pub struct Overlap {
    placed: Vec<Point>,
    columns: [Columns; 2],
    grid: Grid,
    /// Work on what two columns stand on.
    polygon: Vec<Point2>,
    left: Vec<Point2>,
}

impl Overlap {
    /// What the solid parts of both meshes have in common, the moving one placed by
    /// [`Pose::apply`]; whichever side the triangles of a whole mesh face. Space in several parts of
    /// a mesh counts several times.
    ///
    /// The error, not of the models but of their volume, is the sum over all pairs of columns of
    /// - that of the polygon in common: its sides are off by no more than the places of the corners
    ///   and crossings they were computed from, so its area by that times half its boxes' common
    ///   circumference, and the lesser height times that is lost or won;
    /// - that of both heights, times the area;
    ///
    /// and, triangle by triangle, of moving its corners by one rounding where they are taken
    /// relative to the common box, which keeps closed meshes closed.
    pub fn volume(
        &mut self,
        fixed: &Shells,
        moving: &Shells,
        pose: &Pose,
    ) -> Result<Volume, VolumeError> {
        for (name, shells) in [("fixed", fixed), ("moving", moving)] {
            solid_parts(shells).next().ok_or(VolumeError::NotSolid(name))?;
        }
        place(moving, pose, &mut self.placed)?;
        let Some(room) = common_box(fixed, moving, &self.placed) else {
            return Ok(Volume { cubic_metres: 0.0, error: 0.0 });
        };
        let [of_fixed, of_moving] = &mut self.columns;
        of_fixed.clear();
        of_moving.clear();
        solid_triangles(fixed, fixed.points()).for_each(|t| of_fixed.add(&t, &room));
        solid_triangles(moving, &self.placed).for_each(|t| of_moving.add(&t, &room));
        let Volume { cubic_metres, error } = self.sum_of_pairs(&room);
        if !(cubic_metres.is_finite() && error.is_finite()) {
            return Err(VolumeError::TooLarge);
        }
        let [fixed_turned, moving_turned] =
            [fixed, moving].map(|shells| volume(shells).cubic_metres < 0.0);
        let sign = if fixed_turned == moving_turned { 1.0 } else { -1.0 };
        // Adding makes no zero negative.
        Ok(Volume { cubic_metres: 0.0 + sign * cubic_metres, error })
    }

    fn sum_of_pairs(&mut self, room: &Room) -> Volume {
        let Self { columns: [of_fixed, of_moving], grid, polygon, left, .. } = self;
        grid.fill(&of_fixed.all, room);
        let (mut sum, mut error) = (Sum::default(), of_fixed.error + of_moving.error);
        for one in &of_moving.all {
            grid.each_overlapping(one, &of_fixed.all, |other, size| {
                stand_on(one, other, room, polygon, left);
                let heights = |p: &Point2| [one.height(p), other.height(p)];
                let [area, common] = integrate_lesser(polygon, heights);
                sum.add(one.sign * other.sign * common);
                error += common_error([one, other], room, size, area) + 16.0 * ROUNDOFF * common;
            });
        }
        Volume { cubic_metres: sum.value(), error: error + 2.0 * ROUNDOFF * sum.value().abs() }
    }
}

/// Makes `polygon` what both columns stand on. Its sides are taken from the triangles as they are,
/// never from corners that were computed: a short side between two of those may point anywhere.
fn stand_on(
    one: &Column,
    other: &Column,
    room: &Room,
    polygon: &mut Vec<Point2>,
    left: &mut Vec<Point2>,
) {
    polygon.clear();
    polygon.extend_from_slice(&one.corners);
    intersect(polygon, &other.corners, left);
    if one.is_cut && other.is_cut {
        room.clip(polygon, left);
    }
    for column in [one, other] {
        if column.heights[0] < 0.0 {
            clip(polygon, |p| column.height(p), left);
            std::mem::swap(polygon, left);
        }
    }
}

fn common_error([one, other]: [&Column; 2], room: &Room, size: Point2, area: f64) -> f64 {
    let at_sides = (one.place_error + other.place_error) * (size[0] + size[1]);
    let highest = one.heights[1].min(other.heights[1]).min(room.size[2]);
    at_sides * highest + area * (one.height_error + other.height_error)
}

/// `None`: apart, or with no volume between.
fn common_box(fixed: &Shells, moving: &Shells, placed: &[Point]) -> Option<Room> {
    let [fixed, moving] = [(fixed, fixed.points()), (moving, placed)].map(|(shells, points)| {
        let faces = solid_parts(shells).flat_map(|part| shells.faces(part).as_flattened());
        bounds(faces.map(|&corner| &points[corner as usize]))
    });
    let low = [0, 1, 2].map(|k| fixed.0[k].max(moving.0[k]));
    let size = [0, 1, 2].map(|k| fixed.1[k].min(moving.1[k]) - low[k]);
    size.iter().all(|&s| s > 0.0).then_some(Room { low, size })
}

/// Added with what each addition loses kept apart (Neumaier 1974).
#[derive(Default)]
struct Sum {
    total: f64,
    lost: f64,
}

impl Sum {
    fn add(&mut self, term: f64) {
        let total = self.total + term;
        let (more, less) =
            if self.total.abs() >= term.abs() { (self.total, term) } else { (term, self.total) };
        self.lost += (more - total) + less;
        self.total = total;
    }

    fn value(&self) -> f64 {
        self.total + self.lost
    }
}
