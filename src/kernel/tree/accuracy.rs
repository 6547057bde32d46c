//! How closely a scene looks at its scenarios.

use std::fmt;
use std::str::FromStr;

use super::roots::Cut;
use crate::geometry::TriangleTest;

/// From the coarsest to the one that is never wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Accuracy {
    /// `boxes(depth)`: pairs of boxes at this depth of both trees, or of leaves above it. They stand
    /// for all pairs of triangles below them: a conservative maybe.
    BoxesAt(BoxDepth),
    /// Pairs of triangles: `boxes`, `f32`, `f64` and `exact`.
    Pairs(TriangleTest),
}

/// Depth in both trees, at most [`BoxDepth::MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BoxDepth(u8);

impl BoxDepth {
    /// 16 million boxes of each tree.
    pub const MAX: u32 = 24;

    pub fn new(depth: u32) -> Option<Self> {
        (depth <= Self::MAX).then_some(Self(depth as u8))
    }

    pub fn get(self) -> u32 {
        self.0.into()
    }

    /// Whose distributed roots the boxes are.
    pub fn cut(self) -> Cut {
        Cut::Depth(self.get())
    }
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is not an accuracy: give exact, f64, f32, boxes, or boxes(D) with a tree depth D from 0 \
     to {max}",
    max = BoxDepth::MAX
)]
pub struct NotAnAccuracy(String);

impl Accuracy {
    pub const EXACT: Self = Self::Pairs(TriangleTest::Exact);
}

impl Default for Accuracy {
    fn default() -> Self {
        Self::EXACT
    }
}

impl fmt::Display for Accuracy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BoxesAt(depth) => write!(f, "boxes({})", depth.get()),
            Self::Pairs(TriangleTest::Boxes) => f.write_str("boxes"),
            Self::Pairs(TriangleTest::F32) => f.write_str("f32"),
            Self::Pairs(TriangleTest::F64) => f.write_str("f64"),
            Self::Pairs(TriangleTest::Exact) => f.write_str("exact"),
        }
    }
}

impl FromStr for Accuracy {
    type Err = NotAnAccuracy;

    fn from_str(text: &str) -> Result<Self, NotAnAccuracy> {
        let depth = || {
            let digits = text.strip_prefix("boxes(")?.strip_suffix(')')?;
            BoxDepth::new(digits.parse().ok()?).map(Self::BoxesAt)
        };
        match text {
            "boxes" => Ok(Self::Pairs(TriangleTest::Boxes)),
            "f32" => Ok(Self::Pairs(TriangleTest::F32)),
            "f64" => Ok(Self::Pairs(TriangleTest::F64)),
            "exact" => Ok(Self::EXACT),
            _ => depth().ok_or_else(|| NotAnAccuracy(text.to_owned())),
        }
    }
}

/// As text.
impl serde::Serialize for Accuracy {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_read_as_it_is_written() {
        for text in ["boxes(0)", "boxes(24)", "boxes", "f32", "f64", "exact"] {
            assert_eq!(text.parse::<Accuracy>().unwrap().to_string(), text);
        }
        assert_eq!(Accuracy::default().to_string(), "exact");
    }

    #[test]
    fn what_is_no_level_is_refused_with_all_there_are() {
        for wrong in ["", "f16", "boxes()", "boxes(25)", "boxes(-1)", "boxes(8", "Exact"] {
            let refused = wrong.parse::<Accuracy>().unwrap_err().to_string();
            assert!(refused.contains(wrong) && refused.contains("boxes(D)"), "{refused}");
        }
    }
}
