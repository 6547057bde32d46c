//! Every level of accuracy: what it may get wrong and what not, and that the engine obeys it.

mod engine_run;
mod oracle;

use std::collections::HashSet;
use std::sync::Arc;

use bumper::effects::contacts::{pairs_fnv1a64, sort};
use bumper::geometry::predicates::StageCounts;
use bumper::geometry::simd::SimdLevel;
use bumper::geometry::triangle::StaticFilter;
use bumper::geometry::triangle_test::PreparedTest;
use bumper::geometry::{Point, Pose, Triangle, TriangleTest};
use bumper::hardcases::{PairCase, mesh_cases, pair_cases};
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::{StartFrom, Transport};
use bumper::tree::descent::{Descent, Pair};
use bumper::tree::roots::{Cut, PreAnalysis};
use bumper::tree::{Accuracy, BoxDepth, BuildOptions, TreeImage, TreeKind, build};
use bumper::wire::Wanted;
use engine_run::{Answer, Scene, options};
use oracle::{brute_force_pairs, tight_filter};

/// Two meshes and poses of the second.
struct Case {
    name: &'static str,
    meshes: [TriangleMesh; 2],
    poses: Vec<Pose>,
}

fn builtin(name: &str) -> TriangleMesh {
    format!("builtin:{name}").parse::<MeshSource>().unwrap().load().unwrap()
}

fn turned(q: [f64; 4], translation: Point) -> Pose {
    let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
    Pose::from_quaternion(q.map(|c| c / length), translation)
}

/// Vehicles, blocks that touch everywhere, slivers, and vehicles far from the origin.
fn cases() -> Vec<Case> {
    let tilted = turned([0.9, 0.1, -0.3, 0.2], [0.4, -0.3, 0.2]);
    let far = [1e7, 0.0, 0.0];
    // About the far centre: p' = R (p - c) + c + t.
    let back = tilted.apply(far.map(|c| -c));
    let around =
        Pose { rotation: tilted.rotation, translation: [0, 1, 2].map(|k| far[k] + back[k]) };
    let vehicles = || ["tracked?triangles=3000", "car?triangles=2000"].map(builtin);
    let blocks = || [builtin("blocks?triangles=350"), builtin("blocks?triangles=350")];
    let on_diagonal = Pose::from_quaternion([0.5, 0.5, -0.5, 0.5], [0.25, 0.5, 0.0]);
    let beside = Pose { translation: [0.75, 0.0, 0.25], ..Pose::IDENTITY };
    // Without a common corner.
    let half_a_step_on = Pose { translation: [0.75, 0.125, 0.125], ..Pose::IDENTITY };
    let slivers = || [builtin("slivers?triangles=400"), builtin("slivers?triangles=400")];
    let standing_on_it = Pose { translation: [0.5, 0.25, 1.5], ..Pose::IDENTITY };
    vec![
        Case { name: "vehicles", meshes: vehicles(), poses: vec![tilted] },
        Case { name: "blocks", meshes: blocks(), poses: vec![on_diagonal, beside, half_a_step_on] },
        Case { name: "slivers", meshes: slivers(), poses: vec![tilted, standing_on_it] },
        Case {
            name: "far vehicles",
            meshes: vehicles().map(|mesh| mesh.moved(far).unwrap()),
            poses: vec![around],
        },
    ]
}

/// Where plain determinants underflow, and where they overflow.
fn cases_out_of_range() -> Vec<Case> {
    let q = [0.9, 0.1, -0.3, 0.2];
    let of_scale = |name, scale: f64| {
        let mesh = |source: &str| {
            let mesh = builtin(source);
            let vertices = mesh.vertices().iter().map(|p| p.map(|c| c * scale)).collect();
            TriangleMesh::new(vertices, mesh.faces().to_vec()).unwrap()
        };
        let pose = turned(q, [0.4, -0.3, 0.2].map(|c| c * scale));
        let meshes = ["tracked?triangles=1500", "car?triangles=1000"].map(mesh);
        Case { name, meshes, poses: vec![pose] }
    };
    vec![of_scale("tiny vehicles", 1e-110), of_scale("huge vehicles", 1e110)]
}

fn triangles(mesh: &TriangleMesh) -> Vec<Triangle> {
    (0..mesh.faces().len() as u32).map(|face| mesh.triangle(face)).collect()
}

