//! A tree for a mesh whose vertices have moved and whose faces have not: every box is drawn anew
//! around what it held, and what is in which box stays.
//!
//! The answers are those of a tree that is built. It is slower to descend the further the mesh has
//! gone from the one that its tree was built for.

#[cfg(test)]
mod tests;

use std::ops::Range;

use rayon::prelude::*;

use super::build::Orient;
use super::fit::{Axes, IDENTITY, fit_all};
use super::image::{Header, longest_diagonal};
use super::node::{AabbNode, Child, Node, ObbNode, widen};
use super::wide::{self, LeafBox, LeafRows};
use super::{Block, LeafTriangle, TreeImage, TreeKind, TreeView, frame_around};
use crate::geometry::boxes::bounds;
use crate::geometry::{Point, Triangle};
use crate::mesh::TriangleMesh;

#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RefitError {
    #[error("the tree has {tree} triangles and the mesh {mesh}; refit the tree of the same faces")]
    Triangles { tree: u32, mesh: usize },
    #[error(
        "triangle {0} joins other vertices than when its tree was built; only vertices may have \
         moved, so build a new tree"
    )]
    Faces(u32),
}

/// The tree of `mesh`, which has the faces of the mesh that `tree` was built from, and its vertices
/// anywhere else.
///
/// Leaves of which no vertex has moved, and nodes above only such leaves, keep their bytes, as long as
/// the mesh stays in the frame of the image ([`Header::origin`]) and does not shrink below a quarter
/// of it. The same bytes on any number of cores.
pub fn refit(tree: &TreeView<'_>, mesh: &TriangleMesh) -> Result<TreeImage, RefitError> {
    let (vertices, (mut blocks, mesh_hash)) = rayon::join(
        || vertices_of(tree, mesh),
        || rayon::join(|| copied(tree.blocks()), || mesh.content_hash()),
    );
    let vertices = vertices?;
    let (low, high) = bounds(&vertices);
    let before = tree.header();
    let (origin, unit) = frame(before, &low, &high);
    let moved = Moved::new(tree, &vertices, (origin, unit));
    let sections = Sections::of(&mut blocks, before);
    sections.vertices.copy_from_slice(&vertices);
    let leaf_diameter = match tree.kind() {
        TreeKind::Obb => refit_binary::<ObbNode>(sections, before.node_count, &moved),
        TreeKind::Aabb => refit_binary::<AabbNode>(sections, before.node_count, &moved),
        TreeKind::Wide => refit_wide(sections, &moved),
    };
    let header = Header { mesh_hash, origin, unit, low, high, leaf_diameter, ..*before };
    Ok(TreeImage::sealed(blocks, header))
}

/// The mesh's vertices by their numbers in the image.
fn vertices_of(tree: &TreeView<'_>, mesh: &TriangleMesh) -> Result<Vec<Point>, RefitError> {
    const UNSEEN: u32 = u32::MAX;
    let faces = mesh.faces();
    if tree.triangle_count() as usize != faces.len() {
        return Err(RefitError::Triangles { tree: tree.triangle_count(), mesh: faces.len() });
    }
    let mut in_mesh = vec![UNSEEN; tree.vertices().len()];
    for triangle in tree.triangles() {
        // The numbers of triangles in an image are not checked when it is viewed.
        let face = faces.get(triangle.id as usize).ok_or(RefitError::Faces(triangle.id))?;
        for (&vertex, &corner) in triangle.vertices.iter().zip(face) {
            let number = &mut in_mesh[vertex as usize];
            if *number == UNSEEN {
                *number = corner;
            } else if *number != corner {
                return Err(RefitError::Faces(triangle.id));
            }
        }
    }
    // What no triangle has stays where it is.
    let vertex =
        |(&number, old): (&u32, &Point)| *mesh.vertices().get(number as usize).unwrap_or(old);
    Ok(in_mesh.iter().zip(tree.vertices()).map(vertex).collect())
}

fn copied(blocks: &[Block]) -> Vec<Block> {
    blocks.par_iter().with_min_len(1 << 12).copied().collect()
}

