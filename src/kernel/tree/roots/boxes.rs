//! The boxes of a tree at a depth, to be looked at.

use super::top::top_of;
use super::{Cut, DistributedRoot};
use crate::geometry::Point;
use crate::tree::node::{ObbNode, widen};
use crate::tree::wide::Bounds;
use crate::tree::{TreeKind, TreeView};

/// Contains `center + sum_i s_i axes[i]` for `|s_i| <= half[i]`: metres, axes of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeBox {
    pub center: Point,
    pub half: Point,
    pub axes: [Point; 3],
}

const ALONG_THE_AXES: [Point; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Of each distributed root, from left to right.
pub fn boxes(tree: &TreeView<'_>, cut: Cut) -> Vec<NodeBox> {
    let top = top_of(tree, cut);
    match tree.kind() {
        TreeKind::Obb => top.roots.iter().map(|root| turned(tree, root)).collect(),
        TreeKind::Aabb | TreeKind::Wide => {
            let leaves = top.nodes.iter().filter(|node| node.right == 0);
            leaves.map(|leaf| straight(tree, &leaf.bounds)).collect()
        }
    }
}

fn turned(tree: &TreeView<'_>, root: &DistributedRoot) -> NodeBox {
    let node: ObbNode = tree.nodes::<ObbNode>()[root.node as usize];
    let axes = node.axes.map(widen);
    in_metres(tree, widen(node.center), widen(node.half), axes)
}

fn straight(tree: &TreeView<'_>, bounds: &Bounds) -> NodeBox {
    let [low, high] =
        [bounds.low, bounds.high].map(|corner| [0, 1, 2].map(|k| f64::from(corner[k])));
    let center = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let half = [0, 1, 2].map(|k| 0.5 * (high[k] - low[k]));
    in_metres(tree, center, half, ALONG_THE_AXES)
}

fn in_metres(tree: &TreeView<'_>, center: Point, half: Point, axes: [Point; 3]) -> NodeBox {
    let (origin, unit) = (tree.header().origin, tree.header().unit);
    NodeBox {
        center: [0, 1, 2].map(|k| origin[k] + unit * center[k]),
        half: half.map(|h| unit * h),
        axes,
    }
}

#[cfg(test)]
mod tests {
    use super::super::distributed_roots;
    use super::*;
    use crate::geometry::boxes::dot;
    use crate::mesh::MeshSource;
    use crate::tree::{BuildOptions, build};

    #[test]
    fn a_box_holds_every_corner_of_the_triangles_below_it() {
        let mesh = "builtin:car?triangles=1000".parse::<MeshSource>().unwrap().load().unwrap();
        for kind in TreeKind::ALL {
            let image = build(&mesh, BuildOptions { kind });
            let tree = image.view();
            for depth in [0, 1, 4, 30] {
                let (boxes, roots) =
                    (boxes(&tree, Cut::Depth(depth)), distributed_roots(&tree, Cut::Depth(depth)));
                assert_eq!(boxes.len(), roots.len());
                for (of, root) in boxes.iter().zip(&roots) {
                    let outside = |p: &Point| {
                        let from = [0, 1, 2].map(|k| p[k] - of.center[k]);
                        (0..3).any(|i| dot(&from, &of.axes[i]).abs() > of.half[i] + 1e-5)
                    };
                    let corners = root.ranks().flat_map(|rank| tree.corners(rank));
                    assert!(!corners.into_iter().any(|p| outside(&p)), "{kind} at depth {depth}");
                }
            }
        }
    }
}
