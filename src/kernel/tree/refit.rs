//! A tree for a mesh whose vertices have moved and whose faces have not: every box is drawn anew
//! around what it held, and what is in which box stays.
//!
//! The answers are those of a tree that is built. It is slower to descend the further the mesh has
//! gone from the one that its tree was built for.

#[cfg(test)]
mod tests;

use std::ops::Range;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use rayon::prelude::*;

use super::build::Orient;
use super::fit::{Axes, IDENTITY, fit_all, least, most};
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
    let (header, mesh_hash) = rayon::join(|| redraw(image, mesh), || mesh.content_hash());
    image.seal(Header { mesh_hash, ..header? });
    Ok(())
}

/// All but the header, which is to be put before it with the mesh's hash.
fn redraw(image: &mut TreeImage, mesh: &TriangleMesh) -> Result<Header, RefitError> {
    let tree = image.view();
    let (before, kind) = (*tree.header(), tree.kind());
    let numbers = numbers(&tree, mesh)?;
    let sections = Sections::of(image.blocks_mut(), &before);
    let (has_moved, (low, high)) = move_vertices(sections.vertices, &numbers, mesh);
    let (origin, unit) = frame(&before, &low, &high);
    let moved = Moved {
        triangles: sections.triangles,
        vertices: sections.vertices,
        has_moved,
        in_other_frame: (origin, unit) != (before.origin, before.unit),
        origin,
        scale: unit.recip(),
        unit_before: before.unit / unit,
    };
    let leaf_diameter = match kind {
        TreeKind::Obb => refit_binary::<ObbNode>(sections.nodes, before.node_count, &moved),
        TreeKind::Aabb => refit_binary::<AabbNode>(sections.nodes, before.node_count, &moved),
        TreeKind::Wide => {
            refit_wide(sections.nodes, sections.leaf_boxes, sections.leaf_rows, &moved)
        }
    };
    Ok(Header { origin, unit, low, high, leaf_diameter, ..before })
}

/// The vertices' numbers in the mesh, by those in the image.
fn numbers(tree: &TreeView<'_>, mesh: &TriangleMesh) -> Result<Numbers, RefitError> {
    let (faces, triangles) = (mesh.faces(), tree.triangles());
    if triangles.len() != faces.len() {
        return Err(RefitError::Triangles { tree: tree.triangle_count(), mesh: faces.len() });
    }
    let unseen = || Numbers::unseen(tree.vertices().len());
    let numbers = unseen();
    if triangles.par_iter().with_min_len(PART).all(|triangle| numbers.agree(triangle, faces)) {
        return Ok(numbers);
    }
    // From left to right, for the same answer on any number of cores.
    let numbers = unseen();
    match triangles.iter().find(|triangle| !numbers.agree(triangle, faces)) {
        Some(triangle) => Err(RefitError::Faces(triangle.id)),
        None => Ok(numbers),
    }
}

/// Below this many triangles or vertices another task does not pay.
const PART: usize = 1 << 12;

/// The number of a vertex is what the first triangle to ask says; all others have to agree.
struct Numbers(Vec<AtomicU32>);

impl Numbers {
    /// A mesh has fewer vertices.
    const UNSEEN: u32 = u32::MAX;

    fn unseen(count: usize) -> Self {
        Self((0..count).map(|_| AtomicU32::new(Self::UNSEEN)).collect())
    }

    /// Whether the triangle has the vertices of its face, as far as those are known.
    fn agree(&self, triangle: &LeafTriangle, faces: &[[u32; 3]]) -> bool {
        let same = |(&vertex, &corner): (&u32, &u32)| {
            let number = &self.0[vertex as usize];
            match number.load(Relaxed) {
                Self::UNSEEN => number
                    .compare_exchange(Self::UNSEEN, corner, Relaxed, Relaxed)
                    .map_or_else(|found| found == corner, |_| true),
                found => found == corner,
            }
        };
        // The numbers of triangles in an image are not checked when it is viewed.
        let face = faces.get(triangle.id as usize);
        face.is_some_and(|face| triangle.vertices.iter().zip(face).all(same))
    }
}

