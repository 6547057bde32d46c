//! Mesh files of every format, good and hostile, and the report on a mesh.

mod formats;
mod gltf;
mod hostile;
mod obj;
mod ply;
mod report;
mod stl;
mod vrml;
mod writers;

use std::path::Path;

use bumper::mesh::report::MeshReport;
use bumper::mesh::{Format, MeshError, MeshSource, TriangleMesh};

fn load_path(path: &Path) -> Result<TriangleMesh, MeshError> {
    MeshSource::File(path.to_owned()).load()
}

/// Loads `bytes` as a file of this name in a directory of its own.
fn load(name: &str, bytes: impl AsRef<[u8]>) -> Result<TriangleMesh, MeshError> {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join(name);
    std::fs::write(&path, bytes).expect("a temporary file");
    load_path(&path)
}

/// As loading a file of this name, without the file.
fn parse(name: &str, bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    Format::of(name.as_ref(), bytes)?.parse(bytes, ".".as_ref())
}

/// The message of the error that loading must give.
fn refusal(name: &str, bytes: impl AsRef<[u8]>) -> String {
    match load(name, bytes) {
        Ok(mesh) => panic!("{name} was read as {} triangles", mesh.faces().len()),
        Err(error) => error.to_string(),
    }
}

#[track_caller]
fn assert_refused(name: &str, bytes: impl AsRef<[u8]>, message: &str) {
    let refusal = refusal(name, bytes);
    assert!(refusal.contains(message), "'{refusal}' does not say '{message}'");
}

/// Of all triangles together, wherever they overlap.
fn area(mesh: &TriangleMesh) -> f64 {
    MeshReport::of(&MeshSource::File("m".into()), None, mesh).surface_area_m2
}

fn triangles(mesh: &TriangleMesh) -> Vec<[[f64; 3]; 3]> {
    mesh.triangles().collect()
}
