//! How far a part that is inside has to go to reach the surface round it.

use nalgebra::Vector3;

use super::{Nesting, OutOfRange};
use crate::geometry::{Point, Pose, Triangle};
use crate::mesh::closed::Shells;

impl Nesting {
    /// A distance that the moving mesh can go along `direction`, a unit vector, with some part all
    /// the way inside the other mesh, or on its surface at the end: the greatest of those that
    /// single vertices show, in plain f64. `None`: no part is inside.
    pub fn way_out(
        &mut self,
        fixed: &Shells,
        moving: &Shells,
        pose: &Pose,
        direction: &Point,
    ) -> Result<Option<f64>, OutOfRange> {
        self.keep_inside(fixed, moving, pose)?;
        let Self { placed, probes: [of_fixed, of_moving], .. } = self;
        let backward = direction.map(|c| -c);
        let ways = of_moving
            .iter()
            .map(|probe| way_to_surface(probe, direction, fixed, fixed.points()))
            .chain(of_fixed.iter().map(|probe| way_to_surface(probe, &backward, moving, placed)));
        Ok(ways.reduce(f64::max))
    }
}

/// Zero if the surface is not met, as only rounding can make of a point inside.
fn way_to_surface(from: &Point, direction: &Point, shells: &Shells, placed: &[Point]) -> f64 {
    let closed = shells.parts().iter().filter(|part| part.is_closed());
    let triangles = closed
        .flat_map(|part| shells.faces(part))
        .map(|face| face.map(|corner| placed[corner as usize]));
    let hits = triangles.filter_map(|triangle| hit(from, direction, &triangle));
    hits.reduce(f64::min).unwrap_or(0.0)
}

/// Where a ray meets a triangle, its edges widened a little so that none slips through between two
/// (Möller & Trumbore 1997).
fn hit(from: &Point, direction: &Point, triangle: &Triangle) -> Option<f64> {
    const SLACK: f64 = 1e-9;
    let [from, direction] = [*from, *direction].map(Vector3::from);
    let [a, b, c] = triangle.map(Vector3::from);
    let (ab, ac, to) = (b - a, c - a, from - a);
    let across = direction.cross(&ac);
    let turned = to.cross(&ab);
    let [v, w, distance] = [to.dot(&across), direction.dot(&turned), ac.dot(&turned)]
        .map(|volume| volume / ab.dot(&across));
    let meets = v >= -SLACK && w >= -SLACK && v + w <= 1.0 + SLACK && distance >= 0.0;
    // Divided by zero, they are no finite numbers.
    (meets && distance.is_finite()).then_some(distance)
}
