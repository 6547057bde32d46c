use super::accessor;
use super::buffers::Bytes;
use super::document::{Document, Mesh, Primitive};
use crate::mesh::{FormatError, Problem};

/// One part of a mesh: triangles over the vertices of one position accessor.
pub struct Part {
    pub positions: usize,
    pub vertices: usize,
    pub faces: Vec<[u32; 3]>,
}

/// A mesh read once, however often it is placed.
pub struct Parts {
    pub parts: Vec<Part>,
    /// Points and lines, which have no surface.
    pub skipped: usize,
}

impl Parts {
    /// Asks `allow` about the size of each part, since many may repeat the same accessors.
    pub fn read(
        document: &Document,
        buffers: &[Bytes],
        index: usize,
        mut allow: impl FnMut(u64) -> Result<(), FormatError>,
    ) -> Result<Self, FormatError> {
        let mesh: &Mesh =
            document.meshes.get(index).ok_or_else(|| accessor::missing("mesh", index))?;
        let surfaces = mesh.primitives.iter().filter(|p| p.mode.unwrap_or(4) > 3);
        let mut parts = Vec::new();
        for primitive in surfaces {
            let part = read_part(document, buffers, index, primitive)?;
            allow(part.size())?;
            parts.push(part);
        }
        Ok(Self { skipped: mesh.primitives.len() - parts.len(), parts })
    }

    /// Vertices and triangles.
    pub fn size(&self) -> u64 {
        self.parts.iter().map(Part::size).sum()
    }
}

impl Part {
    fn size(&self) -> u64 {
        (self.vertices + self.faces.len()) as u64
    }
}

fn read_part(
    document: &Document,
    buffers: &[Bytes],
    mesh: usize,
    primitive: &Primitive,
) -> Result<Part, FormatError> {
    let at_mesh = |problem: Problem| problem.at_element("meshes", mesh);
    let Some(positions) = primitive.attributes.position else {
        return Err(at_mesh(Problem::Malformed("a primitive has no POSITION".into())));
    };
    let vertices = accessor::positions(document, buffers, positions)?.count;
    let corners: Vec<u32> = match primitive.indices {
        Some(index) => accessor::indices(document, buffers, index)?.indices().collect(),
        None => (0..u32::try_from(vertices).unwrap_or(u32::MAX)).collect(),
    };
    if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices) {
        return Err(at_mesh(Problem::IndexOutOfRange { index: index.into(), vertices }));
    }
    let faces = triangles(primitive.mode.unwrap_or(4), &corners).map_err(at_mesh)?;
    Ok(Part { positions, vertices, faces })
}

/// Triangles (mode 4), a strip (5) or a fan (6).
fn triangles(mode: u32, corners: &[u32]) -> Result<Vec<[u32; 3]>, Problem> {
    match mode {
        4 => match corners.as_chunks() {
            (faces, []) => Ok(faces.to_vec()),
            _ => {
                let problem = format!("{} corners do not make whole triangles", corners.len());
                Err(Problem::Malformed(problem))
            }
        },
        5 | 6 if corners.len() < 3 => Err(Problem::FewCorners(corners.len())),
        5 => {
            // Every other triangle of a strip is wound the other way.
            let turned = |(i, w): (usize, &[u32])| {
                if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] }
            };
            Ok(corners.windows(3).enumerate().map(turned).collect())
        }
        6 => Ok(corners[1..].windows(2).map(|w| [corners[0], w[0], w[1]]).collect()),
        _ => Err(Problem::Malformed(format!("primitive mode {mode} does not exist"))),
    }
}
