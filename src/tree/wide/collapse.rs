//! From the binary tree to nodes of eight: of a binary node's descendants the largest are opened
//! until there are eight.

use super::build::{BinaryNode, Bounds};
use super::node::{Below, MOST, WIDTH, WideChild, WideNode};

/// The wide nodes, depth first, and for each leaf the range of its triangles' ranks.
pub struct Collapsed {
    pub nodes: Vec<WideNode>,
    pub leaves: Vec<std::ops::Range<u32>>,
}

pub fn collapse(binary: &[BinaryNode]) -> Collapsed {
    let mut out = Collapsed { nodes: Vec::new(), leaves: Vec::new() };
    if binary[0].children.is_none() {
        let lanes = [Lane { node: 0, levels: 1 }];
        out.emit(binary, &lanes);
    } else {
        out.subtree(binary, 0);
    }
    assert!(out.nodes.len() < MOST && out.leaves.len() < MOST, "meshes of this size do not fit");
    out
}

#[derive(Clone, Copy)]
struct Lane {
    node: u32,
    levels: u32,
}

impl Collapsed {
    fn subtree(&mut self, binary: &[BinaryNode], root: u32) -> u32 {
        let mut lanes = vec![Lane { node: root, levels: 0 }];
        while lanes.len() < WIDTH {
            let inner = lanes.iter().enumerate().filter_map(|(at, lane)| {
                let node = &binary[lane.node as usize];
                node.children.map(|children| (at, node.bounds.area(), children))
            });
            // The first of the largest, so that the order of children decides among equals.
            let largest = inner.reduce(|best, next| if next.1 > best.1 { next } else { best });
            let Some((at, _, children)) = largest else { break };
            let levels = lanes[at].levels + 1;
            lanes.splice(at..=at, children.map(|node| Lane { node, levels }));
        }
        self.emit(binary, &lanes)
    }

    fn emit(&mut self, binary: &[BinaryNode], lanes: &[Lane]) -> u32 {
        let at = self.nodes.len();
        self.nodes.push(WideNode::EMPTY);
        let mut wide = WideNode::EMPTY;
        for (i, lane) in lanes.iter().enumerate() {
            let node = &binary[lane.node as usize];
            set_box(&mut wide, i, &node.bounds);
            let below = if node.children.is_none() {
                self.leaves.push(node.first..node.first + node.count);
                Below::Leaf(self.leaves.len() as u32 - 1)
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
fn set_box(node: &mut WideNode, lane: usize, bounds: &Bounds) {
    for k in 0..3 {
        let (low, high) = (f64::from(bounds.low[k]), f64::from(bounds.high[k]));
        let center = (0.5 * (low + high)) as f32;
        let half = (high - f64::from(center)).max(f64::from(center) - low);
        node.center[k][lane] = center;
        node.half[k][lane] = (half as f32).next_up();
    }
    node.area[lane] = bounds.area();
}
