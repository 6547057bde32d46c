//! How far the contact points of a level of accuracy are from the true ones.

use crate::geometry::contact::{certified, plain_f32, plain_f64};
use crate::geometry::{Point, Pose, TriangleTest};
use crate::tree::ByNumber;
use crate::tree::descent::Pair;

/// Of one pair that intersects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactError {
    /// In metres: the Hausdorff distance of the contact points that plain floating point of that
    /// width has, a point or the corners of a segment or polygon, from the true ones, which are
    /// certified to nanometres and less; of exact answers the certified bound.
    Distance(f64),
    /// Plain floating point has no contact point, or one that is no number.
    NoContact,
}

impl ContactError {
    /// `None` for boxes, which have no contact points, and for triangles that are apart.
    pub fn of(
        test: TriangleTest,
        [fixed, moving]: &[ByNumber<'_>; 2],
        pose: &Pose,
        [i, j]: Pair,
    ) -> Option<Self> {
        let a = fixed.triangle(i);
        let b = moving.triangle(j).map(|p| pose.apply(p));
        let plain = match test {
            TriangleTest::Boxes => return None,
            TriangleTest::Exact => return Some(Self::Distance(certified(&a, &b)?.error())),
            TriangleTest::F32 => plain_f32(&a, &b),
            TriangleTest::F64 => plain_f64(&a, &b),
        };
        let truth = certified(&a, &b)?;
        let off = plain.map(|plain| hausdorff(plain.points(), truth.corners()));
        Some(off.filter(|off| off.is_finite()).map_or(Self::NoContact, Self::Distance))
    }
}

/// The greatest distance of a point of either set from the nearest of the other, infinite if one has
/// a point that is no number.
fn hausdorff(a: &[Point], b: &[Point]) -> f64 {
    one_sided(a, b).max(one_sided(b, a))
}

fn one_sided(from: &[Point], to: &[Point]) -> f64 {
    let nearest = |p: &Point| to.iter().map(|q| distance(p, q)).fold(f64::INFINITY, f64::min);
    from.iter().map(nearest).fold(0.0, f64::max)
}

fn distance(p: &Point, q: &Point) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|k| p[k] - q[k]);
    (x * x + y * y + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_that_is_lost_is_as_far_off_as_one_that_is_not_there() {
        let ends = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0]];
        assert_eq!(hausdorff(&ends, &ends), 0.0);
        assert_eq!([hausdorff(&ends[..1], &ends), hausdorff(&ends, &ends[..1])], [5.0; 2]);
        assert_eq!(hausdorff(&[ends[0], [f64::NAN; 3]], &ends), f64::INFINITY);
    }
}
