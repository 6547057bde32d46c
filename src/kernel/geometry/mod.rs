//! Values in, values out: poses, boxes, exact predicates, and the triangle-triangle test.

pub mod boxes;
pub mod contact;
pub mod continuous;
mod coplanar;
pub mod distance;
pub mod motion;
pub mod pose;
pub mod predicates;
pub mod simd;
pub mod triangle;
pub mod triangle_test;

pub use pose::{Pose, PoseError};
pub use triangle_test::TriangleTest;

/// A point or vector, in metres unless said otherwise.
pub type Point = [f64; 3];

/// Three vertices; degenerate triangles are legal and mean a closed segment or a point.
pub type Triangle = [Point; 3];
