//! Nodes as they lie in an image: depth first, left child next, right child by relative offset.
//!
//! Lengths are in the image's unit and relative to its origin ([`super::image::Header`]), so that
//! 32-bit numbers are fine enough however large, small or far from zero the mesh is.

use bytemuck::{Pod, Zeroable};

use crate::geometry::Point;

/// A leaf's triangle (its rank from left to right), or how far ahead the right child is.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Link(u32);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Child {
    Leaf { rank: u32 },
    Inner { right: u32 },
}

const LEAF: u32 = 1 << 31;

impl Link {
    pub fn leaf(rank: u32) -> Self {
        Self(LEAF | rank)
    }

    pub fn inner(right: u32) -> Self {
        Self(right)
    }

    #[inline]
    pub fn child(self) -> Child {
        if self.0 & LEAF == 0 {
            Child::Inner { right: self.0 }
        } else {
            Child::Leaf { rank: self.0 & !LEAF }
        }
    }
}

/// Contains `center + sum_i s_i axes[i]` for `|s_i| <= half[i]`; `axes` are orthonormal to within
/// [`AXES_TOLERANCE`].
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct ObbNode {
    pub center: [f32; 3],
    pub half: [f32; 3],
    pub axes: [[f32; 3]; 3],
    pub link: Link,
}

const _: () = assert!(size_of::<ObbNode>() == 64 && align_of::<ObbNode>() == 64);

/// Contains `center + s` for `|s_i| <= half[i]`.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct AabbNode {
    pub center: [f32; 3],
    pub half: [f32; 3],
    pub link: Link,
    pub reserved: u32,
}

const _: () = assert!(size_of::<AabbNode>() == 32 && align_of::<AabbNode>() == 32);

/// Bound on the norm of `U^T U - I` for the axes `U` of an [`ObbNode`]: rounding nine components
/// of at most 1 to 32 bits moves the matrix by at most 3 * 2^-25 in norm, its square by twice that.
pub const AXES_TOLERANCE: f64 = 2.5e-7;

/// A node of either kind, as the builder makes it and the descent reads it.
pub trait Node: Pod + Send + Sync {
    /// The box around `axes` rows; `half` in 64 bits, rounded up here.
    fn new(center: [f32; 3], half: Point, axes: &[[f32; 3]; 3], link: Link) -> Self;
    fn link(&self) -> Link;
    fn half(&self) -> Point;
}

#[inline(always)]
pub fn widen(v: [f32; 3]) -> Point {
    [f64::from(v[0]), f64::from(v[1]), f64::from(v[2])]
}

/// To 32 bits and never down: nearest rounding loses at most 2^-24 of a normal number, and what a
/// subnormal one loses is far below the descent's absolute slack.
pub(super) fn round_up(v: Point) -> [f32; 3] {
    v.map(|x| (x * (1.0 + 1e-6)) as f32)
}

impl Node for ObbNode {
    fn new(center: [f32; 3], half: Point, axes: &[[f32; 3]; 3], link: Link) -> Self {
        Self { center, half: round_up(half), axes: *axes, link }
    }

    #[inline]
    fn link(&self) -> Link {
        self.link
    }

    #[inline]
    fn half(&self) -> Point {
        widen(self.half)
    }
}

impl Node for AabbNode {
    fn new(center: [f32; 3], half: Point, _axes: &[[f32; 3]; 3], link: Link) -> Self {
        Self { center, half: round_up(half), link, reserved: 0 }
    }

    #[inline]
    fn link(&self) -> Link {
        self.link
    }

    #[inline]
    fn half(&self) -> Point {
        widen(self.half)
    }
}
