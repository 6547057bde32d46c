//! The master's side: what each subtree is, and its message.

use bytemuck::bytes_of;

use super::message::{HEADER, Numbers, Topic, write};
use super::span::Span;
use crate::geometry::Point;
use crate::tree::node::{AabbNode, Node, ObbNode};
use crate::tree::roots::{Cut, RootError, distributed_roots};
use crate::tree::wide::WideNode;
use crate::tree::{Header, TreeKind, TreeView};

/// An image cut into subtrees.
#[derive(Debug)]
pub struct Subtrees<'a> {
    tree: TreeView<'a>,
    spans: Vec<Span>,
    /// Of every subtree the vertices that a triangle further left has too, ascending; and where
    /// each subtree's end.
    shared: Vec<u32>,
    shared_ends: Vec<usize>,
}

impl<'a> Subtrees<'a> {
    pub fn new(tree: TreeView<'a>, cut: Cut) -> Self {
        let roots = distributed_roots(&tree, cut);
        let spans = roots.iter().map(|root| Span::of(&tree, root)).collect();
        let mut subtrees = Self { tree, spans, shared: Vec::new(), shared_ends: Vec::new() };
        subtrees.assign_vertices();
        subtrees
    }

    /// They are numbered in the order of their first use; what no triangle uses goes to the last.
    fn assign_vertices(&mut self) {
        let triangles = self.tree.triangles();
        let last = self.spans.len() - 1;
        let mut first_vertex = 0;
        for (number, span) in self.spans.iter_mut().enumerate() {
            let own = &triangles[span.first_triangle as usize..][..span.triangles as usize];
            let used = || own.iter().flat_map(|triangle| triangle.vertices);
            let end = used().fold(first_vertex, |end, vertex| end.max(vertex + 1));
            let end = if number == last { self.tree.header().vertex_count } else { end };
            (span.first_vertex, span.vertices) = (first_vertex, end - first_vertex);
            let mut shared: Vec<u32> = used().filter(|&vertex| vertex < first_vertex).collect();
            shared.sort_unstable();
            shared.dedup();
            self.shared.extend(shared);
            self.shared_ends.push(self.shared.len());
            first_vertex = end;
        }
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.spans.len() as u32
    }

    /// What a receiver needs before any subtree: the image's header, what lies above the roots, and
    /// where everything will lie.
    pub fn outline(&self) -> Vec<u8> {
        let top = match self.tree.kind() {
            TreeKind::Wide => self.top_nodes(),
            TreeKind::Obb | TreeKind::Aabb => Vec::new(),
        };
        let numbers = Numbers { image: self.tree.hash(), root: self.count(), shared: 0 };
        let spans = bytemuck::cast_slice(&self.spans);
        let header: &Header = self.tree.header();
        write(Topic::Outline, numbers, &[bytes_of(header), spans, bytemuck::cast_slice(&top)])
    }

    /// Nodes that are below no root, in their order.
    fn top_nodes(&self) -> Vec<WideNode> {
        let nodes = self.tree.wide_nodes();
        let mut below = vec![false; nodes.len()];
        for span in &self.spans {
            below[span.first_node as usize..][..span.nodes as usize].fill(true);
        }
        nodes.iter().zip(below).filter_map(|(node, below)| (!below).then_some(*node)).collect()
    }

    /// The subtree below a root as a message.
    pub fn message(&self, root: u32) -> Result<Vec<u8>, RootError> {
        let span = self.span(root)?;
        let shared = self.shared_of(root);
        let tree = &self.tree;
        let vertices = tree.vertices();
        let points: Vec<Point> = shared.iter().map(|&vertex| vertices[vertex as usize]).collect();
        let numbers = Numbers { image: tree.hash(), root, shared: shared.len() as u32 };
        let arrays = [
            self.nodes(span),
            part(tree.leaf_boxes(), span.first_leaf, span.leaves),
            part(tree.leaf_rows(), span.first_leaf, span.leaves),
            part(tree.triangles(), span.first_triangle, span.triangles),
            part(vertices, span.first_vertex, span.vertices),
            bytemuck::cast_slice(shared),
            bytemuck::cast_slice(&points),
        ];
        Ok(write(Topic::Subtree, numbers, &arrays))
    }

    /// Of a message, without making it.
    pub fn message_length(&self, root: u32) -> Result<usize, RootError> {
        let shared = self.shared_of(root).len() as u32;
        Ok(HEADER + self.span(root)?.array_bytes(self.tree.kind(), shared) as usize)
    }

    fn nodes(&self, span: &Span) -> &'a [u8] {
        fn of<'a, N: Node>(tree: &TreeView<'a>, span: &Span) -> &'a [u8] {
            part(tree.nodes::<N>(), span.first_node, span.nodes)
        }
        match self.tree.kind() {
            TreeKind::Obb => of::<ObbNode>(&self.tree, span),
            TreeKind::Aabb => of::<AabbNode>(&self.tree, span),
            TreeKind::Wide => part(self.tree.wide_nodes(), span.first_node, span.nodes),
        }
    }

    fn span(&self, root: u32) -> Result<&Span, RootError> {
        let unknown = RootError::Unknown { root, roots: self.spans.len() };
        self.spans.get(root as usize).ok_or(unknown)
    }

    fn shared_of(&self, root: u32) -> &[u32] {
        let root = root as usize;
        let from = if root == 0 { 0 } else { self.shared_ends[root - 1] };
        &self.shared[from..self.shared_ends[root]]
    }
}

fn part<T: bytemuck::Pod>(section: &[T], first: u32, count: u32) -> &[u8] {
    bytemuck::cast_slice(&section[first as usize..][..count as usize])
}
