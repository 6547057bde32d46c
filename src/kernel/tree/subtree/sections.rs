//! What a subtree's message holds, and whether it is what it should be.

use std::borrow::Cow;

use bytemuck::{bytes_of, cast_slice};

use super::SubtreeError;
use super::message::Arrays;
use super::span::Span;
use crate::geometry::Point;
use crate::tree::image::check_topology;
use crate::tree::node::{AabbNode, ObbNode};
use crate::tree::wide::{self, LeafBox, LeafRows, WideNode};
use crate::tree::{Header, LeafTriangle, TreeKind, TreeView};

pub struct Sections<'a> {
    nodes: Nodes<'a>,
    leaf_boxes: Cow<'a, [LeafBox]>,
    leaf_rows: Cow<'a, [LeafRows]>,
    triangles: Cow<'a, [LeafTriangle]>,
    vertices: Cow<'a, [Point]>,
    shared: Cow<'a, [u32]>,
    shared_vertices: Cow<'a, [Point]>,
    /// Rank of the triangle after the last.
    end: u32,
}

enum Nodes<'a> {
    Obb(Cow<'a, [ObbNode]>),
    Aabb(Cow<'a, [AabbNode]>),
    Wide(Cow<'a, [WideNode]>),
}

impl Nodes<'_> {
    fn bytes(&self) -> &[u8] {
        match self {
            Self::Obb(nodes) => cast_slice(nodes),
            Self::Aabb(nodes) => cast_slice(nodes),
            Self::Wide(nodes) => cast_slice(nodes),
        }
    }
}

impl<'a> Sections<'a> {
    pub fn read(
        kind: TreeKind,
        span: &Span,
        shared: u32,
        mut arrays: Arrays<'a>,
    ) -> Result<Self, SubtreeError> {
        let sections = Self {
            nodes: match kind {
                TreeKind::Obb => Nodes::Obb(arrays.take(span.nodes)?),
                TreeKind::Aabb => Nodes::Aabb(arrays.take(span.nodes)?),
                TreeKind::Wide => Nodes::Wide(arrays.take(span.nodes)?),
            },
            leaf_boxes: arrays.take(span.leaves)?,
            leaf_rows: arrays.take(span.leaves)?,
            triangles: arrays.take(span.triangles)?,
            vertices: arrays.take(span.vertices)?,
            shared: arrays.take(shared)?,
            shared_vertices: arrays.take(shared)?,
            end: span.root().ranks().end,
        };
        arrays.end()?;
        Ok(sections)
    }

    /// Everything that a descent relies on.
    pub fn check(&self, tree: &TreeView<'_>, span: &Span) -> Result<(), SubtreeError> {
        match &self.nodes {
            Nodes::Obb(nodes) => check_topology(nodes, span.first_triangle)?,
            Nodes::Aabb(nodes) => check_topology(nodes, span.first_triangle)?,
            Nodes::Wide(nodes) => wide::check_below(
                span.children(tree.wide_nodes()),
                (span.first_node, nodes),
                (span.first_leaf, &self.leaf_boxes, &self.leaf_rows),
                &self.triangles,
                span.root().ranks(),
            )
            .map_err(SubtreeError::Malformed)?,
        }
        self.check_vertices(tree, span).map_err(SubtreeError::Malformed)
    }

    fn check_vertices(&self, tree: &TreeView<'_>, span: &Span) -> Result<(), &'static str> {
        let end = span.first_vertex + span.vertices;
        let ascending = self.shared.is_sorted_by(|a, b| a < b);
        if !ascending || self.shared.last().is_some_and(|&last| last >= span.first_vertex) {
            return Err("shared vertices are not those of subtrees further left");
        }
        let own = span.first_vertex..end;
        let known = |v: &u32| own.contains(v) || self.shared.binary_search(v).is_ok();
        if !self.triangles.iter().all(|triangle| triangle.vertices.iter().all(known)) {
            return Err("a triangle names a vertex that is not there");
        }
        let coordinates = self.vertices.iter().chain(&*self.shared_vertices).flatten();
        if !coordinates.into_iter().all(|c| c.is_finite()) {
            return Err("a vertex is not finite");
        }
        // Another subtree may have brought it: then it is this one, or there is nothing yet, or
        // nothing of a part that was on another page and was given back.
        let numbers = own.chain(self.shared.iter().copied());
        let mut sent = numbers.zip(self.vertices.iter().chain(&*self.shared_vertices));
        let here = tree.vertices();
        let fits = |(number, vertex): (u32, &Point)| {
            let here = here[number as usize].map(f64::to_bits);
            here.iter().zip(vertex).all(|(&here, sent)| here == 0 || here == sent.to_bits())
        };
        if sent.all(fits) {
            Ok(())
        } else {
            Err("a vertex is not the one that another subtree has")
        }
    }

    /// Where what belongs in the image.
    pub fn places(&self, header: &Header, span: &Span) -> Vec<(usize, &[u8])> {
        fn place<T>(section: u64, first: u32) -> usize {
            section as usize + first as usize * size_of::<T>()
        }
        let node_size = self.nodes.bytes().len().checked_div(span.nodes as usize).unwrap_or(0);
        let nodes_at = header.nodes_at as usize + span.first_node as usize * node_size;
        let mut places: Vec<(usize, &[u8])> = vec![
            (nodes_at, self.nodes.bytes()),
            (place::<LeafBox>(header.leaf_boxes_at, span.first_leaf), cast_slice(&self.leaf_boxes)),
            (place::<LeafRows>(header.leaf_rows_at, span.first_leaf), cast_slice(&self.leaf_rows)),
            (
                place::<LeafTriangle>(header.triangles_at, span.first_triangle),
                cast_slice(&self.triangles),
            ),
            (place::<Point>(header.vertices_at, span.first_vertex), cast_slice(&self.vertices)),
        ];
        let next_leaf = span.first_leaf + span.leaves;
        if next_leaf < header.leaf_count {
            // A leaf's triangles end where those of the next begin.
            let at = place::<LeafBox>(header.leaf_boxes_at, next_leaf);
            places.push((at + std::mem::offset_of!(LeafBox, first), bytes_of(&self.end)));
        }
        let shared = self.shared.iter().zip(&*self.shared_vertices);
        places.extend(shared.map(|(&number, vertex)| {
            (place::<Point>(header.vertices_at, number), bytes_of(vertex))
        }));
        places
    }
}
