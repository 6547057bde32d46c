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

/// The sorted pairs by every kind of tree and, for wide trees, every instruction set.
fn in_every_way(
    fixed: &[Triangle],
    moving: &[Triangle],
    pose: &Pose,
) -> BTreeMap<String, Vec<Pair>> {
    let mut found = BTreeMap::new();
    let meshes = [fixed, moving].map(mesh_of);
    for kind in TreeKind::ALL {
        let images = meshes.each_ref().map(|mesh| build(mesh, BuildOptions { kind }));
        let [fixed, moving] = images.each_ref().map(|image| image.view());
        let wide = kind == TreeKind::Wide;
        let levels = if wide { SimdLevel::available() } else { vec![SimdLevel::Portable] };
        for level in levels {
            let (mut descent, mut pairs) = (Descent::with_simd(level), Vec::new());
            descent.all_pairs(&fixed, &moving, pose, &mut pairs).unwrap();
            let any = descent.any_pair(&fixed, &moving, pose).unwrap();
            assert_eq!(any, !pairs.is_empty(), "{kind} {level}");
            pairs.sort_unstable();
            found.insert(format!("{kind} {level}"), pairs);
        }
    }
    found
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
