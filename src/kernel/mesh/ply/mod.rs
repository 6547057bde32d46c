//! PLY: vertex and face elements in any order and of any numeric types; everything else in the
//! file is stepped over.

mod body;
mod header;
mod write;

use super::polygon::Polygons;
use super::raw::RawMesh;
use super::{FormatError, Problem};
use body::{BinaryCursor, Cursor, TextCursor};
pub use write::write_ply;

use header::{Element, Encoding, Header, Property, Type};

pub fn read(bytes: &[u8]) -> Result<RawMesh, FormatError> {
    let header = Header::parse(bytes)?;
    let body = &bytes[header.length..];
    match header.encoding {
        Encoding::Text => read_elements(&header, TextCursor::new(body, header.lines)),
        Encoding::Little => read_elements(&header, BinaryCursor::<false>::new(body, header.length)),
        Encoding::Big => read_elements(&header, BinaryCursor::<true>::new(body, header.length)),
    }
}

fn read_elements<C: Cursor>(header: &Header, mut cursor: C) -> Result<RawMesh, FormatError> {
    let mut mesh = RawMesh::default();
    let mut polygons = Polygons::default();
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut cursor, &mut mesh)?,
            "face" => {
                read_faces(element, &mut cursor, mesh.vertices.len(), &mut polygons)?;
            }
            "tristrips" if element.count > 0 => {
                let what = "the element tristrips".into();
                let remedy = "convert the strips to faces";
                return Err(Problem::Unsupported { what, remedy }.in_file());
            }
            _ => each(element, &mut cursor, |cursor| {
                element.properties.iter().try_for_each(|property| skip(property, cursor))
            })?,
        }
    }
    cursor.finish()?;
    mesh.faces = polygons.into_triangles(&mesh.vertices);
    Ok(mesh)
}

/// Runs `read` once for each of the element's instances. The end of the file is a wrong count.
fn each<C: Cursor>(
    element: &Element,
    cursor: &mut C,
    mut read: impl FnMut(&mut C) -> Result<(), Problem>,
) -> Result<(), FormatError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for found in 0..element.count {
        let outcome = cursor.begin().and_then(|()| read(cursor)).and_then(|()| cursor.end());
        outcome.map_err(|problem| match problem {
            Problem::EndsWithin(_) => {
                let (what, promised) = (element.plural(), element.count);
                Problem::Count { what, promised, unit: C::UNIT, found }.in_file()
            }
            problem => problem.at(cursor.place()),
        })?;
    }
    Ok(())
}

fn read_vertices<C: Cursor>(
    element: &Element,
    cursor: &mut C,
    mesh: &mut RawMesh,
) -> Result<(), FormatError> {
    let axis = |property: &Property| ["x", "y", "z"].iter().position(|a| *a == property.name);
    let axes: Vec<Option<usize>> = element.properties.iter().map(axis).collect();
    for (i, name) in ["x", "y", "z"].iter().enumerate() {
        if axes.iter().filter(|axis| **axis == Some(i)).count() != 1 {
            let problem = format!("the vertex element needs one property {name}");
            return Err(Problem::Malformed(problem).in_file());
        }
    }
    mesh.vertices.reserve(cursor.capacity(element));
    each(element, cursor, |cursor| {
        let mut vertex = [0.0; 3];
        for (property, axis) in element.properties.iter().zip(&axes) {
            match (axis, property.kind) {
                (Some(axis), Type::Scalar(scalar)) => vertex[*axis] = cursor.float(scalar)?,
                (Some(_), Type::List { .. }) => {
                    let found = format!("a list as vertex property {}", property.name);
                    return Err(Problem::Unexpected { found, expected: "a number" });
                }
                (None, _) => skip(property, cursor)?,
            }
        }
        mesh.vertices.push(vertex);
        Ok(())
    })
}

fn read_faces<C: Cursor>(
    element: &Element,
    cursor: &mut C,
    vertices: usize,
    polygons: &mut Polygons,
) -> Result<(), FormatError> {
    let is_corners = |p: &Property| matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    if element.count > 0 && element.properties.iter().filter(|p| is_corners(p)).count() != 1 {
        let problem = "the face element needs one list vertex_indices (or vertex_index)";
        return Err(Problem::Malformed(problem.into()).in_file());
    }
    polygons.reserve(cursor.capacity(element));
    let mut polygon = Vec::new();
    each(element, cursor, |cursor| {
        for property in &element.properties {
            match property.kind {
                Type::List { count, item } if is_corners(property) => {
                    polygon.clear();
                    for _ in 0..list_length(cursor.integer(count)?)? {
                        let index = cursor.integer(item)?;
                        let corner = u32::try_from(index)
                            .map_err(|_| Problem::IndexOutOfRange { index, vertices })?;
                        polygon.push(corner);
                    }
                    polygons.push(&polygon)?;
                }
                _ if is_corners(property) => {
                    let found = "a single number as vertex_indices".into();
                    return Err(Problem::Unexpected { found, expected: "a list" });
                }
                _ => skip(property, cursor)?,
            }
        }
        Ok(())
    })
}

fn skip<C: Cursor>(property: &Property, cursor: &mut C) -> Result<(), Problem> {
    match property.kind {
        Type::Scalar(scalar) => cursor.skip(scalar, 1),
        Type::List { count, item } => {
            let length = list_length(cursor.integer(count)?)?;
            cursor.skip(item, length)
        }
    }
}

fn list_length(count: i64) -> Result<u64, Problem> {
    u64::try_from(count).map_err(|_| Problem::Malformed(format!("a list of length {count}")))
}
