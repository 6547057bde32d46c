//! The receiver's side: an image of which some subtrees are here.

use bytemuck::{bytes_of, cast_slice};

use super::SubtreeError;
use super::compressed::decompressed;
use super::message::{Arrays, HEADER, Topic, read};
use super::pages::Pages;
use super::sections::Sections;
use super::span::Span;
use crate::tree::roots::{CutTree, DistributedRoot, RootError};
use crate::tree::wide::{self, WideNode};
use crate::tree::{Header, TreeKind, TreeView};

/// An image in which subtrees are put and from which they are taken. Everything lies where it lies
/// in the whole one; a descent can start at the roots that are here.
#[derive(Debug)]
pub struct PartialTree {
    pages: Pages,
    spans: Vec<Span>,
    roots: Vec<DistributedRoot>,
    held: Vec<bool>,
    /// Of each subtree that is held: what it was written to.
    written: Vec<Vec<u32>>,
}

impl PartialTree {
    /// Without any subtree yet.
    pub fn new(outline: &[u8]) -> Result<Self, SubtreeError> {
        let (numbers, mut arrays) = read(Topic::Outline, outline)?;
        let header = arrays.take::<Header>(1)?[0];
        header.check()?;
        if numbers.image != header.content_hash || numbers.shared != 0 {
            return Err(SubtreeError::Malformed("its image has another hash"));
        }
        let spans = arrays.take::<Span>(numbers.root)?.into_owned();
        let below = spans.iter().try_fold(0_u32, |sum, span| sum.checked_add(span.nodes));
        let top = below.and_then(|below| header.node_count.checked_sub(below));
        let top = top.ok_or(SubtreeError::Malformed("subtrees have more nodes than there are"))?;
        let wide = header.tree_kind() == TreeKind::Wide;
        let nodes = arrays.take::<WideNode>(if wide { top } else { 0 })?;
        arrays.end()?;
        let numbers = check_outline(&header, &spans, &nodes)?;
        let memory = |source| SubtreeError::Memory { bytes: header.byte_length, source };
        let length = usize::try_from(header.byte_length).map_err(|_| memory(out_of_memory()))?;
        let mut pages = Pages::reserve(length).map_err(memory)?;
        let place =
            |number: u32| header.nodes_at as usize + number as usize * size_of::<WideNode>();
        let nodes = numbers.iter().zip(&*nodes).map(|(&at, node)| (place(at), bytes_of(node)));
        for (at, bytes) in nodes.chain([(0, bytes_of(&header))]) {
            // Held for good.
            let written = pages.of([(at, bytes.len())].into_iter());
            pages.hold(&written);
            pages.write(at, bytes);
        }
        let roots = spans.iter().map(Span::root).collect();
        let (held, written) = (vec![false; spans.len()], vec![Vec::new(); spans.len()]);
        Ok(Self { pages, spans, roots, held, written })
    }

    /// Puts a subtree to its place, compressed or not; its number. A message that is refused changes
    /// nothing: what was compressed is checked before it is put anywhere.
    pub fn add(&mut self, message: &[u8]) -> Result<u32, SubtreeError> {
        let topic = Topic::of_subtree(message);
        let (numbers, arrays) = read(topic, message)?;
        let here = self.view().hash();
        if numbers.image != here {
            return Err(SubtreeError::OtherImage { here, found: numbers.image });
        }
        let root = numbers.root;
        let unknown = RootError::Unknown { root, roots: self.spans.len() };
        let span = *self.spans.get(root as usize).ok_or(unknown)?;
        if self.held[root as usize] {
            return Err(SubtreeError::Held { root });
        }
        if numbers.shared > span.first_vertex {
            return Err(SubtreeError::Malformed("more vertices are shared than there are"));
        }
        let kind = self.view().kind();
        let unpacked = match topic {
            Topic::Compressed => {
                let length = span.array_bytes(kind, numbers.shared);
                Some(decompressed(arrays.rest(), length)?)
            }
            _ => None,
        };
        let arrays = unpacked.as_ref().map_or(arrays, |unpacked| Arrays::of(unpacked.bytes()));
        let sections = Sections::read(kind, &span, numbers.shared, arrays)?;
        sections.check(&self.view(), &span)?;
        let writes = sections.places(self.view().header(), &span);
        let pages = self.pages.of(writes.iter().map(|(at, bytes)| (*at, bytes.len())));
        self.pages.hold(&pages);
        for (at, bytes) in writes {
            self.pages.write(at, bytes);
        }
        self.written[root as usize] = pages;
        self.held[root as usize] = true;
        Ok(root)
    }

