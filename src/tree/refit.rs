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

/// Makes `image` the tree of `mesh`, which has the faces of the mesh that it was built from, and its
/// vertices anywhere else. Whoever goes on using the tree as it was refits a clone.
///
/// Leaves of which no vertex has moved, and nodes above only such leaves, keep their bytes, as long as
/// the mesh stays in the frame of the image ([`Header::origin`]) and does not shrink below a quarter
/// of it. The same bytes on any number of cores. After an error the image is what it was.
pub fn refit(image: &mut TreeImage, mesh: &TriangleMesh) -> Result<(), RefitError> {
    let tree = image.view();
    let (before, kind) = (*tree.header(), tree.kind());
    let (vertices, mesh_hash) = rayon::join(|| vertices_of(&tree, mesh), || mesh.content_hash());
    let vertices = vertices?;
    let (low, high) = bounds(&vertices);
    let (origin, unit) = frame(&before, &low, &high);
    let has_moved = if (origin, unit) == (before.origin, before.unit) {
        differing(tree.vertices(), &vertices)
    } else {
        vec![true; vertices.len()]
    };
    let sections = Sections::of(image.blocks_mut(), &before);
    sections.vertices.copy_from_slice(&vertices);
    let moved = Moved {
        triangles: sections.triangles,
        vertices: normalised(vertices, origin, unit),
        has_moved,
        unit_before: before.unit / unit,
    };
    let leaf_diameter = match kind {
        TreeKind::Obb => refit_binary::<ObbNode>(sections.nodes, before.node_count, &moved),
        TreeKind::Aabb => refit_binary::<AabbNode>(sections.nodes, before.node_count, &moved),
        TreeKind::Wide => {
            refit_wide(sections.nodes, sections.leaf_boxes, sections.leaf_rows, &moved)
        }
    };
    image.seal(Header { mesh_hash, origin, unit, low, high, leaf_diameter, ..before });
    Ok(())
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

/// By their bits: an image has those of a zero's sign, too.
fn differing(before: &[Point], now: &[Point]) -> Vec<bool> {
    let bits = |v: &Point| v.map(f64::to_bits);
    before.iter().zip(now).map(|(before, now)| bits(before) != bits(now)).collect()
}

/// To node coordinates.
fn normalised(mut vertices: Vec<Point>, origin: Point, unit: f64) -> Vec<Point> {
    let scale = unit.recip();
    vertices.par_iter_mut().with_min_len(1 << 12).for_each(|v| {
        *v = [(v[0] - origin[0]) * scale, (v[1] - origin[1]) * scale, (v[2] - origin[2]) * scale];
    });
    vertices
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
    /// In node coordinates.
    vertices: Vec<Point>,
    /// Of each vertex: whether it has moved, or there is another frame.
    has_moved: Vec<bool>,
    /// The unit of the image before, in that of today.
    pub unit_before: f64,
}

impl Moved<'_> {
    pub fn triangle_count(&self) -> u32 {
        self.triangles.len() as u32
    }

    /// In node coordinates, by its rank.
    #[inline]
    pub fn triangle(&self, rank: u32) -> Triangle {
        self.triangles[rank as usize].vertices.map(|vertex| self.vertices[vertex as usize])
    }

    /// Whether a triangle of these ranks has a vertex that has moved.
    #[inline]
    pub fn any_of(&self, ranks: Range<u32>) -> bool {
        let triangles = &self.triangles[ranks.start as usize..ranks.end as usize];
        triangles.iter().any(|t| t.vertices.iter().any(|&v| self.has_moved[v as usize]))
    }
}

/// The sections of an image that is being rewritten.
struct Sections<'a> {
    nodes: &'a mut [u8],
    leaf_boxes: &'a mut [LeafBox],
    leaf_rows: &'a mut [LeafRows],
    triangles: &'a [LeafTriangle],
    vertices: &'a mut [Point],
}

impl<'a> Sections<'a> {
    fn of(blocks: &'a mut [Block], header: &Header) -> Self {
        let mut rest: &mut [u8] = bytemuck::cast_slice_mut(blocks);
        // From the last one on: what is left behind a start is that section.
        let mut from = |start: u64| {
            let (before, section) = std::mem::take(&mut rest).split_at_mut(start as usize);
            rest = before;
            section
        };
        let vertices = first(from(header.vertices_at), header.vertex_count);
        let triangles = first(from(header.triangles_at), header.triangle_count);
        let leaf_rows = first(from(header.leaf_rows_at), header.leaf_count);
        let leaf_boxes = first(from(header.leaf_boxes_at), header.leaf_count);
        Self { nodes: from(header.nodes_at), leaf_boxes, leaf_rows, triangles, vertices }
    }
}

/// As many as there are of what a section holds, without what fills its last block.
fn first<T: bytemuck::Pod>(section: &mut [u8], count: u32) -> &mut [T] {
    bytemuck::cast_slice_mut(&mut section[..count as usize * size_of::<T>()])
}

/// The length of the longest leaf's box.
fn refit_wide(
    nodes: &mut [u8],
    leaf_boxes: &mut [LeafBox],
    leaf_rows: &mut [LeafRows],
    moved: &Moved<'_>,
) -> f64 {
    wide::refit(bytemuck::cast_slice_mut(nodes), (leaf_boxes, leaf_rows), moved);
    longest_diagonal(leaf_boxes.par_iter().map(|leaf| widen(leaf.half)))
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
fn refit_binary<N: Refit>(nodes: &mut [u8], node_count: u32, moved: &Moved<'_>) -> f64 {
    let nodes: &mut [N] = first(nodes, node_count);
    let moved_before = counted_before(moved);
    let has_moved =
        |ranks: &Range<u32>| moved_before[ranks.start as usize] != moved_before[ranks.end as usize];
    let ranges = ranges(nodes);
    let changed = nodes.par_iter_mut().zip(ranges).filter(|(_, below)| has_moved(below));
    changed.for_each(|(node, below)| refit_node(node, below, moved));
    let leaf = |node: &N| matches!(node.link().child(), Child::Leaf { .. }).then(|| node.half());
    longest_diagonal(nodes.par_iter().filter_map(leaf))
}

/// Along the same axes, as long as that does not make the box much larger.
fn refit_node<N: Refit>(node: &mut N, below: Range<u32>, moved: &Moved<'_>) {
    /// A box has to be that much larger for other axes to pay.
    const GROWTH: f64 = 1.5;
    let mut axes = node.own_axes();
    let mut fit = fit_all(below.clone().map(|rank| moved.triangle(rank)), &axes);
    if surface(&fit.half) > GROWTH * surface(&node.half().map(|h| h * moved.unit_before)) {
        let own: Vec<Triangle> = below.map(|rank| moved.triangle(rank)).collect();
        let ids: Vec<u32> = (0..own.len() as u32).collect();
        let others = N::axes(&own, &ids);
        let along_others = fit_all(own.into_iter(), &others);
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
