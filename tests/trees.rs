//! Trees against brute force, and images against damage.

mod oracle;

use bumper::geometry::{Point, Pose, Triangle};
use bumper::hardcases;
use bumper::mesh::TriangleMesh;
use bumper::tree::descent::{Descent, DescentError, Pair};
use bumper::tree::roots::{
    Cut, DistributedRoot, PreAnalysis, RootError, RootPair, distributed_roots,
};
use bumper::tree::{Block, BuildOptions, ImageError, TreeImage, TreeKind, TreeView, build};
use proptest::prelude::*;

const KINDS: [TreeKind; 3] = TreeKind::ALL;

fn mesh_of(triangles: &[Triangle]) -> TriangleMesh {
    let faces = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(triangles.as_flattened().to_vec(), faces).unwrap()
}

fn tree_of(triangles: &[Triangle], kind: TreeKind) -> TreeImage {
    build(&mesh_of(triangles), BuildOptions { kind })
}

/// The tree's answer, after checking that the early exit agrees with it.
fn contacts(fixed: &[Triangle], moving: &[Triangle], pose: &Pose, kind: TreeKind) -> Vec<Pair> {
    let (fixed, moving) = (tree_of(fixed, kind), tree_of(moving, kind));
    let (mut descent, mut pairs) = (Descent::default(), Vec::new());
    descent.all_pairs(&fixed.view(), &moving.view(), pose, &mut pairs).unwrap();
    let any = descent.any_pair(&fixed.view(), &moving.view(), pose).unwrap();
    assert_eq!(any, !pairs.is_empty());
    pairs.sort_unstable();
    pairs
}

#[test]
fn all_12800_triangle_pairs_are_right_as_meshes_of_one_triangle() {
    let mut wrong = Vec::new();
    for case in hardcases::pair_cases() {
        for kind in KINDS {
            let found = contacts(&[case.a], &[case.b], &Pose::IDENTITY, kind);
            if found.is_empty() == case.intersect() {
                wrong.push((case.family.clone(), kind));
            }
        }
    }
    assert_eq!(wrong, []);
}

#[test]
fn trees_of_1_to_100_triangles_find_what_brute_force_finds() {
    let mut random = TestNumbers(7);
    for size in 1..=100 {
        let (fixed, moving) = (random.soup(size), random.soup(101 - size));
        let pose = Pose::from_quaternion(random.quaternion(), random.point());
        let expected = oracle::brute_force_pairs(&fixed, &moving, &pose);
        for kind in KINDS {
            assert_eq!(contacts(&fixed, &moving, &pose, kind), expected, "{size} ({kind})");
        }
    }
}

/// Numbers from a linear congruential generator, the same everywhere.
struct TestNumbers(u64);

impl TestNumbers {
    /// In [-1, 1).
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn point(&mut self) -> Point {
        [self.next(), self.next(), self.next()]
    }

    fn soup(&mut self, size: usize) -> Vec<Triangle> {
        let corner = |at: Point, by: Point| [0, 1, 2].map(|i| at[i] + 0.4 * by[i]);
        (0..size)
            .map(|_| {
                let at = self.point();
                [(); 3].map(|()| corner(at, self.point()))
            })
            .collect()
    }

    fn quaternion(&mut self) -> [f64; 4] {
        let q = [(); 4].map(|()| self.next());
        let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
        q.map(|c| c / norm)
    }
}

/// Triangles on a coarse grid: many touch, many are degenerate, many are equal.
fn grid_soup() -> impl Strategy<Value = Vec<Triangle>> {
    let coordinate = (0..4_i32).prop_map(f64::from);
    let point = prop::array::uniform3(coordinate);
    prop::collection::vec(prop::array::uniform3(point), 1..24)
}

fn loose_soup() -> impl Strategy<Value = Vec<Triangle>> {
    let point = prop::array::uniform3(-1.0..1.0_f64);
    prop::collection::vec(prop::array::uniform3(point), 1..24)
}

