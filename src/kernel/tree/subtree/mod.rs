//! Subtrees as units that are sent, for transports that copy (section 6.3 of the paper: "not all
//! the nodes are known by the clients").
//!
//! The master describes the subtree below a distributed root as one range of every section of the
//! image, and writes it as one message. The receiver keeps the address space of the whole image and
//! puts what comes to its place, so that a descent reads a partial image as it reads a whole one;
//! what never came costs it nothing.

mod common_image;
mod compressed;
mod message;
mod outline;
mod pages;
mod partial;
mod sections;
mod span;

pub use common_image::{CommonTree, Region, SeenTree};
pub use compressed::compressed;
pub use outline::Subtrees;
pub use partial::PartialTree;

use std::io;

use super::ImageError;
use super::roots::RootError;

/// Grows with every change of the messages' meaning.
pub const MESSAGE_VERSION: u32 = 2;

#[derive(Debug, thiserror::Error)]
pub enum SubtreeError {
    #[error("not such a message of a tree (it does not start with the magic number)")]
    Magic,
    #[error("message of a tree of version {found}, this program reads {MESSAGE_VERSION}")]
    Version { found: u32 },
    #[error("message of a tree has {found} bytes, by what it says it should have {promised}")]
    Length { promised: u64, found: u64 },
    #[error("message of a tree is damaged: its hash is {found:016x}, it promises {promised:016x}")]
    Hash { promised: u64, found: u64 },
    #[error("subtree of the image {found:016x}, here is {here:016x}")]
    OtherImage { here: u64, found: u64 },
    #[error("the subtree below distributed root {found}, not {root}")]
    OtherRoot { root: u32, found: u32 },
    #[error(transparent)]
    Root(#[from] RootError),
    #[error("the subtree below distributed root {root} is here already")]
    Held { root: u32 },
    #[error(transparent)]
    Image(#[from] ImageError),
    #[error("message of a tree is malformed: {0}")]
    Malformed(&'static str),
    #[error("no room for a tree of {bytes} bytes: {source}")]
    Memory { bytes: u64, source: io::Error },
}
