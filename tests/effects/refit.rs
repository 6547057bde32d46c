//! Refitted trees against trees that are built, and against brute force.

use bumper::geometry::simd::SimdLevel;
use bumper::geometry::{Point, Pose, Triangle};
use bumper::mesh::builtin::{Builtin, Model};
use bumper::mesh::{Dent, TriangleMesh, deform};
use bumper::tree::descent::{Descent, Pair};
use bumper::tree::{BuildOptions, Header, RefitError, TreeImage, TreeKind, TreeView, build, refit};
use proptest::prelude::*;

use super::oracle;

/// Faces that share vertices, as those of a vehicle do.
fn strip(vertices: Vec<Point>) -> TriangleMesh {
    let count = vertices.len() as u32;
    let faces = (0..count).map(|i| [i, (i * 7 + 1) % count, (i + 2) % count]).collect();
    TriangleMesh::new(vertices, faces).unwrap()
}

fn with_vertices(mesh: &TriangleMesh, at: impl Fn(usize, Point) -> Point) -> TriangleMesh {
    let vertices = mesh.vertices().iter().enumerate().map(|(i, &v)| at(i, v)).collect();
    TriangleMesh::new(vertices, mesh.faces().to_vec()).unwrap()
}

fn built(mesh: &TriangleMesh, kind: TreeKind) -> TreeImage {
    build(mesh, BuildOptions { kind })
}

/// After checking that the image is one that bytes from outside may be.
fn refitted(image: &TreeImage, mesh: &TriangleMesh) -> TreeImage {
    let mut refitted = image.clone();
    refit(&mut refitted, mesh).unwrap();
    let view = TreeView::new(refitted.blocks()).unwrap();
    let Header { mesh_hash, low, high, origin, unit, .. } = *view.header();
    assert_eq!(mesh_hash, mesh.content_hash());
    for v in view.vertices() {
        for k in 0..3 {
            assert!(low[k] <= v[k] && v[k] <= high[k]);
            assert!(((v[k] - origin[k]) / unit).abs() <= 1.0);
        }
    }
    let triangle = |rank: u32| (view.triangles()[rank as usize].id, view.corners(rank));
    for (id, corners) in (0..view.triangle_count()).map(triangle) {
        assert_eq!(corners, mesh.triangle(id));
    }
    refitted
}

/// With every instruction set, which all have to agree.
fn pairs(fixed: &TreeImage, moving: &TreeImage, pose: &Pose) -> Vec<Pair> {
    let of = |level: SimdLevel| {
        let mut pairs = Vec::new();
        let mut descent = Descent::with_simd(level);
        descent.all_pairs(&fixed.view(), &moving.view(), pose, &mut pairs).unwrap();
        let any = descent.any_pair(&fixed.view(), &moving.view(), pose).unwrap();
        assert_eq!(any, !pairs.is_empty());
        pairs.sort_unstable();
        pairs
    };
    let mut all = SimdLevel::available().into_iter().map(of);
    let first = all.next().expect("there is one for every processor");
    assert!(all.all(|other| other == first));
    first
}

fn triangles(mesh: &TriangleMesh) -> Vec<Triangle> {
    mesh.triangles().collect()
}

fn cloud() -> impl Strategy<Value = Vec<Point>> {
    prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 3..70)
}

/// Where to each vertex goes.
#[derive(Clone, Debug)]
enum Motion {
    /// All a little, or far beyond the frame.
    Shaken(Vec<Point>, f64),
    /// One alone.
    Plucked(usize, Point),
    /// Many together, so that faces become lines and points.
    Gathered(usize),
    /// Onto a coarse grid, so that faces touch.
    Snapped,
    Together(Point),
    /// About the origin.
    Scaled(f64),
}

impl Motion {
    fn apply(&self, mesh: &TriangleMesh) -> TriangleMesh {
        with_vertices(mesh, |i, v| match self {
            Self::Shaken(by, far) => [0, 1, 2].map(|k| v[k] + far * by[i % by.len()][k]),
            Self::Plucked(which, to) if i == which % mesh.vertices().len() => *to,
            Self::Plucked(..) => v,
            Self::Gathered(every) => mesh.vertices()[i - i % every],
            Self::Snapped => v.map(|c| (3.0 * c).round() / 3.0),
            Self::Together(by) => [0, 1, 2].map(|k| v[k] + by[k]),
            Self::Scaled(by) => v.map(|c| by * c),
        })
    }
}