fn quarter_turns() -> impl Strategy<Value = Pose> {
    let half = 0.5_f64;
    let turns = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [half; 4], [half, -half, half, half]];
    (prop::sample::select(turns.to_vec()), prop::array::uniform3(-2..3_i32))
        .prop_map(|(q, t)| Pose::from_quaternion(q, t.map(f64::from)))
}

/// Any matrix at all: the contract takes `R` as it is.
fn any_matrix() -> impl Strategy<Value = Pose> {
    (prop::array::uniform9(-2.0..2.0_f64), prop::array::uniform3(-1.0..1.0_f64))
        .prop_map(|(rotation, translation)| Pose { rotation, translation })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn touching_grids_give_what_brute_force_finds(
        fixed in grid_soup(), moving in grid_soup(), pose in quarter_turns(),
    ) {
        let expected = oracle::brute_force_pairs(&fixed, &moving, &pose);
        for kind in KINDS {
            prop_assert_eq!(&contacts(&fixed, &moving, &pose, kind), &expected);
        }
    }

    #[test]
    fn a_matrix_that_is_no_rotation_loses_no_contact(
        fixed in loose_soup(), moving in loose_soup(), pose in any_matrix(),
    ) {
        let expected = oracle::brute_force_pairs(&fixed, &moving, &pose);
        for kind in KINDS {
            prop_assert_eq!(&contacts(&fixed, &moving, &pose, kind), &expected);
        }
    }

    #[test]
    fn scaling_by_a_power_of_two_changes_nothing(
        fixed in grid_soup(), moving in grid_soup(), pose in quarter_turns(),
        exponent in -1000..1000_i32,
    ) {
        let factor = 2.0_f64.powi(exponent);
        let scaled = |soup: &[Triangle]| -> Vec<Triangle> {
            soup.iter().map(|t| t.map(|p| p.map(|c| c * factor))).collect()
        };
        let scaled_pose =
            Pose { translation: pose.translation.map(|c| c * factor), ..pose };
        for kind in KINDS {
            prop_assert_eq!(
                contacts(&scaled(&fixed), &scaled(&moving), &scaled_pose, kind),
                contacts(&fixed, &moving, &pose, kind)
            );
        }
    }

    #[test]
    fn swapping_the_meshes_swaps_the_pairs(fixed in grid_soup(), moving in grid_soup()) {
        for kind in KINDS {
            let mut swapped: Vec<Pair> = contacts(&moving, &fixed, &Pose::IDENTITY, kind)
                .into_iter().map(|[a, b]| [b, a]).collect();
            swapped.sort_unstable();
            prop_assert_eq!(swapped, contacts(&fixed, &moving, &Pose::IDENTITY, kind));
        }
    }

    #[test]
    fn every_contact_lies_below_a_pair_of_overlapping_roots(
        fixed in grid_soup(), moving in grid_soup(), pose in quarter_turns(),
        depths in (0..6_u32, 0..6_u32),
    ) {
        for kind in KINDS {
            let (a, b) = (tree_of(&fixed, kind), tree_of(&moving, kind));
            let mut analysis = PreAnalysis::new(a.view(), Cut::Depth(depths.0), b.view(), Cut::Depth(depths.1));
            let mut overlapping = Vec::new();
            analysis.overlapping_roots(&pose, &mut overlapping);
            let (of_fixed, of_moving) = (root_of(&a.view(), Cut::Depth(depths.0)), root_of(&b.view(), Cut::Depth(depths.1)));
            for [i, j] in contacts(&fixed, &moving, &pose, kind) {
                let roots = [of_fixed[i as usize], of_moving[j as usize]];
                prop_assert!(overlapping.contains(&roots));
            }
        }
    }

    #[test]
    fn below_all_overlapping_roots_lie_all_pairs_once(
        fixed in grid_soup(), moving in grid_soup(), pose in quarter_turns(),
        cuts in (any_cut(), any_cut()),
    ) {
        for kind in KINDS {
            let (a, b) = (tree_of(&fixed, kind), tree_of(&moving, kind));
            let mut analysis = PreAnalysis::new(a.view(), cuts.0, b.view(), cuts.1);
            let mut roots = Vec::new();
            analysis.overlapping_roots(&pose, &mut roots);
            let found = below(&analysis, &roots, &pose);
            prop_assert_eq!(found, contacts(&fixed, &moving, &pose, kind));
        }
    }

    #[test]
    fn below_some_roots_lie_the_pairs_of_their_triangles(
        soups in (loose_soup(), loose_soup()), pose in any_matrix(),
        cuts in (any_cut(), any_cut()), every in 1..5_usize,
    ) {
        for kind in KINDS {
            let (a, b) = (tree_of(&soups.0, kind), tree_of(&soups.1, kind));
            let analysis = PreAnalysis::new(a.view(), cuts.0, b.view(), cuts.1);
            let numbers = |roots: &[DistributedRoot]| 0..roots.len() as u32;
            let all = numbers(analysis.fixed_roots())
                .flat_map(|i| numbers(analysis.moving_roots()).map(move |j| [i, j]));
            let some: Vec<RootPair> = all.step_by(every).collect();
            let (of_a, of_b) = (root_of(&a.view(), cuts.0), root_of(&b.view(), cuts.1));
            let mut expected = contacts(&soups.0, &soups.1, &pose, kind);
            expected.retain(|&[i, j]| some.contains(&[of_a[i as usize], of_b[j as usize]]));
            prop_assert_eq!(below(&analysis, &some, &pose), expected);
        }
    }

    #[test]
    fn hostile_bytes_with_a_right_hash_never_panic(
        soup in loose_soup(), at in any::<prop::sample::Index>(), value in any::<u8>(),
    ) {
        for kind in KINDS {
            let mut blocks = tree_of(&soup, kind).blocks().to_vec();
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut blocks);
            let at = at.index(bytes.len());
            bytes[at] = value;
            let hash = xxhash_rust::xxh3::xxh3_64(&bytes[HASHED_FROM..]);
            bytes[HASHED_FROM - 8..HASHED_FROM].copy_from_slice(&hash.to_le_bytes());
            if let Ok(tree) = TreeView::new(&blocks) {
                let mut pairs = Vec::new();
                Descent::default().all_pairs(&tree, &tree, &Pose::IDENTITY, &mut pairs).unwrap();
                prop_assert!(pairs.len() <= soup.len() * soup.len());
            }
        }
    }
}

