//! VRML97 (`#VRML V2.0 utf8`), plain or gzip-compressed: the indexed faces of the scene graph.
//!
//! Nothing here recurses, so no depth of nesting can overflow the stack. What would silently be
//! missing from the mesh (prototype instances, inlined files, other shapes) is an error.

mod graph;
mod kind;
mod lexer;
mod node;
mod parser;
mod placement;
mod transform;

use super::gzip::decompressed;
use super::raw::RawMesh;
use super::text::without_byte_order_mark;
use super::{FormatError, Problem};

pub fn read(bytes: &[u8]) -> Result<RawMesh, FormatError> {
    let text = decompressed(bytes)?;
    let text = without_byte_order_mark(&text);
    let header = text.split(|b| matches!(b, b'\n' | b'\r')).next().unwrap_or_default();
    if !header.starts_with(b"#VRML V2.0 utf8") {
        return Err(Problem::unexpected(header, "the line #VRML V2.0 utf8").at_line(1));
    }
    let graph = parser::parse(text)?;
    placement::place(&graph, text.len())
}
