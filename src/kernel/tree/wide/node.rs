//! Nodes and leaves of a wide tree as they lie in an image, each kind in a section of its own and
//! both in depth-first order, so that a subtree is one range of each.
//!
//! Lengths are in the image's unit and relative to its origin, as in [`super::super::node`].

use bytemuck::{Pod, Zeroable};

use crate::geometry::simd::Row;

/// Lanes of a node, and the most triangles of a leaf.
pub const WIDTH: usize = 8;

/// Nodes, and leaves, of an image: [`Slot`]s of all lanes have to fit into 32 bits.
pub const MOST: usize = 1 << 28;

/// A node's lane: node times [`WIDTH`] plus lane.
pub type Slot = u32;

/// Some lanes of a node: what a descent starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    pub node: u32,
    /// Lane i in bit i.
    pub bits: u32,
}

impl Part {
    /// A node of a binary tree has one lane.
    pub const FIRST: Self = Self { node: 0, bits: 1 };

    /// That many lanes from a slot on.
    pub fn new(slot: Slot, lanes: u32) -> Self {
        let (node, from) = (slot / WIDTH as u32, slot % WIDTH as u32);
        Self { node, bits: ((1 << lanes) - 1) << from }
    }

    #[inline(always)]
    pub fn lanes(self) -> impl Iterator<Item = u32> {
        (0..WIDTH as u32).filter(move |lane| self.bits >> lane & 1 != 0)
    }

    #[inline(always)]
    pub fn slot(self, lane: u32) -> Slot {
        self.node * WIDTH as u32 + lane
    }

    #[inline(always)]
    pub fn is_whole(self, node: &WideNode) -> bool {
        self.bits == (1 << node.lanes()) - 1
    }
}

/// Eight boxes along the mesh's axes: lane i holds `center + s`, `|s_k| <= half[k][i]`.
///
/// Lanes in use come first. The others have no child, and numbers that no comparison is true for.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct WideNode {
    pub center: [Row; 3],
    pub half: [Row; 3],
    pub child: [WideChild; WIDTH],
    /// Half the surface of each box: the larger of two is opened.
    pub area: Row,
}

const _: () = assert!(size_of::<WideNode>() == 256 && align_of::<WideNode>() == 64);

impl WideNode {
    pub const EMPTY: Self = Self {
        center: [[f32::NAN; WIDTH]; 3],
        half: [[f32::NAN; WIDTH]; 3],
        child: [WideChild::NONE; WIDTH],
        area: [0.0; WIDTH],
    };

    pub fn lanes(&self) -> usize {
        self.child.iter().take_while(|child| **child != WideChild::NONE).count()
    }
}

/// A node or a leaf by its number, and how far below in a binary tree it lies: the wide tree is a
/// binary one with levels left out.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct WideChild(u32);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Below {
    Leaf(u32),
    Node(u32),
}

impl WideChild {
    pub const NONE: Self = Self(u32::MAX);
    pub const LEAF: u32 = 1 << 31;
    pub const INDEX: u32 = MOST as u32 - 1;

    /// `levels`: 1 to 7 binary levels below the node.
    pub fn new(below: Below, levels: u32) -> Self {
        assert!((1..WIDTH as u32).contains(&levels), "a node holds seven binary ones");
        let (flag, index) = match below {
            Below::Leaf(index) => (Self::LEAF, index),
            Below::Node(index) => (0, index),
        };
        assert!((index as usize) < MOST, "a tree has fewer than 2^28 nodes and leaves");
        Self(flag | (levels - 1) << 28 | index)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    #[inline(always)]
    pub fn index(self) -> u32 {
        self.0 & Self::INDEX
    }

    #[inline(always)]
    pub fn below(self) -> Below {
        if self.is_leaf() { Below::Leaf(self.index()) } else { Below::Node(self.index()) }
    }

    pub fn levels(self) -> u32 {
        (self.0 >> 28 & 7) + 1
    }
}

/// Box of a leaf, turned to fit: holds `center + sum_i s_i axes[i]` for `|s_i| <= half[i]`; `axes`
/// are orthonormal to within [`super::super::node::AXES_TOLERANCE`].
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LeafBox {
    pub axes: [[f32; 3]; 3],
    pub center: [f32; 3],
    pub half: [f32; 3],
    /// Rank of its first triangle; those of one leaf follow each other.
    pub first: u32,
}

const _: () = assert!(size_of::<LeafBox>() == 64 && align_of::<LeafBox>() == 64);

/// Vertices of up to eight triangles in the frame of their [`LeafBox`], and the triangles' numbers
/// in the mesh file. What is not used is no number.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LeafRows {
    /// For each axis the first corners of all triangles, then the second: a vector of sixteen.
    pub first_two: [[f32; 2 * WIDTH]; 3],
    pub third: [Row; 3],
    pub ids: [u32; WIDTH],
}

const _: () = assert!(size_of::<LeafRows>() == 320 && align_of::<LeafRows>() == 64);

impl LeafRows {
    pub const EMPTY: Self = Self {
        first_two: [[f32::NAN; 2 * WIDTH]; 3],
        third: [[f32::NAN; WIDTH]; 3],
        ids: [u32::MAX; WIDTH],
    };
}