/// Where the hashed part of an image begins: after magic, version, kind, length and the hash.
const HASHED_FROM: usize = 32;

fn any_cut() -> impl Strategy<Value = Cut> {
    prop_oneof![(0..8_u32).prop_map(Cut::Depth), (0..30_u32).prop_map(Cut::Triangles)]
}

/// The pairs below roots, sorted.
fn below(analysis: &PreAnalysis<'_>, roots: &[RootPair], pose: &Pose) -> Vec<Pair> {
    let mut pairs = Vec::new();
    let (fixed, moving) = (analysis.fixed(), analysis.moving());
    Descent::default().all_pairs_below(fixed, moving, pose, roots, &mut pairs).unwrap();
    pairs.sort_unstable();
    pairs
}

/// Number of the distributed root above each triangle of the mesh.
fn root_of(tree: &TreeView<'_>, cut: Cut) -> Vec<u32> {
    let mut ids = tree.triangles().iter().map(|t| t.id);
    let mut roots = vec![u32::MAX; tree.triangle_count() as usize];
    for (number, root) in (0..).zip(distributed_roots(tree, cut)) {
        for id in ids.by_ref().take(root.triangles as usize) {
            roots[id as usize] = number;
        }
    }
    assert!(!roots.contains(&u32::MAX), "the roots cover the mesh");
    roots
}

