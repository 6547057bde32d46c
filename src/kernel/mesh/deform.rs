//! A dent in a mesh.

use super::{MeshError, TriangleMesh};
use crate::geometry::Point;
use crate::geometry::boxes::dot;

/// Where, in which direction and how deep a mesh is pushed in.
///
/// The zone is what lies before and behind a rectangle: `width` across the direction and level,
/// `height` across both, up if the direction is level. (Where the direction is vertical, `width` is
/// along y and `height` along x.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dent {
    point: Point,
    inward: Point,
    /// Along the width and the height.
    across: [Point; 2],
    /// Infinite for the whole height.
    half: [f64; 2],
    depth: f64,
    taper: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DentError {
    #[error("the dent's point has a coordinate that is no finite number")]
    Point,
    #[error("the dent's direction has length {0}; give a unit vector")]
    Inward(f64),
    #[error("the dent is {value} m {extent}; give a positive, finite number")]
    Extent { extent: &'static str, value: f64 },
    #[error("the dent's depth or taper is {0} m; give a finite number, not negative")]
    Negative(f64),
}

impl Dent {
    /// Metres. `point`: in the middle of the zone, at any depth. `inward`: of unit length to 1e-6.
    /// `height_m`: absent for all of the mesh's height. `taper_m`: how far around the zone the mesh is
    /// drawn in with it.
    pub fn new(
        point: Point,
        inward: Point,
        width_m: f64,
        height_m: Option<f64>,
        depth_m: f64,
        taper_m: f64,
    ) -> Result<Self, DentError> {
        if !point.iter().all(|c| c.is_finite()) {
            return Err(DentError::Point);
        }
        let length = dot(&inward, &inward).sqrt();
        if !(1.0 - 1e-6..=1.0 + 1e-6).contains(&length) {
            return Err(DentError::Inward(length));
        }
        for (extent, value) in [("wide", width_m), ("high", height_m.unwrap_or(1.0))] {
            if !(value.is_finite() && value > 0.0) {
                return Err(DentError::Extent { extent, value });
            }
        }
        for value in [depth_m, taper_m] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(DentError::Negative(value));
            }
        }
        let inward = inward.map(|c| c / length);
        let half = [0.5 * width_m, height_m.map_or(f64::INFINITY, |height| 0.5 * height)];
        let across = level_frame(&inward);
        Ok(Self { point, inward, across, half, depth: depth_m, taper: taper_m })
    }

    fn relative(&self, vertex: &Point) -> Point {
        [0, 1, 2].map(|k| vertex[k] - self.point[k])
    }

    /// How far a vertex lies outside of the zone's rectangle.
    fn outside(&self, vertex: &Point) -> f64 {
        let from = self.relative(vertex);
        let beyond = |i: usize| (dot(&from, &self.across[i]).abs() - self.half[i]).max(0.0);
        beyond(0).hypot(beyond(1))
    }

    fn along(&self, vertex: &Point) -> f64 {
        dot(&self.relative(vertex), &self.inward)
    }

    /// How far a vertex is pushed in, of a mesh whose outermost in the zone is at `front`.
    fn push(&self, vertex: &Point, front: f64) -> f64 {
        let outside = self.outside(vertex);
        let weight = if outside == 0.0 { 1.0 } else { falling(outside / self.taper) };
        let behind = (self.along(vertex) - front).max(0.0);
        weight * self.depth * falling(behind / (REACH * self.depth))
    }
}

/// How far behind the outermost vertex a mesh is pushed in, in depths of the dent.
const REACH: f64 = 3.0;

/// Level and across, and across both.
fn level_frame(inward: &Point) -> [Point; 2] {
    let [x, y, z] = *inward;
    let level = x.hypot(y);
    // Of a unit vector; a direction this close to the vertical has no heading worth the name.
    let width = if level > 1e-6 { [-y / level, x / level, 0.0] } else { [0.0, 1.0, 0.0] };
    let height =
        [y * width[2] - z * width[1], z * width[0] - x * width[2], x * width[1] - y * width[0]];
    [width, height]
}

/// From 1 at 0 to 0 at 1 and beyond, level at both ends; nowhere steeper than 3/2.
fn falling(x: f64) -> f64 {
    let rest = 1.0 - x.clamp(0.0, 1.0);
    rest * rest * (3.0 - 2.0 * rest)
}

/// The mesh pushed in: in the zone no vertex is left in front of the plane that lies the dent's depth
/// behind the zone's outermost vertex. Faces stay as they are, and are not divided; a zone without
/// vertices changes nothing.
///
/// Every vertex goes `w u` further along the direction. `u` is the depth at the outermost vertex of
/// the zone, and falls smoothly to nothing at three times the depth behind it: what is crushed is
/// pressed together, not pushed through. `w` is 1 in the zone and falls smoothly to nothing over the
/// taper around it; vertices further out keep their bits. As `u` falls by at most half of what one
/// goes in, a vertex behind another one along the direction stays behind it: the motion of space that
/// this is a part of is continuous and one to one, and folds nothing over.
pub fn deform(mesh: &TriangleMesh, dent: &Dent) -> Result<TriangleMesh, MeshError> {
    let in_zone = mesh.vertices().iter().filter(|vertex| dent.outside(vertex) == 0.0);
    let front = in_zone.map(|vertex| dent.along(vertex)).fold(f64::INFINITY, f64::min);
    let pushed = |vertex: &Point| {
        let push = dent.push(vertex, front);
        // Adding nothing would still change the sign of a zero.
        let moves = push > 0.0 && front.is_finite();
        if moves { [0, 1, 2].map(|k| vertex[k] + push * dent.inward[k]) } else { *vertex }
    };
    TriangleMesh::new(mesh.vertices().iter().map(pushed).collect(), mesh.faces().to_vec())
}
