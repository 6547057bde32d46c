//! Scene files, pose files, and random scenarios.

use std::num::NonZeroU32;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use bumper::geometry::{Point, Pose};
use bumper::mesh::{MeshSource, TriangleMesh};
use bumper::scene::random::{self, RandomError, RandomScenarios};
use bumper::scene::{
    Compression, Distribution, Penetration, Scenarios, Scene, Slowdown, SubtreesFrom, WorkerCount,
    read_poses,
};
use bumper::tree::descent::Descent;
use bumper::tree::roots::Cut;
use bumper::tree::{Accuracy, BuildOptions, TreeKind, build};

const MINIMAL: &str = r#"version = 1
[fixed]
mesh = "a.stl"
[moving]
mesh = "b.stl"
[scenarios]
random = { count = 10 }
"#;

fn parse(text: &str) -> Result<Scene, String> {
    Scene::parse(text, "test.toml", Path::new("folder")).map_err(|e| e.to_string())
}

#[test]
fn a_minimal_scene_gets_the_papers_defaults() {
    let scene = parse(MINIMAL).unwrap();
    assert_eq!(scene.fixed.mesh, MeshSource::File("folder/a.stl".into()));
    let cuts = [scene.fixed, scene.moving].map(|body| body.distribution.cut());
    assert_eq!(cuts, [Cut::Depth(12), Cut::Depth(6)]);
    assert_eq!(scene.tree, TreeKind::Wide);
    assert_eq!(scene.engine.workers, None);
    assert_eq!(scene.engine.buffer_scenarios.get(), 20);
    let Scenarios::Random(random) = scene.scenarios else { panic!("not random") };
    assert_eq!((random.count.get(), random.seed), (10, 1));
    assert_eq!(random.penetration, Penetration::PAPER);
}

#[test]
fn absolute_paths_and_built_in_vehicles_are_not_relative_to_the_scene() {
    let scene = parse(&MINIMAL.replace("a.stl", "/models/a.stl")).unwrap();
    assert_eq!(scene.fixed.mesh, MeshSource::File("/models/a.stl".into()));
    let scene = parse(&MINIMAL.replace("a.stl", "builtin:car")).unwrap();
    assert!(matches!(scene.fixed.mesh, MeshSource::Builtin(_)));
}

#[test]
fn accuracy_and_offsets_are_what_the_scene_says() {
    let scene = parse(MINIMAL).unwrap();
    assert_eq!((scene.accuracy, scene.fixed.offset), (Accuracy::EXACT, [0.0; 3]));
    let at_level =
        |level: &str| MINIMAL.replace("[fixed]", &format!("accuracy = {level}\n[fixed]"));
    let scene = parse(&at_level("\"boxes(7)\"")).unwrap();
    assert_eq!(scene.accuracy.to_string(), "boxes(7)");
    assert_eq!(scene.cuts(), [Cut::Depth(7); 2], "the boxes are those of the distributed roots");
    let refused = parse(&at_level("\"boxes(70)\"")).unwrap_err();
    assert!(refused.contains("`accuracy`") && refused.contains("boxes(70)"), "{refused}");
    let offset =
        |value: &str| MINIMAL.replace("\"a.stl\"", &format!("\"a.stl\"\noffset_m = {value}"));
    assert_eq!(parse(&offset("[1e7, 0.0, -2.5]")).unwrap().fixed.offset, [1e7, 0.0, -2.5]);
    let refused = parse(&offset("[inf, 0.0, 0.0]")).unwrap_err();
    assert!(refused.contains("fixed.offset_m"), "{refused}");
}

#[test]
fn a_tree_is_cut_by_depth_or_by_triangles() {
    let by_triangles = "\"a.stl\"\nsubtree_triangles = 2000";
    let scene = parse(&MINIMAL.replace("\"a.stl\"", by_triangles)).unwrap();
    assert_eq!(scene.fixed.distribution.cut(), Cut::Triangles(2000));
    assert_eq!(scene.moving.distribution.cut(), Cut::Depth(6));
}

#[test]
fn the_default_scene_has_the_papers_number_of_scenarios() {
    let Scenarios::Random(random) = Scene::embedded_default().scenarios else {
        panic!("not random")
    };
    assert_eq!(random.count.get(), 3744);
}

