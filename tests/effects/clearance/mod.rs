//! The smallest distance and all pairs within a margin, by every kind of tree and instruction set.

mod closed_forms;
mod relations;

use bumper::geometry::distance::triangle_distance;
use bumper::geometry::simd::SimdLevel;
use bumper::geometry::{Point, Pose, Triangle};
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::tree::descent::{Descent, DescentError};
use bumper::tree::nearest::{Clearance, Clearest, Near, Tolerance};
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};

use super::random::Random;

impl Random {
    /// Triangles of different sizes, some of them thin, segments or points.
    fn soup(&mut self, count: usize) -> Vec<Triangle> {
        let triangle = |random: &mut Self| {
            let (center, size) = (random.point(), 0.5_f64.powi(random.below(5) as i32));
            let mut triangle = [(); 3].map(|()| {
                let p = random.point();
                [0, 1, 2].map(|k| center[k] + size * p[k])
            });
            let shrink = [1.0, 1.0, 1e-3, 1e-9, 0.0][random.below(5) as usize];
            let corner = triangle[0];
            triangle[2] = [0, 1, 2].map(|k| corner[k] + shrink * (triangle[2][k] - corner[k]));
            if random.below(16) == 0 {
                triangle[1] = triangle[2];
            }
            triangle
        };
        (0..count).map(|_| triangle(self)).collect()
    }
}

fn mesh(triangles: &[Triangle]) -> TriangleMesh {
    let faces = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(triangles.as_flattened().to_vec(), faces).unwrap()
}

fn images(meshes: [&TriangleMesh; 2], kind: TreeKind) -> [TreeImage; 2] {
    meshes.map(|mesh| build(mesh, BuildOptions { kind }))
}

fn triangles(mesh: &TriangleMesh) -> Vec<Triangle> {
    mesh.faces().iter().map(|face| face.map(|v| mesh.vertices()[v as usize])).collect()
}

fn mapped(soup: &[Triangle], map: impl Fn(Point) -> Point) -> Vec<Triangle> {
    soup.iter().map(|t| t.map(&map)).collect()
}

/// All pairs, in their order.
fn every_pair([fixed, moving]: [&TriangleMesh; 2], pose: &Pose) -> Vec<Near> {
    let placed = mapped(&triangles(moving), |p| pose.apply(p));
    let mut all = Vec::new();
    for (i, a) in triangles(fixed).iter().enumerate() {
        for (j, b) in placed.iter().enumerate() {
            let nearest = triangle_distance(a, b);
            let pair = [i as u32, j as u32];
            all.push(Near { pair, distance_m: nearest.distance, points: nearest.points });
        }
    }
    all
}

fn least(all: &[Near]) -> Near {
    let by_distance = |a: &&Near, b: &&Near| a.distance_m.total_cmp(&b.distance_m);
    // Of equal ones the first.
    *all.iter().min_by(by_distance).expect("a mesh has a triangle")
}

fn smallest(clearance: &mut Clearance, images: &[TreeImage; 2], pose: &Pose) -> Clearest {
    let [a, b] = images.each_ref().map(TreeImage::view);
    clearance.smallest(&a, &b, pose, Tolerance::NONE).unwrap()
}

/// By all means the same as by trying every pair, bit for bit; with margins that divide the pairs.
fn assert_like_every_pair(meshes: [&TriangleMesh; 2], pose: &Pose) -> Near {
    let all = every_pair(meshes, pose);
    let nearest = least(&all);
    let mut distances: Vec<f64> = all.iter().map(|near| near.distance_m).collect();
    distances.sort_by(f64::total_cmp);
    let margins = [0, distances.len() / 50, distances.len() / 3].map(|at| distances[at]);
    for kind in TreeKind::ALL {
        let images = images(meshes, kind);
        let [a, b] = images.each_ref().map(TreeImage::view);
        for level in SimdLevel::available() {
            let mut clearance = Clearance::with_simd(level);
            let found = smallest(&mut clearance, &images, pose);
            assert_eq!(found.nearest, nearest, "{kind} {level}");
            assert!(found.lower_bound_m <= nearest.distance_m, "{found:?}");
            let mut within = Vec::new();
            for margin in margins {
                clearance.within(&a, &b, pose, margin, &mut within).unwrap();
                let expected: Vec<Near> =
                    all.iter().filter(|near| near.distance_m <= margin).copied().collect();
                assert!(within == expected, "{kind} {level} {margin}");
            }
        }
    }
    nearest
}