fn sorted_pairs(descent: &mut Descent, images: &[TreeImage; 2], pose: &Pose) -> Vec<Pair> {
    let [fixed, moving] = images.each_ref().map(TreeImage::view);
    let (mut pairs, mut counted) = (Vec::new(), Vec::new());
    descent.all_pairs(&fixed, &moving, pose, &mut pairs).unwrap();
    sort(&mut pairs);
    let counts = descent.counted_pairs(&fixed, &moving, pose, &mut counted).unwrap();
    sort(&mut counted);
    assert_eq!(pairs, counted, "counting changes nothing");
    assert!(counts.boxes > 0 && counts.triangles >= pairs.len() as u64);
    assert_eq!(descent.any_pair(&fixed, &moving, pose).unwrap(), !pairs.is_empty());
    pairs
}

/// For every kind of tree and instruction set: the name of all that, and how to ask.
fn in_every_way(
    case: &Case,
    pose: &Pose,
    mut check: impl FnMut(&str, &dyn Fn(TriangleTest) -> Vec<Pair>),
) {
    for kind in TreeKind::ALL {
        let images = case.meshes.each_ref().map(|mesh| build(mesh, BuildOptions { kind }));
        for level in SimdLevel::available() {
            let ask = |test| sorted_pairs(&mut Descent::with(level, test), &images, pose);
            check(&format!("{}, {kind}, {level}", case.name), &ask);
        }
    }
}

/// For every case and pose [`in_every_way`], with the exact pairs.
fn everywhere(mut check: impl FnMut(&str, &Case, &dyn Fn(TriangleTest) -> Vec<Pair>, &[Pair])) {
    for case in cases() {
        let [fixed, moving] = case.meshes.each_ref().map(triangles);
        for pose in &case.poses {
            let truth = brute_force_pairs(&fixed, &moving, pose);
            assert!(!truth.is_empty(), "{}", case.name);
            in_every_way(&case, pose, |name, ask| check(name, &case, ask, &truth));
        }
    }
}

#[test]
fn boxes_never_miss_a_pair_and_exact_is_exact() {
    everywhere(|name, _, ask, truth| {
        let boxes: HashSet<Pair> = ask(TriangleTest::Boxes).into_iter().collect();
        assert!(truth.iter().all(|pair| boxes.contains(pair)), "{name}");
        assert_eq!(ask(TriangleTest::Exact), truth, "{name}");
    });
}

/// The wide kernel decides most pairs in 32 bits; what comes out must be what plain 64 bits say of
/// every pair whose boxes meet.
#[test]
fn f64_is_what_plain_64_bits_say_of_each_pair() {
    let out_of_range = cases_out_of_range().into_iter().map(|case| (case, true));
    for (case, is_out_of_range) in cases().into_iter().map(|case| (case, false)).chain(out_of_range)
    {
        let [fixed, moving] = &case.meshes;
        for pose in &case.poses {
            in_every_way(&case, pose, |name, ask| {
                let mut expected = ask(TriangleTest::Boxes);
                expected.retain(|&[i, j]| {
                    let placed = moving.triangle(j).map(|p| pose.apply(p));
                    plain_f64(&fixed.triangle(i), &placed)
                });
                assert_eq!(ask(TriangleTest::F64), expected, "{name}");
                assert!(!is_out_of_range || expected != ask(TriangleTest::Exact), "{name}");
            });
        }
    }
}

#[test]
fn f32_finds_boxes_that_meet_and_nearly_all_pairs() {
    everywhere(|name, case, ask, truth| {
        let boxes: HashSet<Pair> = ask(TriangleTest::Boxes).into_iter().collect();
        let found: HashSet<Pair> = ask(TriangleTest::F32).into_iter().collect();
        assert!(found.is_subset(&boxes), "{name}");
        let truth: HashSet<Pair> = truth.iter().copied().collect();
        let missing = truth.difference(&found).count();
        let extra = found.difference(&truth).count();
        // Only strips that are nearly in one plane are hard for 32 bits near the origin.
        let [few, some] = if case.name == "slivers" { [20, 3] } else { [100, 100] };
        let (at_most_missing, at_most_extra) = (truth.len() / few, truth.len() / some);
        let count = truth.len();
        assert!(missing <= at_most_missing, "{name}: {missing} of {count} missing");
        assert!(extra <= at_most_extra, "{name}: {extra} beside {count}");
    });
}