/// Each edit of the minimal scene, and the words its error must have: file and line, key, reason.
#[test]
fn a_scene_that_is_written_reads_as_the_same_scene_from_anywhere() {
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("config");
    let folders = ["", "effects", "accuracy"].map(|folder| config.join(folder));
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let scenes = files.map(|file| file.unwrap().path()).filter(|path| path.is_file());
    let scenes: Vec<_> = scenes.filter(|p| p.extension().is_some_and(|e| e == "toml")).collect();
    assert!(scenes.len() > 10, "{scenes:?}");
    for path in scenes {
        let mut scene = Scene::read(&path).unwrap();
        scene.engine.slowdowns = vec![Slowdown::new(2.5).unwrap()];
        scene.engine.compress = Compression::Lz4;
        scene.engine.subtrees_from = SubtreesFrom::Workers;
        scene.moving.distribution = Distribution::by_triangles(700).unwrap();
        match &mut scene.scenarios {
            Scenarios::Random(random) => random.seed = 99,
            Scenarios::Poses { first, .. } => *first = NonZeroU32::new(2),
        }
        let text = scene.to_toml().unwrap();
        let again = Scene::parse(&text, "again", Path::new("/elsewhere")).unwrap();
        assert_eq!((&again.fixed, &again.moving), (&scene.fixed, &scene.moving), "{text}");
        assert_eq!((&again.tree, &again.accuracy), (&scene.tree, &scene.accuracy), "{text}");
        assert_eq!((&again.scenarios, &again.engine), (&scene.scenarios, &scene.engine), "{text}");
        assert_eq!(again.effects, scene.effects, "{text}");
        assert_eq!(again.to_toml().unwrap(), text);
    }
    let mut scene = parse(MINIMAL).unwrap();
    scene.engine.match_seed = u64::MAX;
    assert!(scene.to_toml().unwrap_err().to_string().contains("match_seed"));
}

#[test]
fn rows_of_a_poses_file_are_counted_and_random_scenarios_are_not() {
    let first = |scenarios: &str, n: i64| {
        let text = MINIMAL.split("[scenarios]").next().unwrap().to_owned();
        parse(&format!("{text}[scenarios]\n{scenarios}\nfirst = {n}\n"))
    };
    let scene = first("poses = \"a.csv\"", 7).unwrap();
    let Scenarios::Poses { first: Some(count), .. } = scene.scenarios else { panic!("no count") };
    assert_eq!(count.get(), 7);
    assert!(first("poses = \"a.csv\"", 0).unwrap_err().contains("scenarios.first"));
    let refused = first("random = { count = 3 }", 2).unwrap_err();
    assert!(refused.contains("scenarios.first") && refused.contains("count"), "{refused}");
}

