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

use std::borrow::Cow;
use std::io::Read;

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

/// Scenes compress about five-fold; what grows far beyond that is made to exhaust memory.
fn decompressed(bytes: &[u8]) -> Result<Cow<'_, [u8]>, FormatError> {
    const ALWAYS_ALLOWED: u64 = 64 << 20;
    const MOST_GROWTH: u64 = 32;
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes.into());
    }
    let limit = ALWAYS_ALLOWED + MOST_GROWTH * bytes.len() as u64;
    let mut text = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes)
        .take(limit + 1)
        .read_to_end(&mut text)
        .map_err(|error| Problem::Malformed(format!("gzip: {error}")).in_file())?;
    if text.len() as u64 > limit {
        let problem = format!("the gzip data grows beyond {limit} bytes: decompress it first");
        return Err(Problem::TooLarge(problem).in_file());
    }
    Ok(text.into())
}