#[test]
fn random_meshes_have_the_distance_of_their_nearest_triangles() {
    let mut random = Random::new(1);
    let mut apart = 0;
    for size in [1, 2, 7, 8, 9, 17, 30, 45] {
        for away in [0.5, 2.5] {
            let (a, b) = (mesh(&random.soup(size)), mesh(&random.soup(1 + size / 2)));
            let nearest = assert_like_every_pair([&a, &b], &random.pose(away));
            apart += usize::from(nearest.distance_m > 0.0);
        }
    }
    assert!((4..16).contains(&apart), "{apart} of 16 are apart");
}

#[test]
fn of_pairs_at_equal_distances_the_first_is_reported() {
    let mut random = Random::new(2);
    for (size, away) in [(9, 0.0), (20, 0.0), (20, 1.25), (40, 1.0), (40, 3.0)] {
        let (a, b) = (mesh(&random.on_grid(size, 4)), mesh(&random.on_grid(size, 4)));
        let pose = Pose { translation: [away, 0.0, 0.0], ..Pose::IDENTITY };
        let nearest = assert_like_every_pair([&a, &b], &pose);
        assert_eq!(nearest.distance_m == 0.0, away < 0.76, "{nearest:?}");
    }
}

#[test]
fn meshes_far_from_the_origin_and_at_any_scale_have_their_distance() {
    let mut random = Random::new(3);
    for (place, scale) in [(1e5, 1.0), (1e9, 1.0), (0.0, 1e-12), (1e3, 1e60), (0.0, 1e-170)] {
        let moved = |p: Point| [0, 1, 2].map(|k| (p[k] + [1.0, -2.0, 3.0][k] * place) * scale);
        let soups = [20, 12].map(|size| mesh(&mapped(&random.soup(size), moved)));
        let away = [0, 1, 2].map(|k| [1.6, 0.3, 0.2][k] * scale);
        assert_like_every_pair(soups.each_ref(), &Pose { translation: away, ..Pose::IDENTITY });
    }
}

#[test]
fn poses_that_32_bits_are_not_made_for_have_their_distance() {
    let mut random = Random::new(4);
    let (a, b) = (mesh(&random.soup(25)), mesh(&random.soup(20)));
    let tiny = mesh(&mapped(&random.soup(20), |p| p.map(|c| c * 1e-5)));
    let turned = random.pose(2.0);
    assert_like_every_pair([&a, &tiny], &turned);
    assert_like_every_pair([&tiny, &b], &turned);
    assert_like_every_pair([&a, &b], &Pose { translation: [1e6, 2e5, 0.0], ..turned });
    let stretched = turned.rotation.map(|c| 1.5 * c);
    assert_like_every_pair([&a, &b], &Pose { rotation: stretched, ..turned });
    let mut sheared = turned.rotation;
    sheared[1] += 1e-5;
    assert_like_every_pair([&a, &b], &Pose { rotation: sheared, ..turned });
    assert_like_every_pair([&a, &b], &Pose { rotation: [0.0; 9], ..turned });
}

/// Some 80 triangles from all over a vehicle.
fn vehicle(name: &str) -> TriangleMesh {
    let source = format!("builtin:{name}?triangles=1000");
    let whole = source.parse::<MeshSource>().unwrap().load().unwrap();
    mesh(&triangles(&whole).into_iter().step_by(12).collect::<Vec<_>>())
}

