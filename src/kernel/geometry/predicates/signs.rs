//! Where the triangle-triangle test gets its signs from: never wrong, or as plain floating point
//! has them.

use std::cmp::Ordering;
use std::marker::PhantomData;
use std::ops::{Add, Mul, Sub};

use super::{
    Plane, Sides, StaticFilter, Tally, Untold, cross, dot, orient2d_told, orient3d_told, sub,
};

/// `f64` or `f32`.
pub trait Scalar:
    Copy + Default + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self>
{
}

impl Scalar for f64 {}
impl Scalar for f32 {}

/// The predicates of [`super`] for one kind of coordinates.
pub trait Signs: Copy {
    type Scalar: Scalar;

    /// As [`super::orient3d`].
    fn orient3d(
        self,
        a: &[Self::Scalar; 3],
        b: &[Self::Scalar; 3],
        c: &[Self::Scalar; 3],
        d: &[Self::Scalar; 3],
    ) -> Ordering;

    /// As [`super::orient2d`].
    fn orient2d(
        self,
        a: &[Self::Scalar; 2],
        b: &[Self::Scalar; 2],
        c: &[Self::Scalar; 2],
    ) -> Ordering;

    /// May be asked where a corner lies on the other triangle's plane: whether the two have a corner
    /// in common, which makes all other signs unnecessary.
    fn have_common_corner(self, _a: &[[Self::Scalar; 3]; 3], _b: &[[Self::Scalar; 3]; 3]) -> bool {
        false
    }

    /// As [`Plane::sides`].
    fn sides(self, plane: &[[Self::Scalar; 3]; 3], points: &[[Self::Scalar; 3]; 3]) -> Sides;
}

/// Never wrong, as long as the filter holds for the points.
#[derive(Clone, Copy, Debug)]
pub struct Certain<'a, T> {
    filter: &'a StaticFilter,
    tally: T,
}

impl<'a> Certain<'a, Untold> {
    #[inline]
    pub fn new(filter: &'a StaticFilter) -> Self {
        Self { filter, tally: Untold }
    }
}

impl<'a, T: Tally> Certain<'a, T> {
    pub fn told_to(filter: &'a StaticFilter, tally: T) -> Self {
        Self { filter, tally }
    }
}

impl<T: Tally> Signs for Certain<'_, T> {
    type Scalar = f64;

    #[inline]
    fn orient3d(self, a: &[f64; 3], b: &[f64; 3], c: &[f64; 3], d: &[f64; 3]) -> Ordering {
        orient3d_told(a, b, c, d, self.filter, self.tally)
    }

    #[inline]
    fn orient2d(self, a: &[f64; 2], b: &[f64; 2], c: &[f64; 2]) -> Ordering {
        orient2d_told(a, b, c, self.tally)
    }

    #[inline]
    fn have_common_corner(self, a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> bool {
        // All nine, without a branch each.
        let equal = |p: &[f64; 3], q: &[f64; 3]| (p[0] == q[0]) & (p[1] == q[1]) & (p[2] == q[2]);
        a.iter().fold(false, |any, p| any | equal(p, &b[0]) | equal(p, &b[1]) | equal(p, &b[2]))
    }

    #[inline]
    fn sides(self, plane: &[[f64; 3]; 3], points: &[[f64; 3]; 3]) -> Sides {
        Plane::through(plane).sides_told(points, self.filter, self.tally)
    }
}

/// The rounded determinant's sign at face value, as engines without exact arithmetic have it. What
/// is no number, as after an overflow, counts as zero; not so in the 32-bit kernel of wide trees, which
/// has a test of its own.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaceValue<S>(PhantomData<S>);

fn sign<S: Scalar>(determinant: S) -> Ordering {
    determinant.partial_cmp(&S::default()).unwrap_or(Ordering::Equal)
}

impl<S: Scalar> Signs for FaceValue<S> {
    type Scalar = S;

    #[inline]
    fn orient3d(self, a: &[S; 3], b: &[S; 3], c: &[S; 3], d: &[S; 3]) -> Ordering {
        sign(dot(cross(sub(b, a), sub(c, a)), sub(d, a)))
    }

    #[inline]
    fn orient2d(self, a: &[S; 2], b: &[S; 2], c: &[S; 2]) -> Ordering {
        sign((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    }

    #[inline]
    fn sides(self, [a, b, c]: &[[S; 3]; 3], points: &[[S; 3]; 3]) -> Sides {
        let normal = cross(sub(b, a), sub(c, a));
        let determinants = points.each_ref().map(|p| dot(normal, sub(p, a)));
        Sides::of(determinants.map(|d| (d > S::default(), d < S::default())))
    }
}
