//! The tree as relocatable bytes: what is published in shared memory, kept in the cache file and
//! read by the kernel. Offsets, no pointers; native (little-endian) numbers.
//!
//! ```text
//! Header | nodes, depth first | triangles, left to right | vertices, in order of first use
//! ```
//!
//! A wide tree has its leaves' boxes and rows of triangles between its nodes and the triangles.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use xxhash_rust::xxh3::xxh3_64;

use super::node::{AabbNode, Child, Node, ObbNode};
use super::wide::{self, LeafBox, LeafRows, WideNode};
use super::{BuildOptions, TreeKind};
use crate::geometry::boxes::bounds;
use crate::geometry::{Point, Triangle};

pub const MAGIC: [u8; 8] = *b"bumptree";

/// Grows with every change of the bytes' meaning.
pub const FORMAT_VERSION: u32 = 3;

#[cfg(not(target_endian = "little"))]
compile_error!("tree images are little-endian");

/// Unit of length and alignment of an image.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Block(pub [u8; 64]);

impl Block {
    /// At most 64 bytes, and zeros after them.
    fn padded(bytes: &[u8]) -> Self {
        let mut block = Self::zeroed();
        block.0[..bytes.len()].copy_from_slice(bytes);
        block
    }
}

#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Header {
    pub magic: [u8; 8],
    pub format_version: u32,
    /// [`TreeKind`] as a number.
    pub kind: u32,
    /// Of the whole image.
    pub byte_length: u64,
    /// XXH3 of all that follows this field.
    pub content_hash: u64,
    /// [`crate::mesh::TriangleMesh::content_hash`] of what it was built from.
    pub mesh_hash: u64,
    /// Byte offsets from the start of the image.
    pub nodes_at: u64,
    pub leaf_boxes_at: u64,
    pub leaf_rows_at: u64,
    pub triangles_at: u64,
    pub vertices_at: u64,
    pub node_count: u32,
    pub triangle_count: u32,
    pub vertex_count: u32,
    /// Of a wide tree, otherwise 0.
    pub leaf_count: u32,
    /// Node coordinates are `(metres - origin) / unit`; `unit` is a power of two.
    pub origin: Point,
    pub unit: f64,
    /// Bounds of the vertices in metres.
    pub low: Point,
    pub high: Point,
    /// No leaf's box is longer than this, in node coordinates.
    pub leaf_diameter: f64,
    pub reserved: u64,
}

const _: () = assert!(size_of::<Header>() == 192 && align_of::<Header>() == 64);

const HASHED_FROM: usize = std::mem::offset_of!(Header, mesh_hash);

/// A leaf's triangle: vertices by their number in the image, and its number in the mesh file.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct LeafTriangle {
    pub vertices: [u32; 3],
    pub id: u32,
}

const _: () = assert!(size_of::<LeafTriangle>() == 16);

#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImageError {
    #[error("not a tree image (it does not start with the magic number)")]
    Magic,
    #[error("tree image of format version {found}, this program reads {FORMAT_VERSION}")]
    Version { found: u32 },
    #[error("tree image of {found} bytes whose header promises {promised}")]
    Length { promised: u64, found: u64 },
    #[error("tree image is damaged: its hash is {found:016x}, the header promises {promised:016x}")]
    Hash { promised: u64, found: u64 },
    #[error("tree image has no tree kind number {0}")]
    Kind(u32),
    #[error("tree image is malformed: {0}")]
    Malformed(&'static str),
}

/// A tree image in memory of this process.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeImage {
    blocks: Vec<Block>,
}

/// What the builder hands over, as it will lie in the image.
pub(super) struct Parts<'a> {
    pub mesh_hash: u64,
    pub options: BuildOptions,
    pub origin: Point,
    pub unit: f64,
    pub leaf_diameter: f64,
    /// Their bytes, and how many there are.
    pub nodes: (&'a [u8], usize),
    pub leaf_boxes: &'a [LeafBox],
    pub leaf_rows: &'a [LeafRows],
    pub triangles: &'a [LeafTriangle],
    pub vertices: &'a [Point],
}