/// Puts an image's vertices where the mesh has them: which have moved, and the bounds of all.
///
/// Moved is what has other bits: an image has those of a zero's sign, too.
fn move_vertices(
    vertices: &mut [Point],
    numbers: &Numbers,
    mesh: &TriangleMesh,
) -> (Vec<bool>, (Point, Point)) {
    let mut has_moved = vec![false; vertices.len()];
    let each = vertices.par_chunks_mut(PART).zip(has_moved.par_chunks_mut(PART));
    let move_part = |((vertices, has_moved), numbers): ((&mut [Point], &mut [bool]), &[_])| {
        for ((vertex, has_moved), number) in vertices.iter_mut().zip(has_moved).zip(numbers) {
            // What no triangle has stays where it is.
            let number: u32 = AtomicU32::load(number, Relaxed);
            let now = *mesh.vertices().get(number as usize).unwrap_or(vertex);
            *has_moved = (0..3).any(|k| vertex[k].to_bits() != now[k].to_bits());
            *vertex = now;
        }
        bounds(&*vertices)
    };
    let parts: Vec<_> = each.zip(numbers.0.par_chunks(PART)).map(move_part).collect();
    (has_moved, bounds(parts.iter().flat_map(|(low, high)| [low, high])))
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
    /// In metres.
    vertices: &'a [Point],
    /// Of each vertex.
    has_moved: Vec<bool>,
    in_other_frame: bool,
    /// Of node coordinates.
    origin: Point,
    scale: f64,
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
        // Not by `map`, which is not inlined here.
        let [a, b, c] = self.triangles[rank as usize].vertices;
        let at = |vertex: u32| self.normalised(&self.vertices[vertex as usize]);
        [at(a), at(b), at(c)]
    }

    #[inline]
    fn normalised(&self, v: &Point) -> Point {
        let Self { origin: o, scale, .. } = self;
        [(v[0] - o[0]) * scale, (v[1] - o[1]) * scale, (v[2] - o[2]) * scale]
    }

    /// Of the triangles of these ranks, in node coordinates. Roundings are monotone: the least
    /// coordinate in metres becomes the least one.
    #[inline]
    pub fn bounds(&self, ranks: Range<u32>) -> (Point, Point) {
        let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
        for triangle in &self.triangles[ranks.start as usize..ranks.end as usize] {
            for vertex in triangle.vertices {
                let [x, y, z] = self.vertices[vertex as usize];
                low = least(low, [x, y, z, 0.0]);
                high = most(high, [x, y, z, 0.0]);
            }
        }
        let [low, high] = [low, high].map(|[x, y, z, _]| self.normalised(&[x, y, z]));
        (low, high)
    }

    /// Whether a triangle of these ranks has a vertex that has moved, or there is another frame.
    #[inline]
    pub fn any_of(&self, ranks: Range<u32>) -> bool {
        let triangles = &self.triangles[ranks.start as usize..ranks.end as usize];
        let has_moved = |vertex: u32| self.has_moved[vertex as usize];
        self.in_other_frame || triangles.iter().any(|t| t.vertices.iter().any(|&v| has_moved(v)))
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
    let triangles = || (0..moved.triangle_count()).into_par_iter().map(|rank| moved.triangle(rank));
    let ((moved_before, ranges), triangles) = rayon::join(
        || rayon::join(|| counted_before(moved), || ranges(nodes)),
        || triangles().collect::<Vec<_>>(),
    );
    let has_moved =
        |ranks: &Range<u32>| moved_before[ranks.start as usize] != moved_before[ranks.end as usize];
    let changed = nodes.par_iter_mut().zip(ranges).filter(|(_, below)| has_moved(below));
    changed.for_each(|(node, Range { start, end })| {
        refit_node(node, &triangles[start as usize..end as usize], moved.unit_before);
    });
    let leaf = |node: &N| matches!(node.link().child(), Child::Leaf { .. }).then(|| node.half());
    longest_diagonal(nodes.par_iter().filter_map(leaf))
}

/// Along the same axes, as long as that does not make the box much larger. `unit`: that of the
/// lengths in the node, in today's.
fn refit_node<N: Refit>(node: &mut N, below: &[Triangle], unit: f64) {
    /// A box has to be that much larger for other axes to pay.
    const GROWTH: f64 = 1.5;
    let mut axes = node.own_axes();
    let mut fit = fit_all(below, &axes);
    if surface(&fit.half) > GROWTH * surface(&node.half().map(|h| h * unit)) {
        let ids: Vec<u32> = (0..below.len() as u32).collect();
        let others = N::axes(below, &ids);
        let along_others = fit_all(below, &others);
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
