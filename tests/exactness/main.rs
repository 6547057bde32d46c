//! The exactness contract: the pair test and every way through two trees against an oracle in
//! integers without limit, which knows no geometry.

mod boundary;
mod construction;
mod metamorphic;
#[path = "../oracle/mod.rs"]
mod oracle;
mod pairs;
mod stability;
mod suite;
mod suite_files;

use std::cell::RefCell;
use std::collections::BTreeMap;

use bumper::geometry::simd::SimdLevel;
use bumper::geometry::triangle::{StaticFilter, triangles_intersect};
use bumper::geometry::{Pose, Triangle};
use bumper::mesh::TriangleMesh;
use bumper::tree::descent::{Descent, Pair};
use bumper::tree::{BuildOptions, TreeKind, build};
use oracle::{hulls_meet, tight_filter};
use proptest::prelude::*;

/// A hundred thousand in the long form.
fn config(quick: u32) -> ProptestConfig {
    let long = std::env::var_os("BUMPER_LONG_TESTS").is_some();
    let cases = if long { 100_000 } else { quick };
    ProptestConfig { cases, max_global_rejects: 40 * cases, ..ProptestConfig::default() }
}

fn mesh_of(triangles: &[Triangle]) -> TriangleMesh {
    let faces = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(triangles.as_flattened().to_vec(), faces).unwrap()
}

thread_local! {
    /// Every kind of tree and, for wide trees, every instruction set. Kept, as each has much room.
    static WAYS: RefCell<Vec<(TreeKind, SimdLevel, Descent)>> = RefCell::new(ways());
}

fn ways() -> Vec<(TreeKind, SimdLevel, Descent)> {
    let of_kind = |kind| {
        let wide = kind == TreeKind::Wide;
        let levels = if wide { SimdLevel::available() } else { vec![SimdLevel::Portable] };
        levels.into_iter().map(move |level| (kind, level, Descent::with_simd(level)))
    };
    TreeKind::ALL.into_iter().flat_map(of_kind).collect()
}

/// The sorted pairs by each.
fn in_every_way(
    fixed: &[Triangle],
    moving: &[Triangle],
    pose: &Pose,
) -> BTreeMap<String, Vec<Pair>> {
    let meshes = [fixed, moving].map(mesh_of);
    let images = TreeKind::ALL
        .map(|kind| (kind, meshes.each_ref().map(|mesh| build(mesh, BuildOptions { kind }))));
    let find = |&mut (kind, level, ref mut descent): &mut (TreeKind, SimdLevel, Descent)| {
        let (_, images) = images.iter().find(|(of, _)| *of == kind).unwrap();
        let [fixed, moving] = images.each_ref().map(|image| image.view());
        let mut pairs = Vec::new();
        descent.all_pairs(&fixed, &moving, pose, &mut pairs).unwrap();
        let any = descent.any_pair(&fixed, &moving, pose).unwrap();
        assert_eq!(any, !pairs.is_empty(), "{kind} {level}");
        pairs.sort_unstable();
        (format!("{kind} {level}"), pairs)
    };
    WAYS.with_borrow_mut(|ways| ways.iter_mut().map(find).collect())
}

#[track_caller]
fn assert_pairs(expected: &[Pair], fixed: &[Triangle], moving: &[Triangle], pose: &Pose) {
    for (way, found) in in_every_way(fixed, moving, pose) {
        assert!(found == expected, "{way}: {found:?} for {expected:?}");
    }
}

/// The pair test with a filter and without, and the same two triangles as meshes.
fn assert_answer(a: &Triangle, b: &Triangle, truth: bool) -> Result<(), TestCaseError> {
    let tight = tight_filter(a.iter().chain(b));
    for filter in [tight, StaticFilter::OFF] {
        let answer = triangles_intersect(a, b, &filter);
        prop_assert_eq!(answer, truth, "with {:?}: {:?} {:?}", filter, a, b);
    }
    for (way, pairs) in in_every_way(&[*a], &[*b], &Pose::IDENTITY) {
        prop_assert_eq!(!pairs.is_empty(), truth, "{}: {:?} {:?}", way, a, b);
    }
    Ok(())
}

fn assert_agrees(a: &Triangle, b: &Triangle) -> Result<(), TestCaseError> {
    assert_answer(a, b, hulls_meet(a, b))
}
