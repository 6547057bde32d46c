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

const TESTS: [TriangleTest; 4] =
    [TriangleTest::Boxes, TriangleTest::F32, TriangleTest::F64, TriangleTest::Exact];

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

/// For every case, pose, kind of tree and instruction set: the name of all that, how to ask, and the
/// exact pairs.
fn everywhere(
    mut check: impl FnMut(&str, &Case, &Pose, &dyn Fn(TriangleTest) -> Vec<Pair>, &[Pair]),
) {
    for case in cases() {
        let [fixed, moving] = case.meshes.each_ref().map(triangles);
        for pose in &case.poses {
            let truth = brute_force_pairs(&fixed, &moving, pose);
            assert!(!truth.is_empty(), "{}", case.name);
            for kind in TreeKind::ALL {
                let images = case.meshes.each_ref().map(|mesh| build(mesh, BuildOptions { kind }));
                for level in SimdLevel::available() {
                    let ask = |test| sorted_pairs(&mut Descent::with(level, test), &images, pose);
                    check(&format!("{}, {kind}, {level}", case.name), &case, pose, &ask, &truth);
                }
            }
        }
    }
}

#[test]
fn boxes_never_miss_a_pair_and_exact_is_exact() {
    everywhere(|name, _, _, ask, truth| {
        let boxes: HashSet<Pair> = ask(TriangleTest::Boxes).into_iter().collect();
        assert!(truth.iter().all(|pair| boxes.contains(pair)), "{name}");
        assert_eq!(ask(TriangleTest::Exact), truth, "{name}");
    });
}

/// The wide kernel decides most pairs in 32 bits; what comes out must be what plain 64 bits say of
/// every pair whose boxes meet.
#[test]
fn f64_is_what_plain_64_bits_say_of_each_pair() {
    everywhere(|name, case, pose, ask, _| {
        let expected: Vec<Pair> = ask(TriangleTest::Boxes)
            .into_iter()
            .filter(|&[i, j]| {
                let placed = case.meshes[1].triangle(j).map(|p| pose.apply(p));
                plain_f64(&case.meshes[0].triangle(i), &placed)
            })
            .collect();
        assert_eq!(ask(TriangleTest::F64), expected, "{name}");
    });
}

#[test]
fn f32_finds_boxes_that_meet_and_nearly_all_pairs() {
    everywhere(|name, case, _, ask, truth| {
        let boxes: HashSet<Pair> = ask(TriangleTest::Boxes).into_iter().collect();
        let found = ask(TriangleTest::F32);
        assert!(found.iter().all(|pair| boxes.contains(pair)), "{name}");
        let found: HashSet<&Pair> = found.iter().collect();
        let wrong = truth.iter().filter(|pair| !found.contains(pair)).count()
            + found.len().saturating_sub(truth.len());
        let most = if case.name == "vehicles" { truth.len() / 50 } else { truth.len() };
        assert!(wrong <= most, "{name}: {wrong} of {}", truth.len());
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
    let [boxes, f32, f64, exact] = TESTS.map(wrong);
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
                let [boxes, _, _, exact] = TESTS
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
    let levels = TESTS.map(Accuracy::Pairs).into_iter().chain([Accuracy::BoxesAt(depth)]);
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
                options.wanted = Wanted { accuracy, pairs: true, costs: false };
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
