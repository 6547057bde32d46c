//! Any tree as what conservative advancement sees: boxes in mesh coordinates, their children, and
//! at the end triangles.

use nalgebra::{Matrix3, Vector3};

use crate::tree::node::{AabbNode, Child, Link, Node, ObbNode, widen};
use crate::tree::wide::{Below, LeafBox, WIDTH, WideNode};
use crate::tree::{TreeKind, TreeView};

/// A place in a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Spot {
    /// Everything: above the boxes of a wide tree's first node.
    Whole,
    /// A node of a binary tree by its number, or a lane of a wide one: node times [`WIDTH`] plus lane.
    Box(u32),
    /// By its rank.
    Triangle(u32),
}

/// Contains `center + sum_i s_i axes_i` for `|s_i| <= half_i`, with the columns of `axes`; metres in
/// mesh axes, widened by all that is between the image's numbers and the mesh's.
#[derive(Clone, Copy, Debug)]
pub struct MeshBox {
    pub center: Vector3<f64>,
    pub half: Vector3<f64>,
    pub axes: Matrix3<f64>,
}

pub struct BoxTree<'a> {
    tree: TreeView<'a>,
    volumes: Volumes<'a>,
}

enum Volumes<'a> {
    Obb(&'a [ObbNode]),
    Aabb(&'a [AabbNode]),
    Wide(&'a [WideNode], &'a [LeafBox]),
}

/// Of a box's half extents together, as its axes are orthonormal only to rounding; this and the next
/// as in [`crate::tree::placement`].
const RELATIVE_SLACK: f64 = 1.0 / (1_u64 << 18) as f64;
/// Of the image's unit.
const ABSOLUTE_SLACK: f64 = 1.0 / (1_u64 << 40) as f64;

impl<'a> BoxTree<'a> {
    pub fn new(tree: TreeView<'a>) -> Self {
        let volumes = match tree.kind() {
            TreeKind::Obb => Volumes::Obb(tree.nodes()),
            TreeKind::Aabb => Volumes::Aabb(tree.nodes()),
            TreeKind::Wide => Volumes::Wide(tree.wide_nodes(), tree.leaf_boxes()),
        };
        Self { tree, volumes }
    }

    pub fn tree(&self) -> &TreeView<'a> {
        &self.tree
    }

    /// No vertex is further from the mesh's origin, in metres.
    pub fn reach(&self) -> f64 {
        let header = self.tree.header();
        let far = |k: usize| header.low[k].abs().max(header.high[k].abs());
        Vector3::new(far(0), far(1), far(2)).norm()
    }

    pub fn top(&self) -> Spot {
        match self.volumes {
            Volumes::Obb(nodes) => binary(nodes, 0),
            Volumes::Aabb(nodes) => binary(nodes, 0),
            Volumes::Wide(..) => Spot::Whole,
        }
    }

    /// Replaces `children` by what is directly below; nothing is below a triangle.
    pub fn children(&self, spot: Spot, children: &mut Vec<Spot>) {
        children.clear();
        match (&self.volumes, spot) {
            (Volumes::Obb(nodes), Spot::Box(node)) => two(nodes, node, children),
            (Volumes::Aabb(nodes), Spot::Box(node)) => two(nodes, node, children),
            (Volumes::Wide(nodes, _), Spot::Whole) => lanes(nodes, 0, children),
            (Volumes::Wide(nodes, leaves), Spot::Box(slot)) => match child(nodes, slot) {
                Below::Node(node) => lanes(nodes, node, children),
                Below::Leaf(leaf) => {
                    let first = |leaf: usize| leaves.get(leaf).map(|leaf| leaf.first);
                    let (from, to) = (first(leaf as usize), first(leaf as usize + 1));
                    let to = to.unwrap_or(self.tree.triangle_count());
                    children.extend((from.unwrap_or(to)..to).map(Spot::Triangle));
                }
            },
            (_, Spot::Triangle(_)) | (Volumes::Obb(_) | Volumes::Aabb(_), Spot::Whole) => {}
        }
    }

    /// The box at a spot; of a triangle there is none.
    pub fn bounds(&self, spot: Spot) -> Option<MeshBox> {
        Some(match (&self.volumes, spot) {
            (_, Spot::Triangle(_)) => return None,
            (_, Spot::Whole) => self.all(),
            (Volumes::Obb(nodes), Spot::Box(node)) => {
                let ObbNode { center, half, axes, .. } = &nodes[node as usize];
                self.turned(center, half, axes)
            }
            (Volumes::Aabb(nodes), Spot::Box(node)) => {
                let AabbNode { center, half, .. } = &nodes[node as usize];
                self.straight(*center, *half)
            }
            (Volumes::Wide(nodes, leaves), Spot::Box(slot)) => match child(nodes, slot) {
                Below::Leaf(leaf) => {
                    let LeafBox { center, half, axes, .. } = &leaves[leaf as usize];
                    self.turned(center, half, axes)
                }
                Below::Node(_) => {
                    let node = &nodes[slot as usize / WIDTH];
                    let of = |rows: &[[f32; WIDTH]; 3]| rows.map(|row| row[slot as usize % WIDTH]);
                    self.straight(of(&node.center), of(&node.half))
                }
            },
        })
    }

    fn all(&self) -> MeshBox {
        let header = self.tree.header();
        let (low, high) = (Vector3::from(header.low), Vector3::from(header.high));
        let center = 0.5 * low + 0.5 * high;
        // The larger of both sides, as the centre is rounded.
        let half = (high - center).sup(&(center - low));
        MeshBox { center, half, axes: Matrix3::identity() }
    }

    fn turned(&self, center: &[f32; 3], half: &[f32; 3], axes: &[[f32; 3]; 3]) -> MeshBox {
        let axes = Matrix3::from_columns(&axes.map(|axis| Vector3::from(widen(axis))));
        MeshBox { axes, ..self.straight(*center, *half) }
    }

    fn straight(&self, center: [f32; 3], half: [f32; 3]) -> MeshBox {
        let header = self.tree.header();
        let unit = header.unit;
        let half = Vector3::from(widen(half)) * unit;
        let slack = RELATIVE_SLACK * half.sum() + ABSOLUTE_SLACK * unit;
        MeshBox {
            center: Vector3::from(widen(center)) * unit + Vector3::from(header.origin),
            half: half.add_scalar(slack),
            axes: Matrix3::identity(),
        }
    }
}

fn binary<N: Node>(nodes: &[N], at: u32) -> Spot {
    match Link::child(nodes[at as usize].link()) {
        Child::Leaf { rank } => Spot::Triangle(rank),
        Child::Inner { .. } => Spot::Box(at),
    }
}

fn two<N: Node>(nodes: &[N], at: u32, children: &mut Vec<Spot>) {
    if let Child::Inner { right } = nodes[at as usize].link().child() {
        children.extend([binary(nodes, at + 1), binary(nodes, at + right)]);
    }
}

fn child(nodes: &[WideNode], slot: u32) -> Below {
    nodes[slot as usize / WIDTH].child[slot as usize % WIDTH].below()
}

fn lanes(nodes: &[WideNode], node: u32, children: &mut Vec<Spot>) {
    let count = nodes[node as usize].lanes() as u32;
    children.extend((0..count).map(|lane| Spot::Box(node * WIDTH as u32 + lane)));
}
