use crate::geometry::{Point, Triangle};

/// The point p + (q - p) d(p) / (d(p) - d(q)) where the segment from `p` to `q` crosses a plane,
/// or a line that lies in one plane with it; d is the signed volume or area of what crosses and a
/// point, and has opposite signs, not zero, at `p` and `q`.
#[derive(Clone, Copy)]
pub struct Crossing<'a> {
    pub ends: [&'a Point; 2],
    pub divider: Divider<'a>,
}

#[derive(Clone, Copy)]
pub enum Divider<'a> {
    /// The plane of a triangle that has one.
    Plane(&'a Triangle),
    /// The line through two points, seen along an axis: what the other two axes show of it.
    Line([&'a Point; 2], [usize; 2]),
}

/// Where a corner lies.
#[derive(Clone, Copy)]
pub enum Place<'a> {
    Vertex(&'a Point),
    Crossing(Crossing<'a>),
}
