//! Wavefront OBJ: `v` and `f` statements; appearance, names and groups are ignored.

use super::polygon::Polygons;
use super::raw::RawMesh;
use super::text::{Lines, integer, number, without_byte_order_mark, words};
use super::{FormatError, Problem};
use crate::geometry::Point;

/// Statements that carry no surface.
const IGNORED: [&[u8]; 34] = [
    b"vt",
    b"vn",
    b"vp",
    b"g",
    b"s",
    b"mg",
    b"o",
    b"usemtl",
    b"mtllib",
    b"usemap",
    b"maplib",
    b"bevel",
    b"c_interp",
    b"d_interp",
    b"lod",
    b"shadow_obj",
    b"trace_obj",
    b"ctech",
    b"stech",
    b"cstype",
    b"deg",
    b"bmat",
    b"step",
    b"curv",
    b"curv2",
    b"parm",
    b"trim",
    b"hole",
    b"scrv",
    b"sp",
    b"end",
    b"con",
    b"l",
    b"p",
];

pub fn read(bytes: &[u8]) -> Result<RawMesh, FormatError> {
    let mut reader = Reader::default();
    let mut lines = Lines::new(without_byte_order_mark(bytes));
    let mut statement = Vec::new();
    while let Some((number, line)) = lines.next() {
        statement.clear();
        statement.extend(words(line));
        if statement.first().is_none_or(|keyword| keyword[0] == b'#') {
            continue;
        }
        join_continued(&mut statement, &mut lines).map_err(|p| p.at_line(number))?;
        reader.statement(&statement, number).map_err(|p| p.at_line(number))?;
    }
    reader.finish()
}

/// A backslash at the end of a line goes on with the next line.
fn join_continued<'a>(
    words_so_far: &mut Vec<&'a [u8]>,
    lines: &mut Lines<'a>,
) -> Result<(), Problem> {
    while let Some(last) = words_so_far.last_mut()
        && let Some(stripped) = last.strip_suffix(b"\\")
    {
        *last = stripped;
        if stripped.is_empty() {
            words_so_far.pop();
        }
        let Some((_, line)) = lines.next() else {
            return Err(Problem::EndsWithin("a continued line".into()));
        };
        words_so_far.extend(words(line));
    }
    Ok(())
}

#[derive(Default)]
struct Reader {
    vertices: Vec<Point>,
    polygons: Polygons,
    polygon: Vec<u32>,
    /// The largest vertex index used, and its line: vertices may come after their faces.
    largest: Option<(u32, usize)>,
    skipped: usize,
}

impl Reader {
    fn statement(&mut self, words: &[&[u8]], line: usize) -> Result<(), Problem> {
        let comment = words.iter().position(|word| word[0] == b'#');
        let words = &words[..comment.unwrap_or(words.len())];
        let Some((&keyword, arguments)) = words.split_first() else { return Ok(()) };
        match keyword {
            b"v" => self.vertex(arguments),
            b"f" | b"fo" => self.face(arguments, line),
            b"surf" => Err(unsupported("a free-form surface", "convert it to faces")),
            b"call" | b"csh" => {
                Err(unsupported("another file or command", "put it into this file"))
            }
            _ if IGNORED.contains(&keyword) => {
                self.skipped += usize::from(matches!(keyword, b"l" | b"p" | b"curv"));
                Ok(())
            }
            _ => Err(Problem::unexpected(keyword, "an OBJ statement such as v or f")),
        }
    }

    /// `x y z`, then optionally a weight or a colour, or both.
    fn vertex(&mut self, arguments: &[&[u8]]) -> Result<(), Problem> {
        if !matches!(arguments.len(), 3 | 4 | 6 | 7) {
            let found = format!("{} numbers", arguments.len());
            return Err(Problem::Unexpected { found, expected: "the coordinates x y z" });
        }
        let [x, y, z] = [arguments[0], arguments[1], arguments[2]];
        self.vertices.push([number(x)?, number(y)?, number(z)?]);
        Ok(())
    }

    fn face(&mut self, arguments: &[&[u8]], line: usize) -> Result<(), Problem> {
        self.polygon.clear();
        for corner in arguments {
            let index = self.corner(corner)?;
            self.polygon.push(index);
            if self.largest.is_none_or(|(largest, _)| index > largest) {
                self.largest = Some((index, line));
            }
        }
        self.polygons.push(&self.polygon)
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`; counts from 1, or back from the last vertex so far.
    fn corner(&self, word: &[u8]) -> Result<u32, Problem> {
        let mut parts = word.split(|&b| b == b'/');
        let index = integer(parts.next().unwrap_or_default())?;
        for part in parts.filter(|part| !part.is_empty()) {
            integer(part)?;
        }
        let vertices = self.vertices.len();
        let from_zero =
            if index < 0 { index.checked_add(vertices as i64) } else { Some(index - 1) };
        from_zero
            .and_then(|i| u32::try_from(i).ok())
            .ok_or(Problem::IndexOutOfRange { index, vertices })
    }

    fn finish(self) -> Result<RawMesh, FormatError> {
        let vertices = self.vertices.len();
        if let Some((index, line)) = self.largest
            && index as usize >= vertices
        {
            let index = i64::from(index) + 1;
            return Err(Problem::IndexOutOfRange { index, vertices }.at_line(line));
        }
        if self.skipped > 0 {
            tracing::warn!("skipped {} points, lines and curves", self.skipped);
        }
        let faces = self.polygons.into_triangles(&self.vertices);
        Ok(RawMesh { vertices: self.vertices, faces })
    }
}

fn unsupported(what: &str, remedy: &'static str) -> Problem {
    Problem::Unsupported { what: what.into(), remedy }
}