#[test]
fn distributed_roots_are_numbered_left_to_right_and_at_most_two_to_the_depth() {
    let soup = TestNumbers(3).soup(500);
    for kind in KINDS {
        let tree = tree_of(&soup, kind);
        for depth in 0..12 {
            let roots = distributed_roots(&tree.view(), Cut::Depth(depth));
            assert!(roots.len() <= 1 << depth);
            // A wide tree's lanes point ahead: there the order is that of the triangles alone.
            assert!(kind == TreeKind::Wide || roots.is_sorted_by(|a, b| a.node < b.node));
            assert_eq!(roots.iter().map(|r| r.triangles).sum::<u32>(), 500);
            root_of(&tree.view(), Cut::Depth(depth));
        }
        let leaves = distributed_roots(&tree.view(), Cut::Depth(64));
        let most = if kind == TreeKind::Wide { 8 } else { 1 };
        assert!(leaves.iter().all(|leaf| (1..=most).contains(&leaf.triangles)));
    }
}

#[test]
fn a_tree_cut_by_triangles_has_the_highest_roots_that_are_small_enough() {
    let soup = TestNumbers(3).soup(500);
    for kind in KINDS {
        let tree = tree_of(&soup, kind);
        for most in [1, 7, 50, 499, 500] {
            let roots = distributed_roots(&tree.view(), Cut::Triangles(most));
            let leaf = if kind == TreeKind::Wide { 8 } else { 1 };
            assert!(roots.iter().all(|r| r.triangles <= most.max(leaf)));
            assert_eq!(roots.len() == 1, most == 500);
            assert_eq!(roots.iter().map(|r| r.triangles).sum::<u32>(), 500);
            root_of(&tree.view(), Cut::Triangles(most));
        }
    }
}

#[test]
fn roots_that_are_not_there_are_refused_and_named() {
    let tree = tree_of(&TestNumbers(3).soup(50), TreeKind::Wide);
    let analysis = PreAnalysis::new(tree.view(), Cut::Depth(1), tree.view(), Cut::Depth(0));
    let (fixed, moving) = (analysis.fixed(), analysis.moving());
    let mut pairs = Vec::new();
    let mut ask = |roots: RootPair| {
        Descent::default().all_pairs_below(fixed, moving, &Pose::IDENTITY, &[roots], &mut pairs)
    };
    let unknown = |tree, root, roots| {
        Err(DescentError::Root { tree, source: RootError::Unknown { root, roots } })
    };
    assert_eq!(ask([2, 0]), unknown("fixed", 2, 2));
    assert_eq!(ask([0, u32::MAX]), unknown("moving", u32::MAX, 1));
    assert_eq!(ask([1, 0]), Ok(()));
}

#[test]
fn pairs_without_end_of_roots_need_no_more_room_than_there_is() {
    // All triangles meet all, and there are more pairs of leaves than any queue has room for.
    let one = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let quarter = [0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0, 0.0];
    let pose = Pose::from_quaternion(quarter, [0.1, 0.2, -0.3]);
    let tree = tree_of(&[one; 1200], TreeKind::Wide);
    let cut = Cut::Triangles(8);
    let mut analysis = PreAnalysis::new(tree.view(), cut, tree.view(), cut);
    let mut roots = Vec::new();
    analysis.overlapping_roots(&pose, &mut roots);
    assert_eq!(roots.len(), analysis.fixed_roots().len().pow(2));
    let pairs = below(&analysis, &roots, &pose);
    assert!(pairs.len() == 1200 * 1200 && pairs.is_sorted_by(|a, b| a < b));
}

#[test]
fn an_image_is_the_same_on_any_number_of_cores() {
    let mesh = mesh_of(&TestNumbers(11).soup(20_000));
    for kind in KINDS {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| build(&mesh, BuildOptions { kind }))
        };
        assert!(on(1) == on(5), "{kind}");
    }
}

#[test]
fn an_image_is_a_right_one_wherever_its_bytes_lie() {
    for kind in KINDS {
        let image = tree_of(&TestNumbers(5).soup(64), kind);
        let elsewhere: Vec<Block> = image.blocks().to_vec();
        assert_eq!(TreeView::new(&elsewhere).unwrap().hash(), image.view().hash());
        assert_eq!(image.view().kind(), kind);
    }
}