fn motion() -> impl Strategy<Value = Motion> {
    let point = || prop::array::uniform3(-1.0..1.0_f64);
    let far = prop::sample::select(vec![1e-12, 1e-3, 0.3, 5.0, 1e4]);
    let scale = prop::sample::select(vec![0.0, 1e-9, 0.1, 0.9, -1.0, 3.0, 1e100]);
    prop_oneof![
        (prop::collection::vec(point(), 1..40), far).prop_map(|(by, far)| Motion::Shaken(by, far)),
        (0..70_usize, point()).prop_map(|(which, to)| Motion::Plucked(which, to)),
        (2..80_usize).prop_map(Motion::Gathered),
        Just(Motion::Snapped),
        point().prop_map(Motion::Together),
        scale.prop_map(Motion::Scaled),
    ]
}

fn pose() -> impl Strategy<Value = Pose> {
    (prop::array::uniform4(-1.0..1.0_f64), prop::array::uniform3(-0.5..0.5_f64)).prop_map(
        |(q, t)| {
            let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt().max(0.1);
            Pose::from_quaternion(q.map(|c| c / norm), t)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn a_refitted_tree_gives_the_pairs_of_a_built_one_and_of_brute_force(
        fixed in cloud(), moving in cloud(), motions in prop::collection::vec(motion(), 1..3),
        pose in pose(),
    ) {
        let (before, other) = (strip(fixed), strip(moving));
        let after = motions.iter().fold(before.clone(), |mesh, motion| motion.apply(&mesh));
        let expected = oracle::brute_force_pairs(&triangles(&after), &triangles(&other), &pose);
        for kind in TreeKind::ALL {
            let (tree, other) = (refitted(&built(&before, kind), &after), built(&other, kind));
            prop_assert_eq!(&pairs(&tree, &other, &pose), &expected);
            prop_assert_eq!(&pairs(&built(&after, kind), &other, &pose), &expected);
        }
    }

    #[test]
    fn a_tree_is_refitted_again_and_again(
        vertices in cloud(), motions in prop::collection::vec(motion(), 2..6), pose in pose(),
    ) {
        for kind in TreeKind::ALL {
            let mut mesh = strip(vertices.clone());
            let mut tree = built(&mesh, kind);
            for motion in &motions {
                let next = motion.apply(&mesh);
                if next.vertices().iter().flatten().any(|c| c.abs() > 1e150) {
                    break;
                }
                mesh = next;
                tree = refitted(&tree, &mesh);
            }
            let soup = triangles(&mesh);
            let expected = oracle::brute_force_pairs(&soup, &soup, &pose);
            prop_assert_eq!(pairs(&tree, &tree, &pose), expected);
        }
    }
}

#[test]
fn where_nothing_moves_the_image_stays_the_same_bytes() {
    let car = Builtin::new(Model::Car, 1_500).unwrap().mesh();
    for kind in TreeKind::ALL {
        let image = built(&car, kind);
        assert!(refitted(&image, &car) == image, "{kind}");
    }
}

/// On a grid, so that going there and back is exact.
#[test]
fn moved_as_a_whole_and_back_a_wide_tree_has_the_bytes_it_had() {
    let grid = |i: u32| [i * 37 % 83, i * 53 % 71, i * 29 % 61].map(|c| f64::from(c) / 64.0);
    let before = strip((0..500).map(grid).collect());
    let after = with_vertices(&before, |_, v| [v[0] + 0.125, v[1] - 0.25, v[2]]);
    let image = built(&before, TreeKind::Wide);
    let there = refitted(&image, &after);
    assert!(there != image);
    assert_eq!(there.view().header().origin, image.view().header().origin);
    assert!(refitted(&there, &before) == image);
}

#[test]
fn one_vertex_moves_only_its_leaves() {
    let before = Builtin::new(Model::Tracked, 3_000).unwrap().mesh();
    let which = 700;
    // Above the vehicle, out of every box it was in.
    let up = |i: usize| if i == which { 3.0 } else { 0.0 };
    let after = with_vertices(&before, |i, v| [v[0], v[1], v[2] + up(i)]);
    let uses = before.faces().iter().filter(|face| face.contains(&(which as u32))).count();
    assert!(uses > 0);
    let image = built(&before, TreeKind::Wide);
    let moved = refitted(&image, &after);
    let header = *image.view().header();
    let changed = |from: u64, to: u64, bytes: usize| {
        let [from, to] = [from, to].map(|at| at as usize / 64);
        let [old, new] = [&image, &moved].map(|image| image.blocks()[from..to].chunks(bytes / 64));
        old.zip(new).filter(|(old, new)| old != new).count()
    };
    let boxes = changed(header.leaf_boxes_at, header.leaf_rows_at, 64);
    let rows = changed(header.leaf_rows_at, header.triangles_at, 320);
    let nodes = changed(header.nodes_at, header.leaf_boxes_at, 256);
    assert!((1..=uses).contains(&rows) && boxes <= rows, "{rows} of {uses}");
    // The ways from there to the root.
    assert!((1..=12 * uses).contains(&nodes) && nodes < header.node_count as usize / 2, "{nodes}");
}

#[test]
fn a_mesh_that_leaves_its_frame_gets_another_one() {
    let before =
        strip((0..100).map(|i| [f64::from(i % 7), f64::from(i % 5), f64::from(i % 3)]).collect());
    let unit = |image: &TreeImage| image.view().header().unit;
    for kind in TreeKind::ALL {
        let image = built(&before, kind);
        for (scale, same) in [(0.5, true), (0.1, false), (1.9, false)] {
            let after = with_vertices(&before, |_, v| v.map(|c| c * scale));
            let expected = if same { unit(&image) } else { unit(&built(&after, kind)) };
            assert_eq!(unit(&refitted(&image, &after)), expected, "{scale}");
        }
        let far = with_vertices(&before, |_, v| v.map(|c| c + 1e6));
        let (found, wanted) = (refitted(&image, &far), built(&far, kind));
        assert_eq!(found.view().header().origin, wanted.view().header().origin);
    }
}

#[test]
fn a_dented_vehicle_touches_what_a_tree_built_for_it_touches() {
    let (car, carrier) = (
        Builtin::new(Model::Car, 2_000).unwrap().mesh(),
        Builtin::new(Model::Tracked, 2_000).unwrap().mesh(),
    );
    let front = car.vertices().iter().map(|v| v[0]).fold(f64::NEG_INFINITY, f64::max);
    let dent = Dent::new([front, 0.2, 0.5], [-1.0, 0.0, 0.0], 1.0, None, 0.4, 0.3).unwrap();
    let dented = deform(&car, &dent).unwrap();
    let back = carrier.vertices().iter().map(|v| v[0]).fold(f64::INFINITY, f64::min);
    for kind in TreeKind::ALL {
        let carrier = built(&carrier, kind);
        let trees =
            [refitted(&built(&car, kind), &dented), built(&dented, kind), built(&car, kind)];
        for gap in [-0.2, -0.45] {
            let turned =
                Pose::from_quaternion([1.0, 0.0, 0.0, 0.0], [front - back + gap, 0.1, 0.0]);
            let [refitted, built, whole] =
                trees.each_ref().map(|tree| pairs(tree, &carrier, &turned));
            assert_eq!(refitted, built);
            assert!(refitted.len() < whole.len());
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let before = Builtin::new(Model::Car, 5_000).unwrap().mesh();
    let after = with_vertices(&before, |i, v| v.map(|c| c + 0.01 * (i as f64).sin()));
    for kind in TreeKind::ALL {
        let image = built(&before, kind);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut refitted = image.clone();
            pool.install(|| refit(&mut refitted, &after).unwrap());
            refitted
        };
        assert!(on(1) == on(4), "{kind}");
    }
}

#[test]
fn a_mesh_with_other_faces_is_refused() {
    let mesh = strip((0..20).map(|i| [f64::from(i), f64::from(i * i % 7), 0.0]).collect());
    let vertices = mesh.vertices().to_vec();
    let mut fewer = mesh.faces().to_vec();
    fewer.pop();
    let mut others = mesh.faces().to_vec();
    others[11].swap(0, 1);
    for kind in TreeKind::ALL {
        let image = built(&mesh, kind);
        let refusal = |faces: &[[u32; 3]]| {
            let other = TriangleMesh::new(vertices.clone(), faces.to_vec()).unwrap();
            let mut unchanged = image.clone();
            let error = refit(&mut unchanged, &other).unwrap_err();
            assert!(unchanged == image);
            error
        };
        assert_eq!(refusal(&fewer), RefitError::Triangles { tree: 20, mesh: 19 });
        assert!(matches!(refusal(&others), RefitError::Faces(_)));
    }
}