impl TreeImage {
    /// Takes bytes from outside, if they are a valid image.
    pub fn from_blocks(blocks: Vec<Block>) -> Result<Self, ImageError> {
        TreeView::new(&blocks)?;
        Ok(Self { blocks })
    }

    /// The relocatable bytes: what is published, cached and viewed.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    pub fn view(&self) -> TreeView<'_> {
        TreeView { blocks: &self.blocks }
    }

    pub(super) fn assemble(parts: &Parts<'_>) -> Self {
        let sections: [&[u8]; 5] = [
            parts.nodes.0,
            bytemuck::cast_slice(parts.leaf_boxes),
            bytemuck::cast_slice(parts.leaf_rows),
            bytemuck::cast_slice(parts.triangles),
            bytemuck::cast_slice(parts.vertices),
        ];
        let mut at = size_of::<Header>();
        let starts = sections.map(|bytes| {
            let start = at;
            at += bytes.len().next_multiple_of(64);
            start
        });
        let mut blocks = Vec::with_capacity(at / 64);
        blocks.resize(size_of::<Header>() / 64, Block::zeroed());
        for bytes in sections {
            blocks.par_extend(bytes.par_chunks(64).with_min_len(1 << 12).map(Block::padded));
        }
        let (low, high) = bounds(parts.vertices);
        let header = Header {
            magic: MAGIC,
            format_version: FORMAT_VERSION,
            kind: parts.options.kind as u32,
            byte_length: at as u64,
            content_hash: 0,
            mesh_hash: parts.mesh_hash,
            nodes_at: starts[0] as u64,
            leaf_boxes_at: starts[1] as u64,
            leaf_rows_at: starts[2] as u64,
            triangles_at: starts[3] as u64,
            vertices_at: starts[4] as u64,
            node_count: parts.nodes.1 as u32,
            triangle_count: parts.triangles.len() as u32,
            vertex_count: parts.vertices.len() as u32,
            leaf_count: parts.leaf_boxes.len() as u32,
            origin: parts.origin,
            unit: parts.unit,
            low,
            high,
            leaf_diameter: parts.leaf_diameter,
            reserved: 0,
        };
        let mut image = Self { blocks };
        image.seal(header);
        image
    }

    /// Puts the header, with the hash of all that follows it, before sections that lie where it says.
    pub(super) fn seal(&mut self, mut header: Header) {
        let image: &mut [u8] = bytemuck::cast_slice_mut(&mut self.blocks);
        image[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
        header.content_hash = xxh3_64(&image[HASHED_FROM..]);
        image[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
    }

    /// To be rewritten, and then [sealed](Self::seal).
    pub(super) fn blocks_mut(&mut self) -> &mut [Block] {
        &mut self.blocks
    }
}

/// The longest diagonal of the boxes with these half extents.
pub(super) fn longest_diagonal(halves: impl ParallelIterator<Item = Point>) -> f64 {
    let diagonal = |h: Point| 2.0 * h.iter().map(|h| h * h).sum::<f64>().sqrt();
    halves.map(diagonal).reduce(|| 0.0, f64::max)
}

/// A validated image, used in place wherever its bytes are: heap, cache file, shared memory.
#[derive(Clone, Copy, Debug)]
pub struct TreeView<'a> {
    blocks: &'a [Block],
}

impl Header {
    /// All that can be checked of it alone.
    pub(super) fn check(&self) -> Result<(), ImageError> {
        if self.magic != MAGIC {
            return Err(ImageError::Magic);
        }
        self.check_version()?;
        self.check_sections()
    }

    fn check_version(&self) -> Result<(), ImageError> {
        match self.format_version {
            FORMAT_VERSION => Ok(()),
            found => Err(ImageError::Version { found }),
        }
    }

