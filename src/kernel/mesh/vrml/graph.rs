use crate::geometry::Point;
use crate::mesh::affine::Affine;

/// A node of the scene graph. A child always ends before its parent and a node is named only
/// when it has ended, so the graph has no cycles.
pub struct Node {
    pub line: usize,
    pub content: Content,
    /// Nodes, vertices and triangles that one use of this node expands to.
    pub size: u64,
}

pub type NodeId = u32;

pub enum Content {
    Group(Vec<NodeId>),
    Transform(Box<Affine>, Vec<NodeId>),
    Faces {
        coordinate: NodeId,
        faces: Vec<[u32; 3]>,
    },
    Coordinate(Vec<Point>),
    /// Lines, points and text: legal, without a surface.
    NoSurface,
    /// Appearance, lights, sensors and the like.
    Nothing,
}

pub struct Graph {
    pub nodes: Vec<Node>,
    pub roots: Vec<NodeId>,
}

impl Graph {
    pub fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id as usize]
    }
}
