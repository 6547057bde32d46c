//! A level of accuracy as a number.

use super::WireError;
use crate::geometry::TriangleTest;
use crate::tree::{Accuracy, BoxDepth};

const TESTS: [TriangleTest; 4] =
    [TriangleTest::Exact, TriangleTest::F64, TriangleTest::F32, TriangleTest::Boxes];

/// From here on, and one more for each level of depth: boxes at a depth.
const BOXES_AT: u32 = TESTS.len() as u32;

pub fn encode(accuracy: Accuracy) -> u32 {
    match accuracy {
        Accuracy::Pairs(test) => {
            TESTS.iter().position(|&t| t == test).expect("all are there") as u32
        }
        Accuracy::BoxesAt(depth) => BOXES_AT + depth.get(),
    }
}

pub fn decode(code: u32) -> Result<Accuracy, WireError> {
    let test = TESTS.get(code as usize).map(|&test| Accuracy::Pairs(test));
    let at_depth = || code.checked_sub(BOXES_AT).and_then(BoxDepth::new).map(Accuracy::BoxesAt);
    let out_of_range = || WireError::Field { field: "accuracy", value: code.into() };
    test.or_else(at_depth).ok_or_else(out_of_range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_level_has_a_number_and_no_other_number_is_one() {
        let last = BOXES_AT + BoxDepth::MAX;
        for code in 0..=last {
            assert_eq!(encode(decode(code).unwrap()), code);
        }
        for code in [last + 1, u32::MAX] {
            assert!(decode(code).is_err());
        }
    }
}
