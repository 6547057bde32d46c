//! Containment, volume of overlap and penetration of closed meshes.

mod inside;
mod on_trees;
mod penetration;
mod shapes;
mod volume;