/// Guigue & Devillers' test, written once more after their paper: plain determinants, each at face
/// value, and in a common plane the separating edges.
fn plain_f64(a: &Triangle, b: &Triangle) -> bool {
    let of_b = b.map(|p| sign(orient3d(a, &p)));
    if of_b == [1; 3] || of_b == [-1; 3] {
        return false;
    }
    let of_a = a.map(|p| sign(orient3d(b, &p)));
    if of_a == [1; 3] || of_a == [-1; 3] {
        return false;
    }
    if of_a == [0; 3] || of_b == [0; 3] {
        // Degenerate ones have no part in what this is for.
        return PreparedTest::new(TriangleTest::F64, StaticFilter::OFF, None).intersect(a, b);
    }
    // Each triangle turned until its first corner is alone on its side, and with a plane that sees
    // that corner above.
    let ([p1, q1, r1], up1) = alone_first(a, of_a);
    let ([p2, q2, r2], up2) = alone_first(b, of_b);
    let (q1, r1) = if up2 { (q1, r1) } else { (r1, q1) };
    let (q2, r2) = if up1 { (q2, r2) } else { (r2, q2) };
    sign(orient3d(&[p1, q1, p2], &q2)) <= 0 && sign(orient3d(&[p1, r1, r2], &p2)) <= 0
}

fn alone_first([p, q, r]: &Triangle, signs: [i32; 3]) -> (Triangle, bool) {
    let turns = [([*p, *q, *r], [0, 1, 2]), ([*q, *r, *p], [1, 2, 0]), ([*r, *p, *q], [2, 0, 1])];
    let sees = |up: i32| {
        turns.iter().find(|(_, [i, j, k])| {
            let [alone, others @ ..] = [signs[*i], signs[*j], signs[*k]].map(|s| s * up);
            alone > 0 && others.iter().all(|&s| s <= 0) || alone == 0 && others == [-1; 2]
        })
    };
    match (sees(1), sees(-1)) {
        (Some((turned, _)), None) => (*turned, true),
        (None, Some((turned, _))) => (*turned, false),
        // One on either side and one between: either will do. As the library has it, the last.
        (Some((up, first)), Some((down, second))) => {
            if first[0] > second[0] {
                (*up, true)
            } else {
                (*down, false)
            }
        }
        (None, None) => unreachable!("not all on one side"),
    }
}

fn orient3d([a, b, c]: &Triangle, d: &Point) -> f64 {
    let [u, v, w] = [b, c, d].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    normal[0] * w[0] + normal[1] * w[1] + normal[2] * w[2]
}

fn sign(x: f64) -> i32 {
    i32::from(x > 0.0) - i32::from(x < 0.0)
}

#[test]
fn plain_floating_point_is_wrong_where_exact_arithmetic_is_not() {
    let cases = pair_cases();
    let wrong = |test| {
        let answers_wrongly = |case: &&PairCase| {
            let filter = tight_filter(case.a.iter().chain(&case.b));
            PreparedTest::new(test, filter, None).intersect(&case.a, &case.b) != case.intersect()
        };
        cases.iter().filter(answers_wrongly).count()
    };
    let [boxes, f32, f64, exact] = TriangleTest::ALL.map(wrong);
    assert_eq!(exact, 0);
    assert!(0 < f64 && f64 < f32 && f32 < boxes, "{f64} {f32} {boxes}");
    let missed = cases.iter().filter(|case| {
        let test = PreparedTest::new(TriangleTest::Boxes, StaticFilter::OFF, None);
        case.intersect() && !test.intersect(&case.a, &case.b)
    });
    assert_eq!(missed.count(), 0, "boxes miss nothing");
}

#[test]
fn hard_meshes_panic_at_no_level() {
    for case in mesh_cases() {
        for kind in TreeKind::ALL {
            let images = [&case.fixed, &case.moving].map(|mesh| build(mesh, BuildOptions { kind }));
            for level in SimdLevel::available() {
                let [boxes, _, _, exact] = TriangleTest::ALL
                    .map(|test| sorted_pairs(&mut Descent::with(level, test), &images, &case.pose));
                assert_eq!(exact, case.pairs, "{}, {kind}, {level}", case.name);
                let boxes: HashSet<Pair> = boxes.into_iter().collect();
                assert!(exact.iter().all(|pair| boxes.contains(pair)), "{}", case.name);
            }
        }
    }
}