#[test]
fn vehicles_have_the_distance_of_their_nearest_triangles() {
    let (fixed, moving) = (vehicle("tracked"), vehicle("car"));
    let mut random = Random::new(5);
    for away in [[0.2, 4.5, 0.1], [6.0, 0.5, 0.0]] {
        let pose = Pose { translation: away, ..random.pose(0.0) };
        assert_like_every_pair([&fixed, &moving], &pose);
    }
}

#[test]
fn distance_is_nothing_iff_a_pair_meets() {
    let mut random = Random::new(6);
    let (mut clearance, mut descent) = (Clearance::default(), Descent::default());
    let mut met = 0;
    for _ in 0..60 {
        let meshes = [mesh(&random.soup(12)), mesh(&random.on_grid(12, 4))];
        let pose = random.pose(1.0);
        let images = images(meshes.each_ref(), TreeKind::Wide);
        let [a, b] = images.each_ref().map(TreeImage::view);
        let found = smallest(&mut clearance, &images, &pose);
        let meets = descent.any_pair(&a, &b, &pose).unwrap();
        assert_eq!(found.nearest.distance_m == 0.0, meets);
        let (mut touching, mut pairs) = (Vec::new(), Vec::new());
        clearance.within(&a, &b, &pose, 0.0, &mut touching).unwrap();
        descent.all_pairs(&a, &b, &pose, &mut pairs).unwrap();
        pairs.sort_unstable();
        assert_eq!(touching.iter().map(|near| near.pair).collect::<Vec<_>>(), pairs);
        met += usize::from(meets);
    }
    assert!((10..50).contains(&met), "{met} of 60 meet");
}

#[test]
fn nothing_is_within_a_margin_that_is_none() {
    let [a, b] = images([&vehicle("car"), &vehicle("car")], TreeKind::Wide);
    let mut found = vec![Near { pair: [7, 7], distance_m: 0.0, points: [[0.0; 3]; 2] }];
    for margin in [-1e-300, -1.0, f64::NEG_INFINITY, f64::NAN] {
        let (mut clearance, pose) = (Clearance::default(), Pose::IDENTITY);
        clearance.within(&a.view(), &b.view(), &pose, margin, &mut found).unwrap();
        assert_eq!(found, []);
    }
}

#[test]
fn vertex_out_of_range_and_trees_of_two_kinds_are_refused() {
    let car = vehicle("car");
    let [wide, obb] =
        [TreeKind::Wide, TreeKind::Obb].map(|kind| build(&car, BuildOptions { kind }));
    let mut clearance = Clearance::default();
    let mut ask = |a: &TreeImage, b: &TreeImage, x: f64| {
        let pose = Pose { translation: [x, 0.0, 0.0], ..Pose::IDENTITY };
        let pose = Pose { rotation: pose.rotation.map(|c| c * x.max(1.0)), ..pose };
        clearance.smallest(&a.view(), &b.view(), &pose, Tolerance::NONE)
    };
    let refused = ask(&wide, &obb, 0.0).unwrap_err();
    let (fixed, moving) = (TreeKind::Wide, TreeKind::Obb);
    assert_eq!(refused, DescentError::Kinds { fixed, moving });
    for tree in [&wide, &obb] {
        let refused = ask(tree, tree, f64::MAX).unwrap_err();
        assert!(matches!(refused, DescentError::Overflow { .. }), "{refused}");
    }
}

#[test]
fn distance_beyond_all_numbers_is_infinite() {
    let at = |x: f64| mesh(&[[[x, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]]]);
    for kind in TreeKind::ALL {
        let images = images([&at(-f64::MAX), &at(f64::MAX)], kind);
        let found = smallest(&mut Clearance::default(), &images, &Pose::IDENTITY);
        assert_eq!((found.nearest.distance_m, found.nearest.pair), (f64::INFINITY, [0, 0]));
    }
}
