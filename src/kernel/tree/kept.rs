//! A whole image together with what keeps its bytes alive.

use std::cell::OnceCell;
use std::ops::Deref;

use super::roots::{Cut, CutTree, DistributedRoot, distributed_roots};
use super::{Block, ImageError, TreeView};

/// A validated image wherever its bytes are, cut into subtrees.
#[derive(Debug)]
pub struct KeptTree<B> {
    bytes: B,
    /// Where the bytes were when they were validated.
    at: *const [u8],
    cut: Cut,
    /// Found when first asked for.
    roots: OnceCell<Vec<DistributedRoot>>,
}

impl<B: Deref<Target = [u8]>> KeptTree<B> {
    pub fn new(bytes: B, cut: Cut) -> Result<Self, ImageError> {
        let at: *const [u8] = &raw const *bytes;
        TreeView::new(as_blocks(&bytes)?)?;
        Ok(Self { bytes, at, cut, roots: OnceCell::new() })
    }

    /// # Panics
    /// If `B` moves its bytes about.
    pub fn view(&self) -> TreeView<'_> {
        let bytes: &[u8] = &self.bytes;
        assert!(std::ptr::eq(bytes, self.at), "these are the bytes that were validated");
        TreeView::validated(as_blocks(bytes).expect("they were blocks before"))
    }

    /// The tree with its distributed roots.
    pub fn cut(&self) -> CutTree<'_> {
        let view = self.view();
        CutTree::of_roots(view, self.roots.get_or_init(|| distributed_roots(&view, self.cut)))
    }
}

fn as_blocks(bytes: &[u8]) -> Result<&[Block], ImageError> {
    bytemuck::try_cast_slice(bytes)
        .map_err(|_| ImageError::Malformed("it is not whole blocks on a block's boundary"))
}
