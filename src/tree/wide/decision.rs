//! What 32 bits say about triangles of two leaves whose boxes meet: only what is certain, or less.

use super::face_value;
use super::triangles::{self, Faced};
use crate::geometry::TriangleTest;
use crate::geometry::simd::Lanes;

pub trait Decision: Copy {
    /// Only what is certain.
    const CERTAIN: Self;

    /// Of a vector of pairs, those of `valid` that meet, and those that the outcome's test has to
    /// decide. `pairs`: which triangle of either leaf.
    fn decide<L: Lanes>(self, l: L, faced: &Faced, pairs: [L::U; 2], valid: u32) -> [u32; 2];
}

/// What is left open is decided by the test for it.
#[derive(Clone, Copy, Debug)]
pub struct Certain;

impl Decision for Certain {
    const CERTAIN: Self = Self;

    #[inline(always)]
    fn decide<L: Lanes>(self, l: L, faced: &Faced, pairs: [L::U; 2], valid: u32) -> [u32; 2] {
        let [a, b] = faced.sides(l, pairs);
        triangles::decide(l, &a, &b, &faced.bounds(l, pairs), valid)
    }
}

/// Any of them, chosen while the program runs: one kernel for all that are not exact, and one in
/// plain Rust for all.
#[derive(Clone, Copy, Debug)]
pub enum Chosen {
    Certain,
    FaceValue,
    /// All whose boxes meet.
    Boxes,
}

impl Chosen {
    pub fn of(test: TriangleTest) -> Self {
        match test {
            TriangleTest::Boxes => Self::Boxes,
            TriangleTest::F32 => Self::FaceValue,
            // What is certain is what plain 64 bits find as well: see `Bounds`, beside which their
            // own errors are nothing.
            TriangleTest::F64 | TriangleTest::Exact => Self::Certain,
        }
    }
}

impl From<Certain> for Chosen {
    fn from(Certain: Certain) -> Self {
        Self::Certain
    }
}

impl Decision for Chosen {
    const CERTAIN: Self = Self::Certain;

    #[inline(always)]
    fn decide<L: Lanes>(self, l: L, faced: &Faced, pairs: [L::U; 2], valid: u32) -> [u32; 2] {
        match self {
            Self::Certain => Certain.decide(l, faced, pairs, valid),
            Self::FaceValue => {
                let [a, b] = faced.sides(l, pairs);
                face_value::decide(l, &a, &b, valid)
            }
            Self::Boxes => [valid, 0],
        }
    }
}
