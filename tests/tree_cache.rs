//! The cache of built trees: used when whole, rebuilt when not, never in the way.

use std::fs;
use std::path::Path;

use bumper::mesh::TriangleMesh;
use bumper::tree::cache::{CacheOutcome, file_path, load_or_build};
use bumper::tree::{BuildOptions, TreeKind, build};

const OPTIONS: BuildOptions = BuildOptions { kind: TreeKind::Obb };

/// A strip of triangles.
fn strip(triangles: u32) -> TriangleMesh {
    let vertex = |i: u32| [f64::from(i), f64::from(i % 2), f64::from(i % 3)];
    let vertices = (0..triangles + 2).map(vertex).collect();
    TriangleMesh::new(vertices, (0..triangles).map(|i| [i, i + 1, i + 2]).collect()).unwrap()
}

fn outcome(mesh: &TriangleMesh, directory: &Path) -> CacheOutcome {
    let (image, outcome) = load_or_build(mesh, OPTIONS, Some(directory));
    assert!(image == build(mesh, OPTIONS), "the cache changes no byte");
    outcome
}

#[test]
fn a_tree_is_built_once_and_then_read() {
    let directory = tempfile::tempdir().unwrap();
    let below = directory.path().join("not/yet/there");
    assert_eq!(outcome(&strip(50), &below), CacheOutcome::Built);
    assert_eq!(outcome(&strip(50), &below), CacheOutcome::Hit);
    assert_eq!(outcome(&strip(51), &below), CacheOutcome::Built);
    let names: Vec<_> = fs::read_dir(&below).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "no temporary file stays: {names:?}");
}

#[test]
fn each_tree_kind_has_a_file_of_its_own() {
    let directory = tempfile::tempdir().unwrap();
    let aabb = BuildOptions { kind: TreeKind::Aabb };
    assert_eq!(outcome(&strip(9), directory.path()), CacheOutcome::Built);
    assert_eq!(load_or_build(&strip(9), aabb, Some(directory.path())).1, CacheOutcome::Built);
    assert_eq!(load_or_build(&strip(9), aabb, Some(directory.path())).1, CacheOutcome::Hit);
}

#[test]
fn a_damaged_file_is_rebuilt_and_never_used() {
    let mesh = strip(50);
    let directory = tempfile::tempdir().unwrap();
    let path = file_path(directory.path(), mesh.content_hash(), OPTIONS);
    assert_eq!(outcome(&mesh, directory.path()), CacheOutcome::Built);
    let whole = fs::read(&path).unwrap();
    let mut flipped = whole.clone();
    *flipped.last_mut().unwrap() ^= 1;
    let mut older = whole.clone();
    older[8] = 0;
    let half = &whole[..whole.len() / 2];
    for damaged in [&[], &whole[..7], half, &flipped, &older, b"not a tree"] {
        fs::write(&path, damaged).unwrap();
        assert_eq!(outcome(&mesh, directory.path()), CacheOutcome::Rebuilt);
        assert_eq!(outcome(&mesh, directory.path()), CacheOutcome::Hit);
    }
}

#[test]
fn a_whole_file_of_another_mesh_is_not_taken_for_this_one() {
    let directory = tempfile::tempdir().unwrap();
    let (mesh, other) = (strip(50), strip(51));
    let path = |mesh: &TriangleMesh| file_path(directory.path(), mesh.content_hash(), OPTIONS);
    outcome(&other, directory.path());
    fs::rename(path(&other), path(&mesh)).unwrap();
    assert_eq!(outcome(&mesh, directory.path()), CacheOutcome::Rebuilt);
}

#[test]
fn a_directory_that_cannot_be_written_costs_only_the_cache() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("a file, no directory");
    fs::write(&file, "").unwrap();
    let (image, _) = load_or_build(&strip(5), OPTIONS, Some(&file));
    assert!(image == build(&strip(5), OPTIONS));
}

#[test]
fn without_a_directory_nothing_is_kept() {
    assert_eq!(load_or_build(&strip(5), OPTIONS, None).1, CacheOutcome::Off);
}
