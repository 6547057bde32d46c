//! What 32 bits say about triangles of two leaves whose boxes meet: only what is certain, or less, or
//! nothing.

use super::face_value;
use super::triangles::{self, Faced};
use crate::geometry::TriangleTest;
use crate::geometry::simd::Lanes;
use crate::tree::placement::Placement;

pub trait Decision: Copy {
    /// Only what is certain.
    const CERTAIN: Self;

    /// Of a vector of pairs, those of `valid` that meet, and those that the outcome's test has to
    /// decide. `pairs`: which triangle of either leaf.
    fn decide<L: Lanes>(self, l: L, faced: &Faced, pairs: [L::U; 2], valid: u32) -> [u32; 2];
}

/// What is left open is decided by the test for it.
#[derive(Clone, Copy, Debug)]
pub struct OnlyCertain;

impl Decision for OnlyCertain {
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
    OnlyCertain,
    /// All left open.
    Nothing,
    FaceValue,
    /// All whose boxes meet.
    Boxes,
}

impl Chosen {
    pub fn of(test: TriangleTest, placement: &Placement) -> Self {
        match test {
            TriangleTest::Boxes => Self::Boxes,
            TriangleTest::F32 => Self::FaceValue,
            // What is certain is what plain 64 bits find as well, whose own rounding is nothing
            // beside `Bounds`, unless they leave their range.
            TriangleTest::F64 if !placement.suits_plain_f64() => Self::Nothing,
            TriangleTest::F64 | TriangleTest::Exact => Self::OnlyCertain,
        }
    }
}

impl From<OnlyCertain> for Chosen {
    fn from(OnlyCertain: OnlyCertain) -> Self {
        Self::OnlyCertain
    }
}

impl Decision for Chosen {
    const CERTAIN: Self = Self::OnlyCertain;

    #[inline(always)]
    fn decide<L: Lanes>(self, l: L, faced: &Faced, pairs: [L::U; 2], valid: u32) -> [u32; 2] {
        match self {
            Self::OnlyCertain => OnlyCertain.decide(l, faced, pairs, valid),
            Self::Nothing => [0, valid],
            Self::FaceValue => {
                let [a, b] = faced.sides(l, pairs);
                face_value::decide(l, &a, &b, valid)
            }
            Self::Boxes => [valid, 0],
        }
    }
}
