//! What bumper computes, without how it is spread: meshes, their trees, and exactly where they touch.
//!
//! A package of its own, so that it is compiled for speed whatever the rest is compiled for.

pub mod effects;
pub mod geometry;
pub mod mesh;
pub mod tree;