    /// Every section is where [`TreeImage::assemble`] puts it, and they fill the image.
    fn check_sections(&self) -> Result<(), ImageError> {
        let node_size = match self.kind {
            kind if kind == TreeKind::Obb as u32 => size_of::<ObbNode>(),
            kind if kind == TreeKind::Aabb as u32 => size_of::<AabbNode>(),
            kind if kind == TreeKind::Wide as u32 => size_of::<WideNode>(),
            kind => return Err(ImageError::Kind(kind)),
        };
        let mut at = size_of::<Header>() as u64;
        for (start, count, size) in [
            (self.nodes_at, self.node_count, node_size),
            (self.leaf_boxes_at, self.leaf_count, size_of::<LeafBox>()),
            (self.leaf_rows_at, self.leaf_count, size_of::<LeafRows>()),
            (self.triangles_at, self.triangle_count, size_of::<LeafTriangle>()),
            (self.vertices_at, self.vertex_count, size_of::<Point>()),
        ] {
            if start != at {
                return Err(ImageError::Malformed("a section is not where it should be"));
            }
            at += (u64::from(count) * size as u64).next_multiple_of(64);
        }
        if at != self.byte_length {
            return Err(ImageError::Malformed("the sections do not fill the image"));
        }
        let binary = self.tree_kind() != TreeKind::Wide;
        if self.triangle_count == 0
            || binary
                && (u64::from(self.node_count) + 1 != 2 * u64::from(self.triangle_count)
                    || self.leaf_count != 0)
        {
            return Err(ImageError::Malformed("the tree does not have one triangle a leaf"));
        }
        let lengths = self.origin.iter().chain([&self.unit, &self.leaf_diameter]);
        if !is_unit(self.unit) || !lengths.into_iter().all(|x| x.is_finite()) {
            return Err(ImageError::Malformed("origin and unit are not usable"));
        }
        Ok(())
    }

    /// Once the number of the kind has been checked.
    pub(super) fn tree_kind(&self) -> TreeKind {
        match self.kind {
            kind if kind == TreeKind::Obb as u32 => TreeKind::Obb,
            kind if kind == TreeKind::Aabb as u32 => TreeKind::Aabb,
            _ => TreeKind::Wide,
        }
    }
}

impl<'a> TreeView<'a> {
    /// Of an image with a checked header of which only some subtrees are there, and checked. What
    /// starts elsewhere than in those gets no answer, or never ends.
    pub(super) fn of_partial(blocks: &'a [Block]) -> Self {
        Self { blocks }
    }

    /// Checks everything once: magic, version, length, hash, every offset and index.
    pub fn new(blocks: &'a [Block]) -> Result<Self, ImageError> {
        let view = Self { blocks };
        view.check_header()?;
        match view.kind() {
            TreeKind::Obb => check_topology(view.nodes::<ObbNode>(), 0)?,
            TreeKind::Aabb => check_topology(view.nodes::<AabbNode>(), 0)?,
            TreeKind::Wide => {
                let leaves = (view.leaf_boxes(), view.leaf_rows());
                wide::check(view.wide_nodes(), leaves, view.triangles())
                    .map_err(ImageError::Malformed)?;
            }
        }
        let vertex_count = view.header().vertex_count;
        // Of all, without a branch each: every worker asks this before its first scenario.
        let all = |all: bool, one: bool| all & one;
        let names_vertices = |t: &LeafTriangle| t.vertices.map(|v| v < vertex_count) == [true; 3];
        if !view.triangles().iter().map(names_vertices).fold(true, all) {
            return Err(ImageError::Malformed("a triangle names a vertex that is not there"));
        }
        // Whether a pose takes a vertex out of range is told by the bounds.
        let Header { low, high, .. } = view.header();
        let within =
            |v: &Point| (0..3).map(|k| (low[k] <= v[k]) & (v[k] <= high[k])).fold(true, all);
        let are_within = view.vertices().iter().map(within).fold(true, all);
        if !low.iter().chain(high).all(|c| c.is_finite()) || !are_within {
            return Err(ImageError::Malformed("a vertex is not within finite bounds"));
        }
        Ok(view)
    }

