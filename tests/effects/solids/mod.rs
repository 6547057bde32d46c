//! Containment, volume of overlap and penetration of closed meshes.

mod inside;
mod penetration;
mod shapes;
mod volume;
