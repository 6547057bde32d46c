//! Triangle meshes: the validated type, a reader per format, the built-in vehicles, the report.
//!
//! The readers are our own. The crates that were tried each break a promise made here: `stl_io`
//! rounds decimal text to f32, `gltf` rounds node transforms to f32 and reads bad accessors as
//! empty, `ply-rs-bw` rounds text of `float` properties and counts up to a lying header where
//! elements have no bytes, `tobj` regroups vertices, knows no line continuation and names no
//! line, `vrml97` overflows the stack on nested groups and drops prototype instances silently.

mod affine;
pub mod base64;
pub mod builtin;
pub mod closed;
mod deform;
mod error;
mod format;
mod gltf;
pub mod gzip;
mod instances;
mod obj;
mod ply;
mod polygon;
mod raw;
pub mod report;
mod source;
mod stl;
pub mod text;
mod triangle_mesh;
mod vrml;
mod weld;

pub use deform::{Dent, DentError, deform};
pub use error::{FormatError, MeshError, Place, Problem};
pub use format::Format;
pub use ply::write_ply;
pub use source::MeshSource;
pub use triangle_mesh::TriangleMesh;
pub use weld::{Welded, weld};
