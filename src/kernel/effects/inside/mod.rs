//! Which parts of one mesh are inside the other where no triangles touch: that nothing touches does
//! not mean apart.

mod crossings;
mod effect;
mod way_out;

pub use crossings::{Location, Locator};
pub use effect::ContainmentEffect;

use crate::geometry::boxes::bounds;
use crate::geometry::{Point, Pose};
use crate::mesh::closed::Shells;

/// How two meshes that do not touch lie in each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Containment {
    /// No part is inside the other mesh.
    None,
    /// Every part of the moving mesh is inside the fixed one.
    MovingInFixed,
    /// Every part of the fixed mesh is inside the moving one.
    FixedInMoving,
    /// Some parts are.
    Partly,
}

/// Connected parts of each mesh that are inside the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Contained {
    pub moving_in_fixed: usize,
    pub fixed_in_moving: usize,
    moving_parts: usize,
    fixed_parts: usize,
}

impl Contained {
    pub fn containment(&self) -> Containment {
        match *self {
            Self { moving_in_fixed: 0, fixed_in_moving: 0, .. } => Containment::None,
            Self { moving_in_fixed: n, fixed_in_moving: 0, moving_parts, .. }
                if n == moving_parts =>
            {
                Containment::MovingInFixed
            }
            Self { fixed_in_moving: n, moving_in_fixed: 0, fixed_parts, .. }
                if n == fixed_parts =>
            {
                Containment::FixedInMoving
            }
            _ => Containment::Partly,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a vertex of the moving mesh leaves the range of 64-bit numbers in this pose")]
pub struct OutOfRange;

/// Finds what is inside. Holds its memory between queries.
#[derive(Debug, Default)]
pub struct Nesting {
    locator: Locator,
    /// The points of the moving mesh as [`Pose::apply`] places them.
    placed: Vec<Point>,
    /// One point of each part that may be inside.
    probes: [Vec<Point>; 2],
}

impl Nesting {
    /// The parts of each mesh that are inside the closed parts of the other.
    ///
    /// Asked where no triangles touch: then a part is inside if one of its vertices is, and the
    /// part itself need not be closed. Where they do touch, the answer holds for those vertices
    /// only; one that is on the surface is not inside.
    pub fn contained(
        &mut self,
        fixed: &Shells,
        moving: &Shells,
        pose: &Pose,
    ) -> Result<Contained, OutOfRange> {
        self.keep_inside(fixed, moving, pose)?;
        Ok(Contained {
            moving_in_fixed: self.probes[1].len(),
            fixed_in_moving: self.probes[0].len(),
            moving_parts: moving.parts().len(),
            fixed_parts: fixed.parts().len(),
        })
    }

    /// Makes `probes` the vertices of the fixed and the moving mesh that stand for a part inside.
    fn keep_inside(
        &mut self,
        fixed: &Shells,
        moving: &Shells,
        pose: &Pose,
    ) -> Result<(), OutOfRange> {
        place(moving, pose, &mut self.placed)?;
        let Self { locator, placed, probes } = self;
        let [of_fixed, of_moving] = probes;
        choose(fixed, fixed.points(), placed, of_fixed);
        choose(moving, placed, fixed.points(), of_moving);
        retain_inside(locator, of_fixed, moving, placed);
        retain_inside(locator, of_moving, fixed, fixed.points());
        Ok(())
    }
}

pub(super) fn place(
    moving: &Shells,
    pose: &Pose,
    placed: &mut Vec<Point>,
) -> Result<(), OutOfRange> {
    placed.clear();
    placed.extend(moving.points().iter().map(|&point| pose.apply(point)));
    let finite = |all: bool, point: &Point| all & point.iter().all(|c| c.is_finite());
    if placed.iter().fold(true, finite) { Ok(()) } else { Err(OutOfRange) }
}

/// A point of each part, if it is within the bounds of the other mesh.
fn choose(shells: &Shells, points: &[Point], other: &[Point], probes: &mut Vec<Point>) {
    let (low, high) = bounds(other);
    let within = |point: &Point| (0..3).all(|k| low[k] <= point[k] && point[k] <= high[k]);
    probes.clear();
    let all = shells.parts().iter().map(|part| points[part.vertex as usize]);
    probes.extend(all.filter(within));
}

fn retain_inside(
    locator: &mut Locator,
    probes: &mut Vec<Point>,
    shells: &Shells,
    placed: &[Point],
) {
    let mut locations = locator.locate(probes, shells, placed).iter();
    probes.retain(|_| locations.next() == Some(&Location::Inside));
}
