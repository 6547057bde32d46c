//! Brings the moving mesh along a line to its first contact with the fixed one.

use super::RandomError;
use super::convex_hull::{hull_corners, reach};
use crate::geometry::boxes::{bounds, dot};
use crate::geometry::{Point, Pose};
use crate::mesh::TriangleMesh;
use crate::tree::TreeView;
use crate::tree::descent::{Descent, DescentError};

/// Bisection ends when the first contact is known this closely, in metres: 2^-10, about 1 mm.
const RESOLUTION: f64 = 1.0 / 1024.0;

/// What all scenarios of two meshes share.
///
/// Distances are those of the two centres along the way. They are tried on a grid of multiples of
/// `step`, a power of two, so that the answer does not depend on where the search starts, as long
/// as it starts outside; a start that differs in its last bit between machines does no harm.
pub(super) struct Approach<'a> {
    fixed: Body<'a>,
    moving: Body<'a>,
    step: f64,
}

struct Body<'a> {
    tree: &'a TreeView<'a>,
    /// Of the bounding box.
    centre: Point,
    /// Of the convex hull, relative to the centre.
    corners: Vec<Point>,
    /// Diagonal of the bounding box.
    size: f64,
}

impl<'a> Body<'a> {
    fn new((mesh, tree): (&TriangleMesh, &'a TreeView<'a>)) -> Self {
        let vertices = used_vertices(mesh);
        let (low, high) = bounds(&vertices);
        let centre = [0, 1, 2].map(|i| low[i] + (high[i] - low[i]) / 2.0);
        let edges = [0, 1, 2].map(|i| high[i] - low[i]);
        let corners = hull_corners(&vertices);
        Self {
            tree,
            centre,
            corners: corners.into_iter().map(|c| [0, 1, 2].map(|i| c[i] - centre[i])).collect(),
            size: dot(&edges, &edges).sqrt(),
        }
    }
}

impl<'a> Approach<'a> {
    pub(super) fn new(
        fixed: (&TriangleMesh, &'a TreeView<'a>),
        moving: (&TriangleMesh, &'a TreeView<'a>),
    ) -> Result<Self, RandomError> {
        let (fixed, moving) = (Body::new(fixed), Body::new(moving));
        let (small, large) = (fixed.size.min(moving.size), fixed.size.max(moving.size));
        // Fine against the smaller mesh, so that it is not carried through the larger one's skin;
        // and a bounded number of steps, however unequal they are.
        let step = power_of_two_below((small / 128.0).max(large / 4096.0));
        let step = step.ok_or(RandomError::Extent(large))?;
        Ok(Self { fixed, moving, step })
    }

    pub(super) fn way(&self, rotation: [f64; 4], direction: Point) -> Way<'_> {
        let turned = Pose::from_quaternion(rotation, [0.0; 3]);
        Way { approach: self, rotation, direction, turned }
    }
}

/// One line on which the moving mesh, turned, comes to the centre of the fixed one.
pub(super) struct Way<'a> {
    approach: &'a Approach<'a>,
    /// Unit quaternion.
    rotation: [f64; 4],
    /// Unit vector, from the fixed centre outwards.
    direction: Point,
    /// The rotation alone.
    turned: Pose,
}

impl Way<'_> {
    /// Places the moving centre at this distance from the fixed one.
    pub(super) fn pose(&self, distance: f64) -> Pose {
        let (from, to) =
            (self.turned.apply(self.approach.moving.centre), self.approach.fixed.centre);
        let translation = [0, 1, 2].map(|i| (to[i] + distance * self.direction[i]) - from[i]);
        Pose::from_quaternion(self.rotation, translation)
    }

    /// The distance of the first contact, on its inner side; `None` if the meshes do not touch at
    /// any step down to where their centres meet.
    pub(super) fn first_contact(&self, descent: &mut Descent) -> Result<Option<f64>, DescentError> {
        let step = self.approach.step;
        let mut number = (self.outside() / step).ceil() + 1.0;
        while number >= 0.0 {
            if self.touches(number * step, descent)? {
                return self.bisect(number * step, descent).map(Some);
            }
            number -= 1.0;
        }
        Ok(None)
    }

    /// From a distance with contact to within [`RESOLUTION`] of one without, a step further out.
    fn bisect(&self, touching: f64, descent: &mut Descent) -> Result<f64, DescentError> {
        let (mut near, mut far) = (touching, touching + self.approach.step);
        while far - near > RESOLUTION {
            let middle = near + (far - near) / 2.0;
            if self.touches(middle, descent)? { near = middle } else { far = middle }
        }
        Ok(near)
    }

    fn touches(&self, distance: f64, descent: &mut Descent) -> Result<bool, DescentError> {
        let (fixed, moving) = (self.approach.fixed.tree, self.approach.moving.tree);
        descent.any_pair(fixed, moving, &self.pose(distance))
    }

    /// A distance from which on outwards the hulls are apart: the least that one of seven planes
    /// proves (across the way, and across the axes of either mesh's own frame).
    fn outside(&self) -> f64 {
        let r = &self.turned.rotation;
        let axes = [
            self.direction,
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [r[0], r[3], r[6]],
            [r[1], r[4], r[7]],
            [r[2], r[5], r[8]],
        ];
        axes.into_iter().filter_map(|axis| self.apart_along(axis)).fold(f64::INFINITY, f64::min)
    }

    /// The distance from which on a plane across `axis` fits between the hulls. A plane nearly
    /// along the way proves little, and little exactly.
    fn apart_along(&self, axis: Point) -> Option<f64> {
        let along = dot(&axis, &self.direction);
        let axis = if along < 0.0 { axis.map(|c| -c) } else { axis };
        let r = &self.turned.rotation;
        // The axis seen from the moving frame, and towards the fixed mesh.
        let towards =
            [0, 1, 2].map(|i| -(r[i] * axis[0] + r[3 + i] * axis[1] + r[6 + i] * axis[2]));
        let reach = reach(&self.approach.fixed.corners, axis)
            + reach(&self.approach.moving.corners, towards);
        (along.abs() > 0.05).then(|| reach / along.abs())
    }
}

/// Vertices of faces: a stray one is no part of the vehicle.
fn used_vertices(mesh: &TriangleMesh) -> Vec<Point> {
    let mut used = vec![false; mesh.vertices().len()];
    for &vertex in mesh.faces().as_flattened() {
        used[vertex as usize] = true;
    }
    mesh.vertices().iter().zip(used).filter(|(_, used)| *used).map(|(&vertex, _)| vertex).collect()
}

/// The largest power of two that is not above `value`; `None` outside of what metres are for.
fn power_of_two_below(value: f64) -> Option<f64> {
    const MANTISSA: u64 = (1 << 52) - 1;
    let sensible = value > 1e-9 && value < 1e9;
    sensible.then(|| f64::from_bits(value.to_bits() & !MANTISSA))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_powers_of_two() {
        assert_eq!(power_of_two_below(0.038), Some(0.03125));
        assert_eq!(power_of_two_below(1.0), Some(1.0));
        assert_eq!(power_of_two_below(7.9), Some(4.0));
        for senseless in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300, 1e-300] {
            assert_eq!(power_of_two_below(senseless), None);
        }
    }
}