#[test]
fn scene_errors_name_file_line_key_and_what_to_do() {
    let count = "random = { count = 10 }";
    let cases = [
        ("version = 1\n", "", "test.toml:1: `version`: is missing: add the line `version = 1`"),
        ("version = 1", "version = 2", "test.toml:1: `version`: 2 is not a version"),
        ("version = 1", "version = 'one'", "test.toml:1: `version`: \"one\" is not a version"),
        ("count", "cuont", "test.toml:7: `scenarios.random`: unknown field `cuont`"),
        ("count", "cuont", "did you mean `count`?"),
        ("[moving]", "colour = 1\n[moving]", "test.toml:4: `fixed`: unknown field `colour`"),
        ("mesh = \"b.stl\"", "", "test.toml:4: `moving`: missing field `mesh`"),
        ("count = 10", "count = -5", "test.toml:7: `scenarios.random.count`: -5 is not a number"),
        ("count = 10", "count = 0", "test.toml:7: `scenarios.random.count`: 0 is not a number"),
        ("count = 10", "count = 5000000000", "from 1 to 4294967295"),
        ("count = 10", "count = 1.5", "test.toml:7: `scenarios.random.count`: invalid type"),
        ("count = 10", "count = 10, seed = -1", "`scenarios.random.seed`: -1 is negative"),
        (
            "count = 10",
            "count = 10, penetration = [nan, 1.0]",
            "test.toml:7: `scenarios.random.penetration`: [NaN, 1] is not a range of depths",
        ),
        ("count = 10", "count = 10, penetration = [0.3, 0.1]", "the smaller first"),
        ("count = 10", "count = 10, penetration = [0.0, inf]", "two finite numbers"),
        (count, "", "test.toml:6: `scenarios`: says nothing"),
        (count, "random = { count = 10 }\nposes = 'p.csv'", "`scenarios`: has both"),
        ("\"a.stl\"", "\"builtin:tank\"", "test.toml:3: `fixed.mesh`: "),
        ("\"a.stl\"", "\"a.stl\"\ndepth = -1", "test.toml:4: `fixed.depth`: -1 is not a tree"),
        ("\"a.stl\"", "\"a.stl\"\ndepth = 99", "from 0 to 24"),
        ("\"a.stl\"", "\"a.stl\"\nsubtree_triangles = 0", "`fixed.subtree_triangles`: 0 is not"),
        (
            "\"a.stl\"",
            "\"a.stl\"\ndepth = 3\nsubtree_triangles = 9",
            "test.toml:5: `fixed.subtree_triangles`: is given beside `fixed.depth`",
        ),
        ("[scenarios]", "[engine]\nworkers = 0\n[scenarios]", "test.toml:7: `engine.workers`: 0"),
        ("[scenarios]", "[engine]\nbuffer.scenarios = 0\n[scenarios]", "`engine.buffer.scenarios`"),
        ("[scenarios]", "[engine]\nbuffer.kilobytes = 0\n[scenarios]", "`engine.buffer.kilobytes`"),
        ("[scenarios]", "[engine]\nrestarts = -1\n[scenarios]", "-1 is not a number of restarts"),
        (
            "[scenarios]",
            "[engine]\npatience_s = 0.0\n[scenarios]",
            "`engine.patience_s`: 0 is not a",
        ),
        ("[scenarios]", "[engine]\nslowdowns = [1.0, 0.5]\n[scenarios]", "0.5 is not a slowdown"),
        ("[scenarios]", "[engine]\ntransport = 'pigeon'\n[scenarios]", "unknown variant"),
        ("[scenarios]", "[engine]\nmatchmaker = 'worst'\n[scenarios]", "unknown variant"),
        ("[scenarios]", "[tree]\nkind = 'sphere'\n[scenarios]", "`tree.kind`: unknown variant"),
        ("[fixed]", "[fixed", "test.toml:2: "),
    ];
    for (part, replacement, expected) in cases {
        assert!(MINIMAL.contains(part), "{part}");
        let error = parse(&MINIMAL.replacen(part, replacement, 1)).unwrap_err();
        assert!(error.contains(expected), "{part} -> {replacement}\n{error}\nlacks {expected}");
    }
}

#[test]
fn any_text_at_all_is_a_scene_or_an_error() {
    for cut in 0..MINIMAL.len() {
        let _ = parse(&MINIMAL[..cut]);
        let _ = parse(&MINIMAL[cut..]);
        let _ = parse(&MINIMAL.replacen(&MINIMAL[cut..=cut], "é", 1));
    }
}

const HEADER: &str = "qw,qx,qy,qz,tx,ty,tz\n";

fn read(bytes: &[u8], first: Option<u32>) -> Result<Vec<Pose>, String> {
    let file = tempfile::NamedTempFile::with_suffix("-poses.csv").unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    read_poses(file.path(), first.and_then(NonZeroU32::new)).map_err(|e| e.to_string())
}

#[test]
fn poses_are_read_as_they_are_written() {
    let text = format!("{HEADER}1,0,0,0,1.5,-2,3e-1\r\n\n 0.6, 0.8 ,0,0,0,0,0\n");
    let poses = read(text.as_bytes(), None).unwrap();
    let expected = [
        Pose::checked([1.0, 0.0, 0.0, 0.0], [1.5, -2.0, 0.3]).unwrap(),
        Pose::checked([0.6, 0.8, 0.0, 0.0], [0.0; 3]).unwrap(),
    ];
    assert_eq!(poses, expected);
    assert_eq!(read(text.as_bytes(), Some(1)).unwrap(), expected[..1]);
}

