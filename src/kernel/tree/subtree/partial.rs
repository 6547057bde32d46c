//! The receiver's side: an image of which some subtrees are here.

use std::io;
use std::ops::Deref;

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
pub struct PartialTree<M = Pages> {
    memory: M,
    spans: Vec<Span>,
    roots: Vec<DistributedRoot>,
    held: Vec<bool>,
    /// Of each subtree that is held: what it was written to.
    written: Vec<Vec<u32>>,
}

/// Memory for a partial image, which is zeroes at first.
pub trait Put: Deref<Target = [u8]> {
    /// Writes each of these bytes to its place; the pages that are held for it.
    fn put(&mut self, writes: &[(usize, &[u8])]) -> io::Result<Vec<u32>>;
}

impl PartialTree {
    /// Without any subtree yet.
    pub fn new(outline: &[u8]) -> Result<Self, SubtreeError> {
        Self::within(outline, |bytes, _| Pages::reserve(bytes))
    }

    /// Gives back the memory that no other subtree needs.
    pub fn remove(&mut self, root: u32) -> Result<(), RootError> {
        match self.held.get_mut(root as usize) {
            None => Err(RootError::Unknown { root, roots: self.spans.len() }),
            Some(false) => Err(RootError::NotHeld { root }),
            Some(held) => {
                *held = false;
                self.memory.release(&std::mem::take(&mut self.written[root as usize]));
                Ok(())
            }
        }
    }

    /// Bytes of the pages that are in use.
    pub fn memory(&self) -> usize {
        self.memory.in_use()
    }
}

impl<M: Put> PartialTree<M> {
    /// Without any subtree yet, in the memory that is made for so many bytes and roots.
    pub(super) fn within(
        outline: &[u8],
        make: impl FnOnce(usize, usize) -> io::Result<M>,
    ) -> Result<Self, SubtreeError> {
        let Outline { header, spans, top } = Outline::read(outline)?;
        let memory = |source| SubtreeError::Memory { bytes: header.byte_length, source };
        let length = usize::try_from(header.byte_length).map_err(|_| memory(out_of_memory()))?;
        let mut within = make(length, spans.len()).map_err(memory)?;
        let place =
            |number: u32| header.nodes_at as usize + number as usize * size_of::<WideNode>();
        let nodes = top.iter().map(|(at, node)| (place(*at), bytes_of(node)));
        let writes: Vec<_> = nodes.chain([(0, bytes_of(&header))]).collect();
        // Held for good.
        within.put(&writes).map_err(memory)?;
        Ok(Self::of(within, spans))
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
        let bytes = self.view().header().byte_length;
        let held = self.memory.put(&writes);
        let held = held.map_err(|source| SubtreeError::Memory { bytes, source })?;
        self.written[root as usize] = held;
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
}

impl<M: Deref<Target = [u8]>> PartialTree<M> {
    /// In memory that somebody else has put it in, and goes on to put subtrees in.
    pub(super) fn of_another(
        outline: &[u8],
        find: impl FnOnce(usize, usize) -> Result<M, SubtreeError>,
    ) -> Result<Self, SubtreeError> {
        let Outline { header, spans, .. } = Outline::read(outline)?;
        let bytes = header.byte_length as usize;
        Ok(Self::of(find(bytes, spans.len())?, spans))
    }

    fn of(memory: M, spans: Vec<Span>) -> Self {
        let roots = spans.iter().map(Span::root).collect();
        let (held, written) = (vec![false; spans.len()], vec![Vec::new(); spans.len()]);
        Self { memory, spans, roots, held, written }
    }

    pub(super) fn within_memory(&self) -> &M {
        &self.memory
    }

    /// Of each root, whether its subtree is here.
    pub(super) fn held_mut(&mut self) -> (&M, &mut [bool]) {
        (&self.memory, &mut self.held)
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

    pub fn holds(&self, root: u32) -> bool {
        self.held.get(root as usize) == Some(&true)
    }

    fn view(&self) -> TreeView<'_> {
        TreeView::of_partial(cast_slice(&self.memory))
    }
}

fn out_of_memory() -> io::Error {
    io::ErrorKind::OutOfMemory.into()
}

/// What a receiver is told before any subtree, checked.
struct Outline {
    header: Header,
    spans: Vec<Span>,
    /// Nodes above the roots, by their numbers.
    top: Vec<(u32, WideNode)>,
}

impl Outline {
    fn read(outline: &[u8]) -> Result<Self, SubtreeError> {
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
        let top = numbers.into_iter().zip(nodes.iter().copied()).collect();
        Ok(Self { header, spans, top })
    }
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
