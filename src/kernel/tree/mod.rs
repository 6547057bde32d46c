//! Bounding-volume trees: built from a mesh, kept as relocatable bytes, descended in pairs.

mod accuracy;
pub mod advance;
mod build;
mod by_number;
pub mod cache;
pub mod descent;
mod fit;
mod image;
mod kept;
pub mod nearest;
mod node;
mod placement;
mod refit;
pub mod roots;
mod sink;
mod split;
pub mod subtree;
mod wide;

pub use accuracy::{Accuracy, BoxDepth, NotAnAccuracy};
pub use by_number::{ByNumber, Ranks};
pub use image::{Block, FORMAT_VERSION, Header, ImageError, LeafTriangle, TreeImage, TreeView};
pub use kept::KeptTree;
pub use refit::{RefitError, refit};
pub use sink::Counts;

use rayon::prelude::*;

use crate::geometry::boxes::bounds;
use crate::geometry::{Point, Triangle};
use crate::mesh::TriangleMesh;
use build::{Orient, build_nodes};
use image::{Parts, longest_diagonal};
use node::{AabbNode, Child, ObbNode, widen};
use wide::Outline;

/// Bounding volume of the nodes.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum TreeKind {
    /// Boxes turned by the Gaussian fit of what they bound: the paper's tree.
    Obb = 1,
    /// Boxes along the axes of the mesh.
    Aabb = 2,
    /// Nodes of eight boxes along the axes, above turned boxes of up to eight triangles: the
    /// fastest.
    #[default]
    Wide = 3,
}

impl TreeKind {
    pub const ALL: [Self; 3] = [Self::Obb, Self::Aabb, Self::Wide];
}

impl std::fmt::Display for TreeKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Obb => "obb",
            Self::Aabb => "aabb",
            Self::Wide => "wide",
        })
    }
}

/// Everything besides the mesh that the bytes of an image depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    pub kind: TreeKind,
}

/// The same bytes on any number of cores.
pub fn build(mesh: &TriangleMesh, options: BuildOptions) -> TreeImage {
    let frame = frame(mesh);
    let triangles = normalised(mesh, frame);
    match options.kind {
        TreeKind::Obb => build_binary::<ObbNode>(mesh, options, frame, &triangles),
        TreeKind::Aabb => build_binary::<AabbNode>(mesh, options, frame, &triangles),
        TreeKind::Wide => build_wide(mesh, options, frame, &triangles),
    }
}

fn normalised(mesh: &TriangleMesh, (origin, unit): (Point, f64)) -> Vec<Triangle> {
    // No difference overflows: the origin is in the middle of all vertices. A power of two divides
    // as its reciprocal multiplies.
    let scale = unit.recip();
    let vertex = |v: u32| {
        let v = &mesh.vertices()[v as usize];
        [(v[0] - origin[0]) * scale, (v[1] - origin[1]) * scale, (v[2] - origin[2]) * scale]
    };
    mesh.faces().par_iter().map(|&[a, b, c]| [vertex(a), vertex(b), vertex(c)]).collect()
}

fn build_binary<N: Orient>(
    mesh: &TriangleMesh,
    options: BuildOptions,
    (origin, unit): (Point, f64),
    normalised: &[Triangle],
) -> TreeImage {
    let (nodes, order) = build_nodes::<N>(normalised);
    let leaf = |node: &N| matches!(node.link().child(), Child::Leaf { .. }).then(|| node.half());
    let measure = || longest_diagonal(nodes.par_iter().filter_map(leaf));
    let ((triangles, vertices), (leaf_diameter, mesh_hash)) = rayon::join(
        || in_leaf_order(mesh, &order),
        || rayon::join(measure, || mesh.content_hash()),
    );
    TreeImage::assemble(&Parts {
        mesh_hash,
        options,
        origin,
        unit,
        leaf_diameter,
        nodes: (bytemuck::cast_slice(&nodes), nodes.len()),
        leaf_boxes: &[],
        leaf_rows: &[],
        triangles: &triangles,
        vertices: &vertices,
    })
}

fn build_wide(
    mesh: &TriangleMesh,
    options: BuildOptions,
    (origin, unit): (Point, f64),
    normalised: &[Triangle],
) -> TreeImage {
    let outline = Outline::of(normalised);
    let ((triangles, vertices), (tree, mesh_hash)) = rayon::join(
        || in_leaf_order(mesh, outline.order()),
        || rayon::join(|| outline.fill(normalised), || mesh.content_hash()),
    );
    TreeImage::assemble(&Parts {
        mesh_hash,
        options,
        origin,
        unit,
        leaf_diameter: longest_diagonal(tree.leaf_boxes.par_iter().map(|leaf| widen(leaf.half))),
        nodes: (bytemuck::cast_slice(&tree.nodes), tree.nodes.len()),
        leaf_boxes: &tree.leaf_boxes,
        leaf_rows: &tree.leaf_rows,
        triangles: &triangles,
        vertices: &vertices,
    })
}

/// The centre of the mesh, and the power of two above half its extent: node coordinates come to
/// lie within [-1, 1]. The unit stays in a range where it and its reciprocal are normal numbers.
fn frame(mesh: &TriangleMesh) -> (Point, f64) {
    let vertex = |&corner: &u32| &mesh.vertices()[corner as usize];
    // Parts that do not depend on the number of cores, for then neither does the sign of a zero.
    let parts = mesh.faces().as_flattened().par_chunks(1 << 15);
    let parts: Vec<_> = parts.map(|corners| bounds(corners.iter().map(vertex))).collect();
    let (low, high) = bounds(parts.iter().flat_map(|(low, high)| [low, high]));
    frame_around(&low, &high)
}

fn frame_around(low: &Point, high: &Point) -> (Point, f64) {
    let origin = [0, 1, 2].map(|i| 0.5 * low[i] + 0.5 * high[i]);
    let extent = (0..3).map(|i| (0.5 * high[i] - 0.5 * low[i]).abs()).fold(0.0, f64::max);
    (origin, power_of_two_above(extent))
}

/// The least power of two above `x`, within 2^-1000 and 2^1023.
fn power_of_two_above(x: f64) -> f64 {
    let exponent = ((x.to_bits() >> 52) & 0x7ff) as i32 - 1022;
    f64::from_bits(((exponent.clamp(-1000, 1023) + 1023) as u64) << 52)
}

/// Triangles in the order of their leaves and vertices in the order of their first use, so that a
/// subtree's are together. Vertices that no face uses stay out.
fn in_leaf_order(mesh: &TriangleMesh, order: &[u32]) -> (Vec<LeafTriangle>, Vec<Point>) {
    const UNSEEN: u32 = u32::MAX;
    let mut renumbered = vec![UNSEEN; mesh.vertices().len()];
    let mut vertices = Vec::with_capacity(mesh.vertices().len());
    let triangles = order
        .iter()
        .map(|&id| {
            let corners = mesh.faces()[id as usize].map(|v| {
                let number = &mut renumbered[v as usize];
                if *number == UNSEEN {
                    *number = vertices.len() as u32;
                    vertices.push(mesh.vertices()[v as usize]);
                }
                *number
            });
            LeafTriangle { vertices: corners, id }
        })
        .collect();
    (triangles, vertices)
}