#[test]
fn pose_errors_name_line_and_field() {
    let good = "1,0,0,0,0,0,0\n";
    let cases = [
        (String::new(), ":1: nothing where the header `qw,qx,qy,qz,tx,ty,tz` should be"),
        (good.to_owned(), ":1: `1,0,0,0,0,0,0` where the header"),
        (HEADER.to_owned(), "there is no pose below the header line"),
        (format!("{HEADER}{good}1,0,0,0,0,0\n"), ":3: 6 fields where 7 are wanted"),
        (format!("{HEADER}1,0,0,0,0,0,0,0\n"), ":2: 8 fields where 7 are wanted"),
        (format!("{HEADER}\n\n1,x,0,0,0,0,0\n"), ":4: field qx: `x` is not a number"),
        (format!("{HEADER}1,,0,0,0,0,0\n"), ":2: field qx: `` is not a number"),
        (format!("{HEADER}{good}1,0,0,0,NaN,0,0\n"), ":3: tx is not a finite number"),
        (format!("{HEADER}1,0,0,0,0,0,1e999\n"), ":2: tz is not a finite number"),
        (format!("{HEADER}0.5,0,0,0,0,0,0\n"), ":2: the quaternion has length 0.5, not 1"),
    ];
    for (text, expected) in cases {
        let error = read(text.as_bytes(), None).unwrap_err();
        assert!(error.contains("-poses.csv") && error.contains(expected), "{text}\n{error}");
    }
    let error = read(&[HEADER.as_bytes(), b"1,0,\xff\xfe,0,0,0,0\n"].concat(), None).unwrap_err();
    assert!(error.contains(":2: something that is not a line of a CSV file"), "{error}");
    let error = read(format!("{HEADER}{good}").as_bytes(), Some(2)).unwrap_err();
    assert!(error.contains("2 poses are asked for, but the file has only 1"), "{error}");
    let missing = read_poses(Path::new("no/such.csv"), None).unwrap_err().to_string();
    assert!(missing.contains("no/such.csv: cannot read the poses"), "{missing}");
}

/// A sphere about `centre`: each square of a cube's faces, pushed out.
fn sphere(radius: f64, centre: Point) -> TriangleMesh {
    const SQUARES: u32 = 16;
    let mut vertices = Vec::new();
    let mut faces = Vec::new();
    for side in 0..6_usize {
        let base = vertices.len() as u32;
        for (row, column) in (0..=SQUARES).flat_map(|r| (0..=SQUARES).map(move |c| (r, c))) {
            let on_face = |i: u32| f64::from(i) / f64::from(SQUARES) * 2.0 - 1.0;
            let mut point = [0.0; 3];
            point[side % 3] = if side < 3 { 1.0 } else { -1.0 };
            point[(side + 1) % 3] = on_face(row);
            point[(side + 2) % 3] = on_face(column);
            let length = norm(point);
            vertices.push([0, 1, 2].map(|i| centre[i] + radius * point[i] / length));
            if row < SQUARES && column < SQUARES {
                let corner = base + row * (SQUARES + 1) + column;
                let above = corner + SQUARES + 1;
                faces.extend([[corner, corner + 1, above], [above, corner + 1, above + 1]]);
            }
        }
    }
    TriangleMesh::new(vertices, faces).unwrap()
}

fn norm(v: Point) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn scenarios(count: u32, seed: u64) -> RandomScenarios {
    let count = NonZeroU32::new(count).unwrap();
    RandomScenarios { count, seed, penetration: Penetration::PAPER }
}

fn place(
    scenarios: &RandomScenarios,
    fixed: &TriangleMesh,
    moving: &TriangleMesh,
) -> Result<Vec<Pose>, RandomError> {
    let options = BuildOptions { kind: TreeKind::Obb };
    let (fixed_tree, moving_tree) = (build(fixed, options), build(moving, options));
    let interrupt = AtomicBool::new(false);
    random::poses(
        scenarios,
        (fixed, &fixed_tree.view()),
        (moving, &moving_tree.view()),
        &|| (),
        &interrupt,
    )
}

