//! From the binary tree to nodes of eight: of a binary node's descendants the largest are opened
//! until there are eight.

use super::build::{BinaryNode, Bounds};
use super::node::{Below, MOST, WIDTH, WideChild, WideNode};

/// The wide nodes, depth first. Leaves are numbered from left to right, in either tree.
pub fn collapse(binary: &[BinaryNode]) -> Vec<WideNode> {
    let mut out = Collapsed { nodes: Vec::with_capacity(binary.len() / 4), leaves: 0 };
    if binary[0].right == 0 {
        let lanes = [Lane { node: 0, levels: 1 }];
        out.emit(binary, &lanes);
    } else {
        out.subtree(binary, 0);
    }
    let most = MOST as u32;
    assert!(out.nodes.len() < MOST && out.leaves < most, "meshes of this size do not fit");
    out.nodes
}

struct Collapsed {
    nodes: Vec<WideNode>,
    leaves: u32,
}

#[derive(Clone, Copy)]
struct Lane {
    node: u32,
    levels: u32,
}

impl Collapsed {
    fn subtree(&mut self, binary: &[BinaryNode], root: u32) -> u32 {
        let mut room = [Lane { node: root, levels: 0 }; WIDTH];
        let mut used = 1;
        while used < WIDTH {
            let inner = room[..used].iter().enumerate().filter_map(|(at, lane)| {
                let node = &binary[lane.node as usize];
                (node.right != 0).then(|| (at, node.bounds.area(), node.right))
            });
            // The first of the largest, so that the order of children decides among equals.
            let largest = inner.reduce(|best, next| if next.1 > best.1 { next } else { best });
            let Some((at, _, right)) = largest else { break };
            let Lane { node, levels } = room[at];
            room.copy_within(at + 1..used, at + 2);
            room[at] = Lane { node: node + 1, levels: levels + 1 };
            room[at + 1] = Lane { node: node + right, levels: levels + 1 };
            used += 1;
        }
        self.emit(binary, &room[..used])
    }

    fn emit(&mut self, binary: &[BinaryNode], lanes: &[Lane]) -> u32 {
        let at = self.nodes.len();
        self.nodes.push(WideNode::EMPTY);
        let mut wide = WideNode::EMPTY;
        for (i, lane) in lanes.iter().enumerate() {
            let node = &binary[lane.node as usize];
            set_box(&mut wide, i, &node.bounds);
            let below = if node.right == 0 {
                self.leaves += 1;
                Below::Leaf(self.leaves - 1)
            } else {
                Below::Node(self.subtree(binary, lane.node))
            };
            wide.child[i] = WideChild::new(below, lane.levels);
        }
        self.nodes[at] = wide;
        at as u32
    }
}

/// Center and half extents that contain the bounds: the half extents are taken from the rounded
/// center in 64 bits, where that is exact, and rounded up.
pub(super) fn set_box(node: &mut WideNode, lane: usize, bounds: &Bounds) {
    for k in 0..3 {
        let (low, high) = (f64::from(bounds.low[k]), f64::from(bounds.high[k]));
        let center = (0.5 * (low + high)) as f32;
        let half = (high - f64::from(center)).max(f64::from(center) - low);
        node.center[k][lane] = center;
        node.half[k][lane] = (half as f32).next_up();
    }
    node.area[lane] = bounds.area();
}
