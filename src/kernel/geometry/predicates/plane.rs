use std::cmp::Ordering;

use super::{Stage, StaticFilter, Tally, Untold, cross, dot, orient3d_exact, sub};
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

    /// Whether any is on the plane.
    #[inline]
    pub fn touch(self) -> bool {
        self.above | self.below != Self::ALL
    }

    /// From whether each point is above, and whether it is below. Without branches, as there is
    /// nothing in the signs for the processor to foresee.
    #[inline]
    pub(super) fn of(sides: [(bool, bool); 3]) -> Self {
        let mask = |bits: [bool; 3]| bits[0] as u8 | (bits[1] as u8) << 1 | (bits[2] as u8) << 2;
        Self { above: mask(sides.map(|side| side.0)), below: mask(sides.map(|side| side.1)) }
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
        self.sides_told(points, filter, Untold)
    }

    /// As [`Plane::sides`], telling the stages.
    #[inline]
    pub(super) fn sides_told<T: Tally>(
        &self,
        points: &Triangle,
        filter: &StaticFilter,
        tally: T,
    ) -> Sides {
        let determinants = points.each_ref().map(|p| dot(self.normal, sub(p, &self.corners[0])));
        let sides = Sides::of(determinants.map(|d| (filter.is_positive(d), filter.is_negative(d))));
        let decided = sides.above | sides.below;
        if decided == Sides::ALL {
            tally.decided(Stage::Filter, 3);
            return sides;
        }
        self.settle(points, sides, tally)
    }

    /// Whether the triangle lies across an axis and all points that the filter has left open are
    /// where it is on that axis: on its plane.
    #[inline]
    fn open_ones_are_on_axis_plane(&self, points: &Triangle, sides: Sides) -> bool {
        let [a, b, c] = self.corners;
        let decided = sides.above | sides.below;
        let across = |k: usize| {
            let on = Sides::of(points.each_ref().map(|p| (p[k] == a[k], false))).above;
            (a[k] == b[k]) & (a[k] == c[k]) & (on | decided == Sides::ALL)
        };
        across(0) | across(1) | across(2)
    }

    /// The sides that the filter has left open.
    #[cold]
    #[inline(never)]
    fn settle<T: Tally>(&self, points: &Triangle, mut sides: Sides, tally: T) -> Sides {
        let decided = (sides.above | sides.below).count_ones();
        tally.decided(Stage::Filter, decided);
        if self.open_ones_are_on_axis_plane(points, sides) {
            tally.decided(Stage::Structure, 3 - decided);
            return sides;
        }
        let [a, b, c] = self.corners;
        for (i, point) in points.iter().enumerate() {
            let bit = 1 << i;
            if (sides.above | sides.below) & bit == 0 {
                match orient3d_exact([a, b, c, point], tally) {
                    Ordering::Greater => sides.above |= bit,
                    Ordering::Less => sides.below |= bit,
                    Ordering::Equal => {}
                }
            }
        }
        sides
    }
}
