use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

use crate::mesh::TriangleMesh;

/// Binary, coordinates in 64 bits: what is read back is the same mesh. The file appears when it is
/// whole.
pub fn write_ply(mesh: &TriangleMesh, path: &Path) -> io::Result<()> {
    let partial = path.with_extension("ply.partial");
    write(mesh, &partial).and_then(|()| fs::rename(&partial, path))
}

fn write(mesh: &TriangleMesh, path: &Path) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty \
         double y\nproperty double z\nelement face {}\nproperty list uchar uint \
         vertex_indices\nend_header\n",
        mesh.vertices().len(),
        mesh.faces().len()
    )?;
    for vertex in mesh.vertices() {
        vertex.iter().try_for_each(|c| file.write_all(&c.to_le_bytes()))?;
    }
    for face in mesh.faces() {
        file.write_all(&[3])?;
        face.iter().try_for_each(|corner| file.write_all(&corner.to_le_bytes()))?;
    }
    file.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_is_read_as_it_was_written() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("mesh.ply");
        let vertices = vec![[0.1, -0.0, 1e300], [1.0, 2.0, 3.0], [0.3, 5e-324, 7.0]];
        let mesh = TriangleMesh::new(vertices, vec![[0, 1, 2], [2, 1, 1]]).unwrap();
        write_ply(&mesh, &path).unwrap();
        let source: crate::mesh::MeshSource = path.to_str().unwrap().parse().unwrap();
        let read = source.load().unwrap();
        let bits = |mesh: &TriangleMesh| -> Vec<u64> {
            mesh.vertices().as_flattened().iter().map(|c| c.to_bits()).collect()
        };
        assert_eq!((bits(&read), read.faces()), (bits(&mesh), mesh.faces()));
    }
}
