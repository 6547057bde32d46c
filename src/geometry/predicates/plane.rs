use std::cmp::Ordering;

use super::{StaticFilter, cross, dot, orient3d_exact, sub};
use crate::geometry::{Point, Triangle};

/// The plane of a triangle, its rounded normal made once for several
/// [`orient3d`](super::orient3d) signs.
pub struct Plane<'a> {
    corners: &'a Triangle,
    normal: Point,
}

/// Where three points lie from a plane: bit i stands for point i.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sides {
    pub above: u8,
    pub below: u8,
}

impl Sides {
    pub const ALL: u8 = 0b111;
    pub const ON_PLANE: Self = Self { above: 0, below: 0 };

    /// All three above, or all three below.
    #[inline]
    pub fn strictly_one(self) -> bool {
        (self.above == Self::ALL) | (self.below == Self::ALL)
    }
}

impl<'a> Plane<'a> {
    #[inline]
    pub fn through(corners: &'a Triangle) -> Self {
        let [a, b, c] = corners;
        Self { corners, normal: cross(sub(b, a), sub(c, a)) }
    }

    /// The signs of `orient3d` of the plane's triangle and each point: `Greater` is above. All
    /// points are on the plane if the triangle is degenerate.
    #[inline]
    pub fn sides(&self, points: &Triangle, filter: &StaticFilter) -> Sides {
        let determinants = points.each_ref().map(|p| dot(self.normal, sub(p, &self.corners[0])));
        // Without branches, as there is nothing in the signs for the processor to foresee.
        let mask = |bits: [bool; 3]| bits[0] as u8 | (bits[1] as u8) << 1 | (bits[2] as u8) << 2;
        let sides = Sides {
            above: mask(determinants.map(|d| filter.is_positive(d))),
            below: mask(determinants.map(|d| filter.is_negative(d))),
        };
        if sides.above | sides.below == Sides::ALL { sides } else { self.settle(points, sides) }
    }

    /// The sides that the filter has left open.
    #[cold]
    #[inline(never)]
    fn settle(&self, points: &Triangle, mut sides: Sides) -> Sides {
        let [a, b, c] = self.corners;
        for (i, point) in points.iter().enumerate() {
            let bit = 1 << i;
            if (sides.above | sides.below) & bit == 0 {
                match orient3d_exact([a, b, c, point]) {
                    Ordering::Greater => sides.above |= bit,
                    Ordering::Less => sides.below |= bit,
                    Ordering::Equal => {}
                }
            }
        }
        sides
    }
}