/// Of spheres the first contact is known: their centres are both radii apart (less what their
/// facets lack, 1%).
#[test]
fn random_poses_of_spheres_are_as_deep_as_asked() {
    let (fixed_centre, moving_centre) = ([10.0, -3.0, 0.5], [-2.0, 0.0, 7.0]);
    let (fixed, moving) = (sphere(1.5, fixed_centre), sphere(1.0, moving_centre));
    let poses = place(&scenarios(200, 5), &fixed, &moving).unwrap();
    let mut depths = Vec::new();
    for pose in &poses {
        let placed = pose.apply(moving_centre);
        let distance = norm([0, 1, 2].map(|i| placed[i] - fixed_centre[i]));
        let depth = 2.5 - distance;
        assert!(depth > 0.005 - 1e-9 && depth < 0.3 + 0.03, "{depth}");
        depths.push(depth);
    }
    let mean = depths.iter().sum::<f64>() / 200.0;
    assert!((mean - 0.1525).abs() < 0.03, "mean depth {mean}");

    let options = BuildOptions { kind: TreeKind::Obb };
    let (fixed, moving) = (build(&fixed, options), build(&moving, options));
    let mut descent = Descent::default();
    for pose in &poses {
        assert!(descent.any_pair(&fixed.view(), &moving.view(), pose).unwrap());
    }
}

#[test]
fn random_poses_depend_on_seed_and_number_alone() {
    let (fixed, moving) = (sphere(1.5, [0.0; 3]), sphere(1.0, [1.0; 3]));
    let all = place(&scenarios(40, 5), &fixed, &moving).unwrap();
    let few = place(&scenarios(7, 5), &fixed, &moving).unwrap();
    assert_eq!(few, all[..7]);
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let serial = one_thread.install(|| place(&scenarios(40, 5), &fixed, &moving).unwrap());
    assert_eq!(serial, all);
    assert_ne!(place(&scenarios(40, 6), &fixed, &moving).unwrap(), all);
}

/// If this fails, results of the same scene differ from those of earlier versions or of other
/// machines.
#[test]
fn random_poses_are_pinned_for_good() {
    let (fixed, moving) = (sphere(1.5, [0.0; 3]), sphere(1.0, [1.0; 3]));
    let poses = place(&scenarios(50, 1), &fixed, &moving).unwrap();
    let hash = xxhash_rust::xxh3::xxh3_64(bytemuck::cast_slice(&poses));
    assert_eq!(format!("{hash:016x}"), "fbad38a4bb36601e");
}

#[test]
fn the_kind_of_tree_does_not_change_random_poses() {
    let (fixed, moving) = (sphere(1.5, [0.0; 3]), sphere(1.0, [1.0; 3]));
    let obb = place(&scenarios(20, 5), &fixed, &moving).unwrap();
    let options = BuildOptions { kind: TreeKind::Aabb };
    let (fixed_tree, moving_tree) = (build(&fixed, options), build(&moving, options));
    let aabb = random::poses(
        &scenarios(20, 5),
        (&fixed, &fixed_tree.view()),
        (&moving, &moving_tree.view()),
        &|| (),
        &AtomicBool::new(false),
    );
    assert_eq!(aabb.unwrap(), obb);
}

#[test]
fn meshes_that_never_meet_are_an_error_and_not_a_hang() {
    // Both miss the middle, where the one would have to meet the other.
    let speck = |at: Point| TriangleMesh::new(vec![at; 3], vec![[0, 1, 2]]).unwrap();
    let two_specks =
        TriangleMesh::new(vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], vec![[0, 0, 0], [1, 1, 1]])
            .unwrap();
    let error = place(&scenarios(3, 1), &two_specks, &speck([5.0, 0.0, 0.0])).unwrap_err();
    assert!(matches!(error, RandomError::NoContact { .. }), "{error}");
    let error = place(&scenarios(3, 1), &speck([0.0; 3]), &speck([1.0; 3])).unwrap_err();
    assert!(matches!(error, RandomError::Extent(_)), "{error}");
}

#[test]
fn an_interrupt_ends_the_placing() {
    let mesh = sphere(1.0, [0.0; 3]);
    let tree = build(&mesh, BuildOptions { kind: TreeKind::Obb });
    let view = tree.view();
    let interrupt = AtomicBool::new(true);
    let poses =
        random::poses(&scenarios(1000, 1), (&mesh, &view), (&mesh, &view), &|| (), &interrupt);
    assert_eq!(poses, Err(RandomError::Interrupted));
}

#[test]
fn the_machines_cores_are_a_valid_number_of_workers() {
    assert!(WorkerCount::of_this_machine().get().get() >= 1);
}
