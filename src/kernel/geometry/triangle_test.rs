//! How closely two triangles are looked at: exactly, or as engines do that are content with less.

use super::boxes::bounds;
use super::predicates::{Certain, FaceValue, StageCounter, StaticFilter};
use super::triangle::{intersect_by, triangles_intersect};
use super::{Point, Triangle};

/// What it takes for two triangles to be a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TriangleTest {
    /// Their boxes meet: never misses a pair.
    Boxes,
    /// Guigue & Devillers' test in plain 32-bit floating point, each sign at face value.
    ///
    /// Coordinates are taken relative to the triangles' surroundings before they are rounded, which
    /// is kinder than what an engine does that keeps whole scenes in 32 bits. What rounding does
    /// depends on the instruction set and the kind of tree.
    F32,
    /// The same in plain 64-bit floating point, on the placed vertices as they are.
    F64,
    /// The closed triangles share a point: [`triangles_intersect`].
    #[default]
    Exact,
}

impl TriangleTest {
    /// From the coarsest to exact.
    pub const ALL: [Self; 4] = [Self::Boxes, Self::F32, Self::F64, Self::Exact];
}

/// A [`TriangleTest`] ready for the triangles of one pose.
#[derive(Clone, Copy, Debug)]
pub enum PreparedTest<'a> {
    Exact(StaticFilter),
    /// Exact, and counts which stage of the predicates decides each sign.
    Counted(StaticFilter, &'a StageCounter),
    F64,
    F32,
    Boxes,
}

impl<'a> PreparedTest<'a> {
    /// `filter` holds for the vertices of every two triangles that will be tested. A counter is for
    /// the exact test only.
    pub fn new(
        test: TriangleTest,
        filter: StaticFilter,
        counter: Option<&'a StageCounter>,
    ) -> Self {
        match (test, counter) {
            (TriangleTest::Exact, None) => Self::Exact(filter),
            (TriangleTest::Exact, Some(counter)) => Self::Counted(filter, counter),
            (TriangleTest::F64, _) => Self::F64,
            (TriangleTest::F32, _) => Self::F32,
            (TriangleTest::Boxes, _) => Self::Boxes,
        }
    }

    #[inline]
    pub fn intersect(&self, a: &Triangle, b: &Triangle) -> bool {
        match self {
            Self::Exact(filter) => triangles_intersect(a, b, filter),
            Self::F64 => in_f64(a, b),
            Self::F32 => in_f32(a, b),
            Self::Boxes => boxes_meet(a, b),
            Self::Counted(filter, counter) => counted(a, b, filter, counter),
        }
    }
}

#[inline(never)]
fn in_f64(a: &Triangle, b: &Triangle) -> bool {
    intersect_by(a, b, FaceValue::<f64>::default())
}

/// Coordinates relative to the first vertex.
#[inline(never)]
fn in_f32(a: &Triangle, b: &Triangle) -> bool {
    let origin = a[0];
    let near = |t: &Triangle| t.map(|p| [0, 1, 2].map(|k| (p[k] - origin[k]) as f32));
    intersect_by(&near(a), &near(b), FaceValue::<f32>::default())
}

/// Boxes along the axes.
#[inline(never)]
fn boxes_meet(a: &Triangle, b: &Triangle) -> bool {
    let [(a_low, a_high), (b_low, b_high)]: [(Point, Point); 2] = [bounds(a), bounds(b)];
    (0..3).all(|k| a_low[k] <= b_high[k] && b_low[k] <= a_high[k])
}

#[inline(never)]
fn counted(a: &Triangle, b: &Triangle, filter: &StaticFilter, counter: &StageCounter) -> bool {
    intersect_by(a, b, Certain::told_to(filter, counter))
}