#[test]
fn every_damaged_byte_and_every_missing_or_extra_block_is_refused() {
    for kind in KINDS {
        let image = tree_of(&TestNumbers(5).soup(20), kind);
        let length = image.blocks().len();
        for at in 0..64 * length {
            let mut blocks = image.blocks().to_vec();
            bytemuck::cast_slice_mut::<Block, u8>(&mut blocks)[at] ^= 1;
            assert!(TreeView::new(&blocks).is_err(), "byte {at} ({kind})");
        }
        for kept in 0..length {
            assert!(TreeView::new(&image.blocks()[..kept]).is_err(), "{kept} blocks ({kind})");
        }
        let mut extended = image.blocks().to_vec();
        extended.push(Block([0; 64]));
        assert!(matches!(TreeView::new(&extended), Err(ImageError::Length { .. })));
    }
}

#[test]
fn an_image_of_another_format_version_is_refused_by_its_number() {
    let mut blocks = tree_of(&TestNumbers(5).soup(20), TreeKind::Obb).blocks().to_vec();
    blocks[0].0[8..12].copy_from_slice(&77_u32.to_le_bytes());
    assert_eq!(TreeView::new(&blocks).unwrap_err(), ImageError::Version { found: 77 });
}

#[test]
fn a_pose_that_overflows_names_the_corner() {
    let near: Triangle = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let far = near.map(|p| p.map(|c| c * 1e308));
    let pose = Pose { translation: [1.7e308, 0.0, 0.0], ..Pose::IDENTITY };
    for kind in KINDS {
        let fixed = tree_of(&[near], kind);
        // Leaves are not in the order of the file.
        let moving = tree_of(&[near, far, far, near, far], kind);
        let found = Descent::default().any_pair(&fixed.view(), &moving.view(), &pose);
        assert_eq!(found, Err(DescentError::Overflow { triangle: 1, corner: 1 }));
    }
}

#[test]
fn trees_of_different_kinds_are_refused() {
    let soup = TestNumbers(5).soup(3);
    let (fixed, moving) = (tree_of(&soup, TreeKind::Obb), tree_of(&soup, TreeKind::Aabb));
    let found = Descent::default().any_pair(&fixed.view(), &moving.view(), &Pose::IDENTITY);
    assert_eq!(found, Err(DescentError::Kinds { fixed: TreeKind::Obb, moving: TreeKind::Aabb }));
}

#[test]
fn coordinates_far_from_zero_and_of_very_different_sizes_lose_no_contact() {
    let mut random = TestNumbers(23);
    let shifts = [0.0, 1e7, 1e12, 1e150];
    let scales = [1.0, 1e-6, 1e6, 1e-150, 1e150];
    for (shift, scale) in shifts.iter().flat_map(|s| scales.map(|k| (*s, k))) {
        let place = |t: &Triangle| t.map(|p| p.map(|c| c * scale + shift));
        let fixed: Vec<_> = random.soup(40).iter().map(place).collect();
        let moving: Vec<_> = random.soup(40).iter().map(place).collect();
        let expected = oracle::brute_force_pairs(&fixed, &moving, &Pose::IDENTITY);
        for kind in KINDS {
            let found = contacts(&fixed, &moving, &Pose::IDENTITY, kind);
            assert!(found == expected, "shift {shift}, scale {scale} ({kind})");
        }
    }
}

#[test]
fn points_and_specks_anywhere_lose_no_contact() {
    let mut random = TestNumbers(29);
    for (offset, size) in [(0.0, 0.0), (1e10, 0.0), (1e10, 1e-5), (1e300, 1e285), (1.0, 1e-320)] {
        let place = |t: &Triangle| t.map(|p| p.map(|c| c * size + offset));
        let soup: Vec<_> = random.soup(9).iter().map(place).collect();
        let expected = oracle::brute_force_pairs(&soup, &soup, &Pose::IDENTITY);
        assert!(expected.len() >= soup.len());
        for kind in KINDS {
            let found = contacts(&soup, &soup, &Pose::IDENTITY, kind);
            assert!(found == expected, "offset {offset}, size {size} ({kind})");
        }
    }
}
