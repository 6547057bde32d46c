//! A partial image that all workers of a node have in common: its leader puts subtrees into shared
//! memory, and workers read them there.
//!
//! ```text
//! length of the outline | outline | per root 1 once its subtree is here, before 0 | image
//! ```
//!
//! Each part begins on a multiple of 64 bytes.

use std::io;
use std::ops::{Deref, Range};

use super::SubtreeError;
use super::partial::{PartialTree, Put};
use crate::tree::TreeView;
use crate::tree::roots::CutTree;

const ALIGNMENT: usize = 64;

/// Memory that is zeroes until it is written.
pub trait Region: Deref<Target = [u8]> {
    fn write(&self, at: usize, bytes: &[u8]) -> io::Result<()>;
}

/// Where the parts are.
#[derive(Clone, Debug)]
struct Parts {
    outline: Range<usize>,
    held: Range<usize>,
    image: Range<usize>,
}

impl Parts {
    /// `None` if no memory is so large.
    fn new(outline: usize, roots: usize, image: usize) -> Option<Self> {
        let part = |after: usize, bytes: usize| {
            let start = after.checked_next_multiple_of(ALIGNMENT)?;
            Some(start..start.checked_add(bytes)?)
        };
        let outline = part(size_of::<u64>(), outline)?;
        let held = part(outline.end, roots)?;
        let image = part(held.end, image)?;
        Some(Self { outline, held, image })
    }
}

/// The part of a region that is the image.
#[derive(Debug)]
struct Image<R> {
    region: R,
    parts: Parts,
}

impl<R: Deref<Target = [u8]>> Deref for Image<R> {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.region[self.parts.image.clone()]
    }
}

impl<R: Region> Put for Image<R> {
    fn put(&mut self, writes: &[(usize, &[u8])]) -> io::Result<Vec<u32>> {
        let image = self.parts.image.start;
        writes.iter().try_for_each(|(at, bytes)| self.region.write(image + at, bytes))?;
        Ok(Vec::new())
    }
}

/// The leader's side.
#[derive(Debug)]
pub struct CommonTree<R>(PartialTree<Image<R>>);

impl<R: Region> CommonTree<R> {
    /// Without any subtree yet, in the region that is made for so many bytes.
    pub fn new(
        outline: &[u8],
        make: impl FnOnce(usize) -> io::Result<R>,
    ) -> Result<Self, SubtreeError> {
        let within = |image, roots| {
            let parts = Parts::new(outline.len(), roots, image);
            let parts = parts.ok_or(io::ErrorKind::OutOfMemory)?;
            let region = make(parts.image.end)?;
            region.write(0, &(outline.len() as u64).to_ne_bytes())?;
            region.write(parts.outline.start, outline)?;
            Ok(Image { region, parts })
        };
        PartialTree::within(outline, within).map(Self)
    }

    /// Puts a subtree to its place; its number.
    pub fn add(&mut self, message: &[u8]) -> Result<u32, SubtreeError> {
        let root = self.0.add(message)?;
        let Image { region, parts } = self.0.within_memory();
        let written = region.write(parts.held.start + root as usize, &[1]);
        let bytes = parts.image.len() as u64;
        written.map_err(|source| SubtreeError::Memory { bytes, source })?;
        Ok(root)
    }
}

/// A worker's side.
#[derive(Debug)]
pub struct SeenTree<R>(PartialTree<Image<R>>);

impl<R: Deref<Target = [u8]>> SeenTree<R> {
    /// Of a region that a leader has made.
    pub fn new(region: R) -> Result<Self, SubtreeError> {
        let malformed = || SubtreeError::Malformed("no leader has made this");
        let length = region.first_chunk().map(|length| u64::from_ne_bytes(*length));
        let length = length.and_then(|length| usize::try_from(length).ok());
        let parts = length.and_then(|length| Parts::new(length, 0, 0)).ok_or_else(malformed)?;
        let outline = region.get(parts.outline).ok_or_else(malformed)?.to_vec();
        let find = |image, roots| {
            let parts = Parts::new(outline.len(), roots, image);
            let parts = parts.filter(|parts| parts.image.end == region.len());
            Ok(Image { region, parts: parts.ok_or_else(malformed)? })
        };
        let mut seen = Self(PartialTree::of_another(&outline, find)?);
        seen.look();
        Ok(seen)
    }

    /// Takes note of the subtrees that are here now.
    pub fn look(&mut self) {
        let (Image { region, parts }, held) = self.0.held_mut();
        for (held, flag) in held.iter_mut().zip(&region[parts.held.clone()]) {
            // SAFETY: a byte of the region, which the leader may be changing from 0 to 1.
            *held = unsafe { std::ptr::from_ref(flag).read_volatile() } == 1;
        }
    }

    /// Of the whole image.
    pub fn hash(&self) -> u64 {
        self.0.hash()
    }

    pub fn cut_tree(&self) -> CutTree<'_> {
        self.0.cut_tree()
    }

    /// The tree, if it was sent in one piece.
    pub fn whole(&self) -> Option<TreeView<'_>> {
        self.0.whole()
    }
}