    /// As [`add`](Self::add), of a message that somebody else than the master has sent: it has to be
    /// of this root.
    pub fn add_root(&mut self, root: u32, message: &[u8]) -> Result<(), SubtreeError> {
        let (numbers, _) = read(Topic::of_subtree(message), message)?;
        if numbers.root != root {
            return Err(SubtreeError::OtherRoot { root, found: numbers.root });
        }
        self.add(message).map(drop)
    }

    /// No message of the subtree is longer, in bytes.
    pub fn longest_message(&self, root: u32) -> Result<u64, RootError> {
        let unknown = RootError::Unknown { root, roots: self.spans.len() };
        let span = self.spans.get(root as usize).ok_or(unknown)?;
        let shared = span.first_vertex.min(span.triangles.saturating_mul(3));
        Ok(HEADER as u64 + span.array_bytes(self.view().kind(), shared))
    }

    /// Gives back the memory that no other subtree needs.
    pub fn remove(&mut self, root: u32) -> Result<(), RootError> {
        match self.held.get_mut(root as usize) {
            None => Err(RootError::Unknown { root, roots: self.spans.len() }),
            Some(false) => Err(RootError::NotHeld { root }),
            Some(held) => {
                *held = false;
                self.pages.release(&std::mem::take(&mut self.written[root as usize]));
                Ok(())
            }
        }
    }

    /// Of the whole image.
    pub fn hash(&self) -> u64 {
        self.view().hash()
    }

    /// What a descent can start from.
    pub fn cut_tree(&self) -> CutTree<'_> {
        CutTree::partial(self.view(), &self.roots, &self.held)
    }

    /// The tree, if it was sent in one piece.
    pub fn whole(&self) -> Option<TreeView<'_>> {
        (self.held == [true]).then(|| self.view())
    }

    /// Bytes of the pages that are in use.
    pub fn memory(&self) -> usize {
        self.pages.in_use()
    }

    pub fn holds(&self, root: u32) -> bool {
        self.held.get(root as usize) == Some(&true)
    }

    fn view(&self) -> TreeView<'_> {
        TreeView::of_partial(cast_slice(self.pages.bytes()))
    }
}

fn out_of_memory() -> std::io::Error {
    std::io::ErrorKind::OutOfMemory.into()
}

/// Whether the subtrees follow each other in every section and the nodes above make one tree of
/// them; the numbers of those nodes.
fn check_outline(
    header: &Header,
    spans: &[Span],
    top: &[WideNode],
) -> Result<Vec<u32>, SubtreeError> {
    let wide = header.tree_kind() == TreeKind::Wide;
    let mut next = [0_u32; 3];
    for span in spans {
        let parts = [
            (span.first_triangle, span.triangles),
            (span.first_leaf, span.leaves),
            (span.first_vertex, span.vertices),
        ];
        for (next, (first, count)) in next.iter_mut().zip(parts) {
            let end = first.checked_add(count).filter(|_| first == *next);
            *next = end.ok_or(SubtreeError::Malformed("subtrees do not follow each other"))?;
        }
        if span.triangles == 0 || !wide && !span.is_binary() {
            return Err(SubtreeError::Malformed("a subtree is not a tree of its triangles"));
        }
    }
    if next != [header.triangle_count, header.leaf_count, header.vertex_count] {
        return Err(SubtreeError::Malformed("the subtrees are not the whole tree"));
    }
    if wide {
        let roots = spans.iter().map(Span::lanes_below);
        return wide::check_top(top, roots, header.node_count).map_err(SubtreeError::Malformed);
    }
    // A node above the roots has two subtrees, so that there is one less of them than roots.
    let ends = spans.iter().map(|span| u64::from(span.node) + u64::from(span.nodes));
    let starts = spans.iter().skip(1).map(|span| u64::from(span.node));
    let apart =
        ends.zip(starts.chain([u64::from(header.node_count)])).all(|(end, start)| end <= start);
    let below: u64 = spans.iter().map(|span| u64::from(span.nodes)).sum();
    if !apart || below + spans.len() as u64 != u64::from(header.node_count) + 1 {
        return Err(SubtreeError::Malformed("the subtrees are not those of one tree"));
    }
    Ok(Vec::new())
}