#[test]
fn signs_are_counted_by_the_stage_that_decided_them() {
    let staged = |case: &Case, pose: &Pose, kind| {
        let images = case.meshes.each_ref().map(|mesh| build(mesh, BuildOptions { kind }));
        let [fixed, moving] = images.each_ref().map(TreeImage::view);
        let (mut descent, mut pairs) = (Descent::default(), Vec::new());
        let (_, stages) = descent.staged_pairs(&fixed, &moving, pose, &mut pairs).unwrap();
        sort(&mut pairs);
        assert_eq!(pairs, sorted_pairs(&mut descent, &images, pose), "the same pairs");
        stages
    };
    let all = cases();
    let vehicles: StageCounts = staged(&all[0], &all[0].poses[0], TreeKind::Obb);
    assert!(vehicles.filter > 1_000, "{vehicles:?}");
    assert_eq!(vehicles.integers, 0, "{vehicles:?}");
    let blocks = staged(&all[1], &all[1].poses[2], TreeKind::Obb);
    assert!(blocks.structure > 100 && blocks.grid > 10, "{blocks:?}");
    assert_eq!([blocks.expansions, blocks.integers], [0, 0], "a grid needs no more: {blocks:?}");
}

/// What the engine should answer, found without it.
fn answers(scene: &Scene, accuracy: Accuracy) -> Vec<Answer> {
    let (fixed, moving) = (scene.fixed.view(), scene.moving.view());
    let one = |(scenario, pose): (u32, &Pose)| {
        let mut pairs = Vec::new();
        match accuracy {
            Accuracy::Pairs(test) => {
                let mut descent = Descent::with(SimdLevel::chosen(), test);
                descent.all_pairs(&fixed, &moving, pose, &mut pairs).unwrap();
            }
            Accuracy::BoxesAt(depth) => {
                PreAnalysis::new(fixed, depth.cut(), moving, depth.cut())
                    .boxes_that_meet(pose, &mut pairs)
                    .unwrap();
            }
        }
        sort(&mut pairs);
        (scenario, pairs.len() as u32, pairs_fnv1a64(&pairs), pairs)
    };
    (0..).zip(&scene.poses).map(one).collect()
}

#[test]
fn the_engine_obeys_the_level_over_every_transport() {
    let mut scene = Scene::new(20, 12);
    // Strips so thin that each level finds other pairs.
    let slivers = |budget: u32| {
        let mesh = builtin(&format!("slivers?triangles={budget}"));
        Arc::new(build(&mesh, BuildOptions { kind: TreeKind::Wide }))
    };
    (scene.fixed, scene.moving) = (slivers(400), slivers(800));
    let depth = BoxDepth::new(5).unwrap();
    let levels =
        TriangleTest::ALL.map(Accuracy::Pairs).into_iter().chain([Accuracy::BoxesAt(depth)]);
    let mut seen = HashSet::new();
    for accuracy in levels {
        let expected = answers(&scene, accuracy);
        seen.insert(expected.iter().map(|answer| answer.2).collect::<Vec<_>>());
        for transport in Transport::ALL {
            let starts = match transport {
                Transport::Iceoryx2 | Transport::Threads => {
                    &[None, Some(StartFrom::Top), Some(StartFrom::RootPairs)][..]
                }
                Transport::Pipe | Transport::Socket => &[None],
            };
            for &start_from in starts {
                let mut options = options(2);
                options.engine.transport = transport;
                options.engine.start_from = start_from;
                let pairs = Wanted::ALL_PAIRS;
                options.wanted = Wanted { accuracy, pairs, ..Wanted::default() };
                if let Accuracy::BoxesAt(depth) = accuracy {
                    options.cuts = [depth.cut(); 2];
                } else {
                    options.cuts = [Cut::Depth(4), Cut::Depth(3)];
                }
                let (_, found) = scene.run(&options);
                assert_eq!(found, expected, "{accuracy} over {}", transport.name());
            }
        }
    }
    assert!(seen.len() >= 4, "levels that answer the same would show nothing");
}
