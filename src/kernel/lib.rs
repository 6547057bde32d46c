//! What bumper computes, without how it is spread: meshes, their trees, and exactly where they touch.
//!
//! A package of its own, so that it is compiled for speed whatever the rest is compiled for. That takes
//! long: so its unit tests are of what goes without a descent, whose kernels would be compiled for them
//! once more, and all that descends trees is tested from `tests/`.

pub mod effects;
pub mod geometry;
pub mod mesh;
pub mod tree;