    /// Of bytes that [`TreeView::new`] has taken.
    pub(super) fn validated(blocks: &'a [Block]) -> Self {
        Self { blocks }
    }

    fn check_header(&self) -> Result<(), ImageError> {
        let bytes = self.bytes();
        if bytes.len() < size_of::<Header>() || bytes[..8] != MAGIC {
            return Err(ImageError::Magic);
        }
        let header = self.header();
        header.check_version()?;
        let found = bytes.len() as u64;
        if header.byte_length != found {
            return Err(ImageError::Length { promised: header.byte_length, found });
        }
        let found = xxh3_64(&bytes[HASHED_FROM..]);
        if header.content_hash != found {
            return Err(ImageError::Hash { promised: header.content_hash, found });
        }
        header.check_sections()
    }

    fn bytes(&self) -> &'a [u8] {
        bytemuck::cast_slice(self.blocks)
    }

    #[inline]
    pub fn header(&self) -> &'a Header {
        bytemuck::from_bytes(&self.bytes()[..size_of::<Header>()])
    }

    fn section<T: Pod>(&self, start: u64, count: u32) -> &'a [T] {
        let start = start as usize;
        bytemuck::cast_slice(&self.bytes()[start..start + count as usize * size_of::<T>()])
    }

    pub(super) fn nodes<N: Node>(&self) -> &'a [N] {
        self.section(self.header().nodes_at, self.header().node_count)
    }

    pub(super) fn wide_nodes(&self) -> &'a [WideNode] {
        self.section(self.header().nodes_at, self.header().node_count)
    }

    pub(super) fn leaf_boxes(&self) -> &'a [LeafBox] {
        self.section(self.header().leaf_boxes_at, self.header().leaf_count)
    }

    pub(super) fn leaf_rows(&self) -> &'a [LeafRows] {
        self.section(self.header().leaf_rows_at, self.header().leaf_count)
    }

    /// In the order of their leaves, left to right.
    pub fn triangles(&self) -> &'a [LeafTriangle] {
        self.section(self.header().triangles_at, self.header().triangle_count)
    }

    pub fn vertices(&self) -> &'a [Point] {
        self.section(self.header().vertices_at, self.header().vertex_count)
    }

    pub fn kind(&self) -> TreeKind {
        self.header().tree_kind()
    }

    /// Identifies the image.
    pub fn hash(&self) -> u64 {
        self.header().content_hash
    }

    pub fn triangle_count(&self) -> u32 {
        self.header().triangle_count
    }

    pub fn blocks(&self) -> &'a [Block] {
        self.blocks
    }

    /// Corners of the triangle at a leaf's rank, in metres.
    pub fn corners(&self, rank: u32) -> Triangle {
        let vertices = self.vertices();
        self.triangles()[rank as usize].vertices.map(|v| vertices[v as usize])
    }
}

/// A power of two of the range that the builder chooses from.
fn is_unit(x: f64) -> bool {
    let (least, most) = (2_f64.powi(-1000), 2_f64.powi(1023));
    (least..=most).contains(&x) && x.to_bits().trailing_zeros() >= 52
}

/// The nodes are one depth-first binary tree and its leaves are numbered from left to right.
pub(super) fn check_topology<N: Node>(nodes: &[N], first_rank: u32) -> Result<(), ImageError> {
    const BROKEN: ImageError = ImageError::Malformed("the nodes are not one depth-first tree");
    let mut ends = vec![nodes.len()];
    let mut rank = first_rank;
    for (at, node) in nodes.iter().enumerate() {
        let Some(end) = ends.pop() else { return Err(BROKEN) };
        match node.link().child() {
            Child::Leaf { rank: found } if end == at + 1 && found == rank => rank += 1,
            Child::Inner { right } if right >= 2 && at + (right as usize) < end => {
                ends.push(end);
                ends.push(at + right as usize);
            }
            _ => return Err(BROKEN),
        }
    }
    Ok(())
}