/// The image's, if the mesh lies within [-1, 1] in it, as every bound on a rounding takes for granted,
/// and is not so small that 32-bit boxes would be coarse.
fn frame(image: &Header, low: &Point, high: &Point) -> (Point, f64) {
    const COARSE: f64 = 4.0;
    let within =
        |v: &Point| (0..3).all(|k| ((v[k] - image.origin[k]) * image.unit.recip()).abs() <= 1.0);
    let (origin, unit) = frame_around(low, high);
    if within(low) && within(high) && image.unit <= COARSE * unit {
        (image.origin, image.unit)
    } else {
        (origin, unit)
    }
}

/// Where the triangles of an image are now.
pub(super) struct Moved<'a> {
    triangles: &'a [LeafTriangle],
    vertices: &'a [Point],
    /// Of each vertex.
    has_moved: Vec<bool>,
    origin: Point,
    scale: f64,
    /// The unit of the image before, in that of today.
    pub unit_before: f64,
}

impl<'a> Moved<'a> {
    fn new(tree: &TreeView<'a>, vertices: &'a [Point], (origin, unit): (Point, f64)) -> Self {
        let Header { origin: origin_before, unit: unit_before, .. } = tree.header();
        // By their bits: the image has those of a zero's sign, too.
        let bits = |v: &Point| v.map(f64::to_bits);
        let all = bits(origin_before) != bits(&origin) || *unit_before != unit;
        let moves = |(now, before): (&Point, &Point)| all || bits(now) != bits(before);
        let has_moved = vertices.iter().zip(tree.vertices()).map(moves).collect();
        let triangles = tree.triangles();
        let unit_before = unit_before / unit;
        Self { triangles, vertices, has_moved, origin, scale: unit.recip(), unit_before }
    }

    pub fn triangle_count(&self) -> u32 {
        self.triangles.len() as u32
    }

    /// In node coordinates, by its rank.
    #[inline]
    pub fn triangle(&self, rank: u32) -> Triangle {
        let Self { origin, scale, .. } = self;
        self.triangles[rank as usize].vertices.map(|vertex| {
            let v = &self.vertices[vertex as usize];
            [(v[0] - origin[0]) * scale, (v[1] - origin[1]) * scale, (v[2] - origin[2]) * scale]
        })
    }

    /// Whether a triangle of these ranks has a vertex that has moved, or there is another frame.
    #[inline]
    pub fn any_of(&self, ranks: Range<u32>) -> bool {
        let triangles = &self.triangles[ranks.start as usize..ranks.end as usize];
        triangles.iter().any(|t| t.vertices.iter().any(|&v| self.has_moved[v as usize]))
    }
}

/// What can change of an image besides its header.
struct Sections<'a> {
    nodes: &'a mut [u8],
    leaf_boxes: &'a mut [u8],
    leaf_rows: &'a mut [u8],
    vertices: &'a mut [Point],
}

impl<'a> Sections<'a> {
    fn of(blocks: &'a mut [Block], header: &Header) -> Self {
        let mut rest: &mut [u8] = bytemuck::cast_slice_mut(blocks);
        let mut rest_at = 0;
        let mut section = |start: u64, length: usize| {
            let from = start as usize - rest_at;
            let (section, after) = std::mem::take(&mut rest)[from..].split_at_mut(length);
            (rest, rest_at) = (after, start as usize + length);
            section
        };
        let node_bytes = (header.leaf_boxes_at - header.nodes_at) as usize;
        let leaves = header.leaf_count as usize;
        Self {
            nodes: section(header.nodes_at, node_bytes),
            leaf_boxes: section(header.leaf_boxes_at, leaves * size_of::<LeafBox>()),
            leaf_rows: section(header.leaf_rows_at, leaves * size_of::<LeafRows>()),
            vertices: bytemuck::cast_slice_mut(section(
                header.vertices_at,
                header.vertex_count as usize * size_of::<Point>(),
            )),
        }
    }
}

