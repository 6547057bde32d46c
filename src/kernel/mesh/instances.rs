use super::affine::Affine;
use super::raw::RawMesh;
use super::{FormatError, Problem};
use crate::geometry::Point;

/// Collects the placed geometry of a scene graph.
///
/// A scene may use one piece of geometry many times, so that a small file can mean more
/// triangles than any memory holds: what it expands to is limited.
pub struct Instances {
    mesh: RawMesh,
    limit: usize,
}

/// Vertices, triangles and nodes together that any scene may expand to; larger files may expand
/// to one for each of their bytes, which no scene without repetition exceeds.
const EXPANSION_LIMIT: usize = 1 << 25;

impl Instances {
    pub fn new(file_bytes: usize) -> Self {
        Self {
            mesh: RawMesh::default(),
            limit: file_bytes.clamp(EXPANSION_LIMIT, u32::MAX as usize),
        }
    }

    pub fn allow(&self, size: u64) -> Result<(), FormatError> {
        if size <= self.limit as u64 {
            return Ok(());
        }
        let what = format!("the scene expands to {size} nodes, vertices and triangles");
        Err(Problem::TooLarge(format!("{what}; at most {} are read", self.limit)).in_file())
    }

    /// Adds vertices and returns the index of the first one.
    pub fn place(
        &mut self,
        affine: &Affine,
        points: impl ExactSizeIterator<Item = Point>,
    ) -> Result<u32, Problem> {
        let first = self.mesh.vertices.len() as u32;
        self.mesh.vertices.reserve(points.len());
        for point in points {
            if let Some(&value) = point.iter().find(|c| !c.is_finite()) {
                return Err(Problem::NotFinite(value));
            }
            let placed = affine.apply(point);
            if !placed.iter().all(|c| c.is_finite()) {
                return Err(Problem::Overflow);
            }
            self.mesh.vertices.push(placed);
        }
        Ok(first)
    }

    /// Adds triangles whose indices count from `first`; mirrored ones keep their outer side.
    pub fn connect(&mut self, affine: &Affine, first: u32, faces: &[[u32; 3]]) {
        let mirrored = affine.mirrors();
        self.mesh.faces.extend(faces.iter().map(|&[a, b, c]| {
            let [a, b, c] = [a + first, b + first, c + first];
            if mirrored { [a, c, b] } else { [a, b, c] }
        }));
    }

    pub fn finish(self) -> RawMesh {
        self.mesh
    }
}
