use super::MeshError;
use crate::geometry::{Point, Triangle};

/// At least one face, finite coordinates (metres), every index in range.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    vertices: Vec<Point>,
    faces: Vec<[u32; 3]>,
}

impl TriangleMesh {
    pub fn new(vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        let limit = (u32::MAX / 4) as usize;
        if vertices.len() > limit || faces.len() > limit {
            return Err(MeshError::TooMany(vertices.len().max(faces.len())));
        }
        if faces.is_empty() {
            return Err(MeshError::Empty);
        }
        for (index, vertex) in vertices.iter().enumerate() {
            if let Some(&value) = vertex.iter().find(|c| !c.is_finite()) {
                return Err(MeshError::NotFinite { index, value });
            }
        }
        for (face, corners) in faces.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&i| i as usize >= vertices.len()) {
                let (index, vertices) = (u64::from(index), vertices.len());
                return Err(MeshError::IndexOutOfRange { face, index, vertices });
            }
        }
        Ok(Self { vertices, faces })
    }

    pub fn vertices(&self) -> &[Point] {
        &self.vertices
    }

    /// Vertex indices, in file order: the position of a face is the triangle's number in results.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    pub fn triangle(&self, face: u32) -> Triangle {
        self.faces[face as usize].map(|i| self.vertices[i as usize])
    }

    /// In file order.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = Triangle> + '_ {
        (0..self.faces.len() as u32).map(|face| self.triangle(face))
    }

    /// The same vertices, and of the faces only these, which are there, in this order.
    pub fn of_triangles(&self, numbers: impl IntoIterator<Item = u32>) -> Self {
        let faces = numbers.into_iter().map(|number| self.faces[number as usize]).collect();
        Self { vertices: self.vertices.clone(), faces }
    }

    /// The offset is added to every vertex in f64.
    pub fn moved(self, offset: Point) -> Result<Self, MeshError> {
        if offset == [0.0; 3] {
            return Ok(self);
        }
        let add = |v: Point| [v[0] + offset[0], v[1] + offset[1], v[2] + offset[2]];
        Self::new(self.vertices.into_iter().map(add).collect(), self.faces)
    }

    /// XXH3 over counts, vertices and faces as little-endian bytes: the mesh's identity in the
    /// tree cache.
    pub fn content_hash(&self) -> u64 {
        let mut hasher = xxhash_rust::xxh3::Xxh3::new();
        hasher.update(&(self.vertices.len() as u64).to_le_bytes());
        hasher.update(bytemuck::cast_slice(&self.vertices));
        hasher.update(bytemuck::cast_slice(&self.faces));
        hasher.digest()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [Point; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, -0.0, 1.0]];

    #[test]
    fn degenerate_and_duplicate_triangles_are_legal() {
        let mesh = TriangleMesh::new(CORNERS.into(), vec![[0, 1, 2], [2, 1, 0], [1, 1, 1]]);
        assert_eq!(mesh.expect("legal").triangle(2), [CORNERS[1]; 3]);
    }

    #[test]
    fn what_is_not_a_mesh_is_refused() {
        let refusal = |vertices: &[Point], faces: &[[u32; 3]]| {
            TriangleMesh::new(vertices.into(), faces.into()).expect_err("no mesh").to_string()
        };
        assert_eq!(refusal(&CORNERS, &[]), "the mesh has no faces");
        let out = "triangle 1: vertex index 3 is out of range (the mesh has 3 vertices)";
        assert_eq!(refusal(&CORNERS, &[[0, 1, 2], [0, 3, 4]]), out);
        for (value, name) in [(f64::NAN, "NaN"), (f64::NEG_INFINITY, "-inf")] {
            let message = format!("vertex 3: coordinate {name} is not a finite number");
            let vertices = [&CORNERS[..], &[[0.0, value, 0.0]]].concat();
            assert_eq!(refusal(&vertices, &[[0, 1, 2]]), message);
        }
    }

    #[test]
    fn the_hash_tells_meshes_apart() {
        let hash = |faces| TriangleMesh::new(CORNERS.into(), faces).expect("legal").content_hash();
        assert_eq!(hash(vec![[0, 1, 2]]), hash(vec![[0, 1, 2]]));
        assert_ne!(hash(vec![[0, 1, 2]]), hash(vec![[0, 2, 1]]));
    }
}