/// The length of the longest leaf's box.
fn refit_wide(sections: Sections<'_>, moved: &Moved<'_>) -> f64 {
    let leaf_boxes = bytemuck::cast_slice_mut(sections.leaf_boxes);
    let sections = wide::Sections {
        nodes: bytemuck::cast_slice_mut(sections.nodes),
        leaf_boxes: &mut *leaf_boxes,
        leaf_rows: bytemuck::cast_slice_mut(sections.leaf_rows),
    };
    wide::refit(sections, moved);
    longest_diagonal(leaf_boxes.par_iter().map(|leaf: &LeafBox| widen(leaf.half)))
}

/// A node whose box is drawn along the axes it has.
trait Refit: Orient {
    fn own_axes(&self) -> Axes;
}

impl Refit for ObbNode {
    fn own_axes(&self) -> Axes {
        self.axes
    }
}

impl Refit for AabbNode {
    fn own_axes(&self) -> Axes {
        IDENTITY
    }
}

/// The length of the longest leaf's box.
fn refit_binary<N: Refit>(sections: Sections<'_>, node_count: u32, moved: &Moved<'_>) -> f64 {
    let nodes: &mut [N] = bytemuck::cast_slice_mut(sections.nodes);
    let nodes = &mut nodes[..node_count as usize];
    let count = moved.triangle_count();
    let triangles: Vec<Triangle> =
        (0..count).into_par_iter().map(|rank| moved.triangle(rank)).collect();
    let ranks: Vec<u32> = (0..count).collect();
    let moved_before = counted_before(moved);
    let has_moved =
        |ranks: &Range<u32>| moved_before[ranks.start as usize] != moved_before[ranks.end as usize];
    let ranges = ranges(nodes);
    nodes.par_iter_mut().zip(ranges).filter(|(_, below)| has_moved(below)).for_each(
        |(node, below)| {
            let ids = &ranks[below.start as usize..below.end as usize];
            refit_node(node, &triangles, ids, moved.unit_before);
        },
    );
    let leaf = |node: &N| matches!(node.link().child(), Child::Leaf { .. }).then(|| node.half());
    longest_diagonal(nodes.par_iter().filter_map(leaf))
}

/// Along the same axes, as long as that does not make the box much larger. `ids` follow each other.
fn refit_node<N: Refit>(node: &mut N, triangles: &[Triangle], ids: &[u32], unit_before: f64) {
    /// A box has to be that much larger for other axes to pay.
    const GROWTH: f64 = 1.5;
    let Some(&first) = ids.first() else { return };
    let own = &triangles[first as usize..][..ids.len()];
    let mut axes = node.own_axes();
    let mut fit = fit_all(own, &axes);
    if surface(&fit.half) > GROWTH * surface(&node.half().map(|h| h * unit_before)) {
        let others = N::axes(triangles, ids);
        let along_others = fit_all(own, &others);
        if surface(&along_others.half) < surface(&fit.half) {
            (axes, fit) = (others, along_others);
        }
    }
    *node = N::new(fit.center, fit.half, &axes, node.link());
}

fn surface(half: &Point) -> f64 {
    half[0] * half[1] + half[1] * half[2] + half[2] * half[0]
}

/// How many triangles of a lower rank have a vertex that has moved; of each rank, and of the end.
fn counted_before(moved: &Moved<'_>) -> Vec<u32> {
    let mut before = 0;
    let counts = (0..moved.triangle_count()).map(|rank| {
        before += u32::from(moved.any_of(rank..rank + 1));
        before
    });
    std::iter::once(0).chain(counts).collect()
}

/// The ranks of the triangles below each node: a node with n leaves is the first of 2n - 1 nodes.
fn ranges<N: Node>(nodes: &[N]) -> Vec<Range<u32>> {
    let (mut ends, mut first) = (vec![nodes.len()], 0);
    let range = |(at, node): (usize, &N)| {
        let end = ends.pop().expect("the nodes were one tree when they were viewed");
        let below = first..first + (end - at).div_ceil(2) as u32;
        match node.link().child() {
            Child::Leaf { .. } => first += 1,
            Child::Inner { right } => ends.extend([end, at + right as usize]),
        }
        below
    };
    nodes.iter().enumerate().map(range).collect()
}
