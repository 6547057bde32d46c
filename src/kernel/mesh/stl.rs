//! STL, text and binary. The format has no shared vertices: equal ones are welded.

use super::raw::RawMesh;
use super::text::{Lines, point, words};
use super::weld::weld;
use super::{FormatError, Problem};
use crate::geometry::Point;

/// 80 bytes of anything, then the number of triangles.
const HEADER: usize = 84;
/// A normal and three vertices of three f32 each, and two bytes of attributes.
const RECORD: usize = 50;

pub fn read(bytes: &[u8]) -> Result<RawMesh, FormatError> {
    let corners = if is_text(bytes) { read_text(bytes)? } else { read_binary(bytes)? };
    if u32::try_from(corners.len()).is_err() {
        let problem = format!("{} corners: at most {} are read", corners.len(), u32::MAX);
        return Err(Problem::TooLarge(problem).in_file());
    }
    let welded = weld(&corners);
    let faces = welded.index.as_chunks().0.to_vec();
    Ok(RawMesh { vertices: welded.points, faces })
}

/// Surely STL: text of its kind, or binary of exactly the promised length.
pub fn is_stl(bytes: &[u8]) -> bool {
    is_text(bytes) || promised(bytes).is_some_and(|n| bytes.len() as u64 == length(n))
}

fn promised(bytes: &[u8]) -> Option<u32> {
    bytes.get(80..)?.first_chunk().map(|count| u32::from_le_bytes(*count))
}

fn length(triangles: u32) -> u64 {
    HEADER as u64 + RECORD as u64 * u64::from(triangles)
}

/// Binary files may begin with `solid` too: text goes on with a keyword and has no NUL bytes.
fn is_text(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(1024)];
    let mut lines = Lines::new(head).map(|(_, line)| line.trim_ascii()).filter(|l| !l.is_empty());
    let keyword = |line: &[u8], word: &[u8]| {
        line.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
    };
    lines.next().is_some_and(|line| keyword(line, b"solid"))
        && !head.contains(&0)
        && lines.next().is_none_or(|line| keyword(line, b"facet") || keyword(line, b"endsolid"))
}

fn read_binary(bytes: &[u8]) -> Result<Vec<Point>, FormatError> {
    let Some(promised) = promised(bytes) else {
        return Err(Problem::EndsWithin("the 84 bytes of a binary STL header".into()).in_file());
    };
    let body = &bytes[HEADER..];
    if bytes.len() as u64 != length(promised) {
        let found = (body.len() / RECORD) as u64;
        if found == u64::from(promised) {
            return Err(Problem::Trailing { bytes: body.len() % RECORD }.in_file());
        }
        let (what, promised) = ("triangles".into(), u64::from(promised));
        return Err(Problem::Count { what, promised, unit: "bytes", found }.in_file());
    }
    let mut corners = Vec::with_capacity(3 * promised as usize);
    for (triangle, record) in body.as_chunks::<RECORD>().0.iter().enumerate() {
        let (coordinates, _) = record[12..48].as_chunks::<4>();
        for corner in coordinates.as_chunks::<3>().0 {
            let corner = corner.map(|c| f64::from(f32::from_le_bytes(c)));
            if let Some(&value) = corner.iter().find(|c| !c.is_finite()) {
                return Err(Problem::NotFinite(value).at_byte(HEADER + RECORD * triangle));
            }
            corners.push(corner);
        }
    }
    Ok(corners)
}

/// What the next line of a text file must be.
#[derive(Clone, Copy, PartialEq)]
enum Expected {
    Solid,
    FacetOrEnd,
    OuterLoop,
    Vertex(u8),
    EndLoop,
    EndFacet,
}

impl Expected {
    fn name(self) -> &'static str {
        match self {
            Self::Solid => "solid",
            Self::FacetOrEnd => "facet or endsolid",
            Self::OuterLoop => "outer loop",
            Self::Vertex(_) => "vertex",
            Self::EndLoop => "endloop (a facet has three vertices)",
            Self::EndFacet => "endfacet",
        }
    }
}

fn read_text(bytes: &[u8]) -> Result<Vec<Point>, FormatError> {
    let mut corners = Vec::new();
    let mut expected = Expected::Solid;
    for (number, line) in Lines::new(bytes) {
        let mut words = words(line);
        let Some(keyword) = words.next() else { continue };
        expected = match (expected, keyword.to_ascii_lowercase().as_slice()) {
            (Expected::Solid, b"solid") => Expected::FacetOrEnd,
            (Expected::FacetOrEnd, b"endsolid") => Expected::Solid,
            (Expected::FacetOrEnd, b"facet") => Expected::OuterLoop,
            (Expected::OuterLoop, b"outer") => Expected::Vertex(0),
            (Expected::Vertex(i), b"vertex") => {
                corners.push(point(words).map_err(|p| p.at_line(number))?);
                if i < 2 { Expected::Vertex(i + 1) } else { Expected::EndLoop }
            }
            (Expected::EndLoop, b"endloop") => Expected::EndFacet,
            (Expected::EndFacet, b"endfacet") => Expected::FacetOrEnd,
            _ => return Err(Problem::unexpected(keyword, expected.name()).at_line(number)),
        };
    }
    match expected {
        Expected::Solid => Ok(corners),
        _ => Err(Problem::EndsWithin("a solid: endsolid is missing".into()).in_file()),
    }
}
