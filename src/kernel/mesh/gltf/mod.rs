//! glTF 2.0 and its binary container GLB. The JSON is read by our own few structs so that node
//! transforms keep their f64 digits and every count is compared with the bytes behind it.

mod accessor;
mod buffers;
mod document;
mod primitive;
mod scene;

use std::collections::HashMap;
use std::path::Path;

use super::raw::RawMesh;
use super::text::without_byte_order_mark;
use super::{FormatError, Problem};
use document::Document;

const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

pub fn read_gltf(bytes: &[u8], directory: &Path) -> Result<RawMesh, FormatError> {
    read_document(without_byte_order_mark(bytes), None, directory, bytes.len())
}

pub fn read_glb(bytes: &[u8], directory: &Path) -> Result<RawMesh, FormatError> {
    let container = Container::parse(bytes)?;
    read_document(container.json, container.binary, directory, bytes.len())
}

fn read_document(
    json: &[u8],
    binary: Option<&[u8]>,
    directory: &Path,
    file_bytes: usize,
) -> Result<RawMesh, FormatError> {
    let document: Document = serde_json::from_slice(json)
        .map_err(|error| Problem::Malformed(format!("glTF JSON: {error}")).in_file())?;
    document.check_readable()?;
    let buffers = buffers::load(&document.buffers, binary, directory)?;
    // A file that several buffers name counts once.
    let distinct: HashMap<_, _> =
        buffers.iter().map(|b| (b.get().as_ptr(), b.get().len())).collect();
    scene::read(&document, &buffers, file_bytes + distinct.values().sum::<usize>())
}

struct Container<'a> {
    json: &'a [u8],
    binary: Option<&'a [u8]>,
}

impl<'a> Container<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let word = |at: usize| bytes.get(at..)?.first_chunk().map(|w| u32::from_le_bytes(*w));
        let header = (bytes.get(..4), word(4), word(8));
        let (Some(magic), Some(version), Some(length)) = header else {
            return Err(Problem::EndsWithin("the GLB header".into()).in_file());
        };
        if magic != b"glTF" {
            return Err(Problem::unexpected(magic, "the letters glTF").at_byte(0));
        }
        if version != 2 {
            return Err(unsupported_version(&version.to_string()).at_byte(4));
        }
        if length as usize != bytes.len() {
            let (promised, found) = (u64::from(length), bytes.len() as u64);
            return Err(count("bytes", promised, found).at_byte(8));
        }
        let (json, rest) = chunk(bytes, HEADER, b"JSON")?;
        let binary = match bytes.len() - rest {
            0 => None,
            _ => Some(chunk(bytes, rest, b"BIN\0")?.0),
        };
        Ok(Self { json, binary })
    }
}

/// The chunk that begins at `at`, and where the next one begins.
fn chunk<'a>(bytes: &'a [u8], at: usize, kind: &[u8; 4]) -> Result<(&'a [u8], usize), FormatError> {
    let header: &[u8; CHUNK_HEADER] = bytes[at..]
        .first_chunk()
        .ok_or_else(|| Problem::EndsWithin("a GLB chunk header".into()).at_byte(at))?;
    let ([length, found], _) = header.as_chunks::<4>() else { unreachable!("eight bytes") };
    if found != kind {
        return Err(Problem::unexpected(found, "the chunks JSON and BIN").at_byte(at + 4));
    }
    let content = &bytes[at + CHUNK_HEADER..];
    let length = u32::from_le_bytes(*length) as usize;
    let Some(chunk) = content.get(..length) else {
        return Err(count("bytes", length as u64, content.len() as u64).at_byte(at));
    };
    Ok((chunk, at + CHUNK_HEADER + length))
}

fn count(what: &str, promised: u64, found: u64) -> Problem {
    Problem::Count { what: what.into(), promised, unit: "bytes", found }
}

fn unsupported_version(version: &str) -> Problem {
    let what = format!("glTF version {version}");
    Problem::Unsupported { what, remedy: "convert the file to glTF 2.0" }
}
