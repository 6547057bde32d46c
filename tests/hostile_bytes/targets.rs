//! One function for each kind of bytes that come from outside: it takes anything, must not crash,
//! and holds what was accepted against what the type promises. Returns whether it was accepted.
//!
//! The tests here and the programs in `fuzz/` drive the same functions. A new format is a function
//! with its seeds, and its name in [`TARGETS`].

use std::cell::RefCell;
use std::path::Path;
use std::time::Duration;

use bumper::effects::Plan;
use bumper::geometry::{Pose, TriangleTest};
use bumper::hardcases::continuous::QuerySuite;
use bumper::hardcases::{Cases, Suite};
use bumper::mesh::{Format, TriangleMesh};
use bumper::transport::peer::PeerName;
use bumper::tree::descent::{Descent, Pair};
use bumper::tree::roots::{Cut, PreAnalysis};
use bumper::tree::subtree::{PartialTree, Subtrees, compressed};
use bumper::tree::{
    Accuracy, Block, BoxDepth, BuildOptions, Header, TreeImage, TreeKind, TreeView, build,
};
use bumper::wire::{
    AnswerRecord, Batch, Fetch, InPlaceTree, Job, JobHeader, PlanMessage, Reply, ReplyHeader,
    ScenarioRecord, SubtreeRecord, TreeRecord, Wanted, place_of,
};
use bytemuck::Zeroable;

use super::writers::{Body, every_variant};

pub struct Target {
    pub name: &'static str,
    pub check: fn(&[u8]) -> bool,
    /// Bytes that are accepted, of every sort there is.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

pub static TARGETS: [Target; 6] = [
    Target { name: "image", check: image, seeds: image_seeds },
    Target { name: "subtree", check: subtree, seeds: subtree_seeds },
    Target { name: "batch", check: batch, seeds: batch_seeds },
    Target { name: "result", check: result, seeds: result_seeds },
    Target { name: "mesh", check: mesh, seeds: mesh_seeds },
    Target { name: "suite", check: suite, seeds: suite_seeds },
];

/// A tree image, descended against itself in one of some poses. Bytes after the last whole block say what is
/// left as it is; otherwise the header is made to fit, so that damage gets past its hash.
pub fn image(bytes: &[u8]) -> bool {
    let mut blocks = vec![Block::zeroed(); bytes.len() / size_of::<Block>()];
    let (whole, rest) = bytes.split_at(blocks.len() * size_of::<Block>());
    bytemuck::cast_slice_mut(&mut blocks).copy_from_slice(whole);
    match rest.len() % 4 {
        0 => place_sections(&mut blocks),
        1 => {}
        2 => return TreeView::new(&blocks).is_ok_and(|view| use_image(&view)),
        _ => set_length(&mut blocks),
    }
    set_hash(&mut blocks);
    TreeView::new(&blocks).is_ok_and(|view| use_image(&view))
}

fn header(blocks: &mut [Block]) -> Option<&mut Header> {
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(blocks);
    Some(bytemuck::from_bytes_mut(bytes.get_mut(..size_of::<Header>())?))
}

fn set_length(blocks: &mut [Block]) {
    let length = size_of_val(blocks) as u64;
    if let Some(header) = header(blocks) {
        header.byte_length = length;
    }
}

fn place_sections(blocks: &mut [Block]) {
    set_length(blocks);
    let Some(header) = header(blocks) else { return };
    // Of a node of each kind, of a leaf's box and rows, of a triangle, of a vertex.
    let node: u64 = match header.kind % 4 {
        1 => 64,
        2 => 32,
        _ => 256,
    };
    let section = |start: u64, count: u32, size: u64| {
        start.saturating_add((u64::from(count) * size).next_multiple_of(64))
    };
    header.nodes_at = size_of::<Header>() as u64;
    header.leaf_boxes_at = section(header.nodes_at, header.node_count, node);
    header.leaf_rows_at = section(header.leaf_boxes_at, header.leaf_count, 64);
    header.triangles_at = section(header.leaf_rows_at, header.leaf_count, 320);
    header.vertices_at = section(header.triangles_at, header.triangle_count, 16);
}

pub fn set_hash(blocks: &mut [Block]) {
    let bytes: &[u8] = bytemuck::cast_slice(blocks);
    let from = std::mem::offset_of!(Header, mesh_hash);
    let hash = xxhash_rust::xxh3::xxh3_64(bytes.get(from..).unwrap_or_default());
    if let Some(header) = header(blocks) {
        header.content_hash = hash;
    }
}

thread_local! {
    static ROOMS: RefCell<(Descent, Vec<Pair>, Vec<[u32; 2]>)> = RefCell::default();
}

fn use_image(view: &TreeView<'_>) -> bool {
    let poses = [
        Pose::IDENTITY,
        Pose::from_quaternion([0.5, 0.5, -0.5, 0.5], [0.25, -0.125, 0.5]),
        Pose::from_quaternion([1.0, 0.0, 0.0, 0.0], [1e200, 0.0, 0.0]),
        Pose { rotation: [1e300; 9], translation: [-1e300; 3] },
    ];
    let pose = &poses[view.hash() as usize % poses.len()];
    ROOMS.with_borrow_mut(|(descent, pairs, roots)| {
        pairs.clear();
        // Too far away is an error, which is no crash.
        let _ = descent.all_pairs(view, view, pose, pairs);
        let ids: Vec<u32> = view.triangles().iter().map(|triangle| triangle.id).collect();
        assert!(pairs.iter().flatten().all(|id| ids.contains(id)), "a pair of no triangles");
        let mut analysis = PreAnalysis::new(*view, Cut::Depth(3), *view, Cut::Depth(2));
        analysis.overlapping_roots(pose, roots);
        let counts = [analysis.fixed_roots().len(), analysis.moving_roots().len()];
        assert!(roots.iter().all(|r| (0..2).all(|k| (r[k] as usize) < counts[k])), "no such root");
    });
    true
}

fn image_seeds() -> Vec<Vec<u8>> {
    let sheet = |count: u32| {
        let vertices = (0..count + 2).map(|i| {
            let i = f64::from(i);
            [i * 0.375 - 1.0, (i * 37.0 % 11.0) / 8.0, (i * 23.0 % 17.0) / 16.0]
        });
        let faces = (0..count).map(|i| [i, i + 2, i + 1]);
        TriangleMesh::new(vertices.collect(), faces.collect()).expect("a valid sheet")
    };
    let meshes = [Body::house().mesh(), Body::crooked().mesh(), sheet(1), sheet(9)];
    let small = TreeKind::ALL
        .into_iter()
        .flat_map(|kind| meshes.iter().map(move |mesh| build(mesh, BuildOptions { kind })));
    // A wide tree of more than one node.
    let trees = small.chain([build(&sheet(70), BuildOptions { kind: TreeKind::Wide })]);
    trees.map(|tree| bytemuck::cast_slice(tree.blocks()).to_vec()).collect()
}

/// The outline of a tree, or a subtree of one that is here, by the first byte; the rest is the
/// message, made to fit its own length and hash, so that damage gets past them.
pub fn subtree(bytes: &[u8]) -> bool {
    let Some((&choice, message)) = bytes.split_first() else { return false };
    let mut message = message.to_vec();
    if let Some((header, _)) = message.split_first_chunk::<HASHED_FROM>() {
        let mut header = *header;
        header[16..24].copy_from_slice(&(message.len() as u64).to_ne_bytes());
        let hash = xxhash_rust::xxh3::xxh3_64(&message[HASHED_FROM..]);
        header[24..].copy_from_slice(&hash.to_ne_bytes());
        message[..HASHED_FROM].copy_from_slice(&header);
    }
    aligned(&message, |message| {
        if choice == u8::MAX {
            return PartialTree::new(message).is_ok();
        }
        let trees = cut_trees();
        let subtrees = Subtrees::new(trees[usize::from(choice) % trees.len()].view(), CUT);
        let mut partial = PartialTree::new(&subtrees.outline()).expect("the outline of a tree");
        let Ok(root) = partial.add(message) else { return false };
        ROOMS.with_borrow_mut(|(descent, pairs, _)| {
            pairs.clear();
            let tree = partial.cut_tree();
            let _ = descent.all_pairs_below(&tree, &tree, &Pose::IDENTITY, &[[root, root]], pairs);
        });
        true
    })
}

/// Magic, version, a reserved word, length, hash.
const HASHED_FROM: usize = 32;

const CUT: Cut = Cut::Depth(2);

fn cut_trees() -> Vec<TreeImage> {
    let mesh = Body::crooked().mesh();
    TreeKind::ALL.map(|kind| build(&mesh, BuildOptions { kind })).into()
}

fn subtree_seeds() -> Vec<Vec<u8>> {
    let mut seeds = Vec::new();
    for (choice, tree) in (0_u8..).zip(cut_trees()) {
        let subtrees = Subtrees::new(tree.view(), CUT);
        seeds.push([&[u8::MAX], &subtrees.outline()[..]].concat());
        let message = |root| subtrees.message(root).expect("one of its roots");
        for root in 0..subtrees.count() {
            let plain = message(root);
            let packed = compressed(&plain);
            let packed = packed.iter().chain([&plain]);
            seeds.extend(packed.map(|message| [&[choice], &message[..]].concat()));
        }
    }
    seeds
}

/// The bytes on a multiple of 8, as a transport delivers them.
fn aligned(bytes: &[u8], use_it: impl FnOnce(&[u8]) -> bool) -> bool {
    let mut words = vec![0_u64; bytes.len().div_ceil(8)];
    let room: &mut [u8] = bytemuck::cast_slice_mut(&mut words);
    room[..bytes.len()].copy_from_slice(bytes);
    use_it(&room[..bytes.len()])
}

/// A message to a worker.
pub fn batch(bytes: &[u8]) -> bool {
    aligned(bytes, |bytes| match Job::parse(bytes) {
        Err(_) => false,
        Ok(Job::Terminate | Job::Serve) => true,
        Ok(Job::AddSubtree { .. } | Job::RemoveTree { .. } | Job::FetchSubtree { .. }) => true,
        Ok(Job::Elsewhere { body }) => place_of(body).is_ok(),
        Ok(Job::AddTree { body, .. }) => InPlaceTree::parse(body).is_ok(),
        Ok(Job::Plan { body, .. }) => PlanMessage::parse(body).is_ok(),
        Ok(Job::Scenarios(batch)) => {
            let root_pairs = batch.iter().map(|(_, roots)| roots.map_or(0, <[_]>::len)).sum();
            assert_eq!(Job::batch_bytes(batch.len(), root_pairs), bytes.len());
            let scenarios: Vec<&ScenarioRecord> = batch.iter().map(|(record, _)| record).collect();
            assert!(scenarios.windows(2).all(|w| w[0].scenario < w[1].scenario));
            assert!(scenarios.iter().all(|r| r.pose.rotation.iter().all(|x| x.is_finite())));
            // Without scenarios nothing tells where they would start from.
            let is_same = bytes.starts_with(bytemuck::bytes_of(&header_of(&batch)));
            assert!(is_same || batch.is_empty(), "another batch");
            true
        }
    })
}

/// As the master would write it.
fn header_of(batch: &Batch<'_>) -> JobHeader {
    let from_roots = batch.iter().any(|(_, roots)| roots.is_some());
    let &Batch { task, trees, wanted, .. } = batch;
    JobHeader::scenarios(task, trees, batch.len() as u32, from_roots, wanted)
}

fn batch_seeds() -> Vec<Vec<u8>> {
    let batch_at = |accuracy, scenarios: &[u32], roots: u32| {
        let wanted = Wanted { accuracy, pairs: 9, plan: Some(2), ..Wanted::default() };
        let record = |&s: &u32| ScenarioRecord::new(s, Pose::IDENTITY, roots);
        let records: Vec<_> = scenarios.iter().map(record).collect();
        let pairs: Vec<[u32; 2]> = (0..roots * records.len() as u32).map(|n| [n, n + 1]).collect();
        let header = JobHeader::scenarios(7, [1, 2], records.len() as u32, roots > 0, wanted);
        let parts: [&[u8]; 3] = [
            bytemuck::bytes_of(&header),
            bytemuck::cast_slice(&records),
            bytemuck::cast_slice(&pairs),
        ];
        parts.concat()
    };
    let batch = |scenarios: &[u32], roots| batch_at(Accuracy::EXACT, scenarios, roots);
    let deepest = BoxDepth::new(BoxDepth::MAX).expect("the deepest there is");
    let tree = |header: JobHeader, body: &[u8]| [bytemuck::bytes_of(&header), body].concat();
    let place = InPlaceTree { mesh: 3, cut: Cut::Depth(6) };
    let peer = PeerName::from_bytes([9; PeerName::BYTES]);
    let fetch = Fetch { root: 5, peer, patience: Duration::from_millis(500) };
    vec![
        batch(&[], 0),
        batch(&[3], 0),
        batch(&[3, 4, u32::MAX], 0),
        batch(&[3, 4], 2),
        batch_at(Accuracy::BoxesAt(deepest), &[3], 0),
        batch_at(Accuracy::BoxesAt(deepest), &[3, 4], 2),
        batch_at(Accuracy::Pairs(TriangleTest::F32), &[3, 4], 0),
        tree(JobHeader::add_tree(2), &place.to_bytes()),
        tree(JobHeader::remove_tree(2), &[]),
        tree(JobHeader::plan(2), &PlanMessage { plan: Plan::default(), parts: vec![] }.to_bytes()),
        tree(JobHeader::terminate(), &[]),
        tree(JobHeader::serve(), &[]),
        tree(JobHeader::fetch_subtree(2), &fetch.to_bytes()),
    ]
}

/// A message from a worker.
pub fn result(bytes: &[u8]) -> bool {
    aligned(bytes, |bytes| match Reply::parse(bytes) {
        Err(_) => false,
        Ok(Reply::Ready | Reply::Tree(_) | Reply::Serves(_) | Reply::NotFetched(_)) => true,
        Ok(Reply::Answers { answers, words, .. }) => {
            let carried: usize = answers.iter().map(|a| a.words_here as usize).sum();
            assert_eq!(carried, words.len());
            assert!(answers.windows(2).all(|w| w[0].scenario < w[1].scenario));
            assert!(answers.iter().all(|a| a.first_word + a.words_here <= a.words));
            true
        }
    })
}

fn result_seeds() -> Vec<Vec<u8>> {
    let ready = ReplyHeader::ready();
    let tree = TreeRecord::new(5, 6);
    let lacking = SubtreeRecord { tree: 5, root: 6 };
    let mut whole = AnswerRecord::answered(10, 2, 77, 5);
    (whole.words, whole.words_here) = (2, 2);
    let mut part = AnswerRecord::answered(11, 9, 88, 6);
    (part.words, part.first_word, part.words_here) = (9, 4, 1);
    let answers = [whole, part, AnswerRecord::overflow(12, (345, 2), 7)];
    let pairs: [Pair; 3] = [[1, 2], [3, 4], [5, 6]];
    let header = ReplyHeader::answers(42, 3, 3, true);
    let header = bytemuck::bytes_of(&header);
    vec![
        bytemuck::bytes_of(&ready).to_vec(),
        [bytemuck::bytes_of(&ReplyHeader::tree()), bytemuck::bytes_of(&tree)].concat(),
        [bytemuck::bytes_of(&ReplyHeader::serves()), &[9; PeerName::BYTES]].concat(),
        [bytemuck::bytes_of(&ReplyHeader::not_fetched()), bytemuck::bytes_of(&lacking)].concat(),
        [header, bytemuck::cast_slice(&answers), bytemuck::cast_slice(&pairs)].concat(),
    ]
}

const FORMATS: [Format; 6] =
    [Format::Ply, Format::Obj, Format::Stl, Format::Glb, Format::Gltf, Format::Vrml];

/// The first byte says the format, or that it is to be found out; the rest is a file. Some of what is
/// read is built into a tree of each kind, too.
pub fn mesh(bytes: &[u8]) -> bool {
    let Some((&choice, file)) = bytes.split_first() else { return false };
    let format = match FORMATS.get(usize::from(choice)) {
        Some(format) => *format,
        None => match Format::of(Path::new("mesh"), file) {
            Ok(format) => format,
            Err(_) => return false,
        },
    };
    // A place without siblings to be read.
    let Ok(mesh) = format.parse(file, Path::new("/nonexistent")) else { return false };
    assert!(mesh.vertices().as_flattened().iter().all(|c| c.is_finite()));
    let vertices = mesh.vertices().len();
    assert!(mesh.faces().as_flattened().iter().all(|&i| (i as usize) < vertices));
    // One in sixteen, as a build takes long beside a look at a file.
    if mesh.faces().len() <= 16 && file.len() % 16 == 0 {
        for kind in TreeKind::ALL {
            let tree = build(&mesh, BuildOptions { kind });
            assert!(TreeView::new(tree.blocks()).is_ok_and(|view| use_image(&view)));
        }
    }
    true
}

fn mesh_seeds() -> Vec<Vec<u8>> {
    let bodies = [Body::house(), Body::crooked()];
    let variants = bodies.iter().flat_map(every_variant);
    let seed = |variant: super::writers::Variant| {
        let format = Format::of(Path::new(variant.name), &variant.bytes).expect("a known format");
        let choice = FORMATS.iter().position(|f| *f == format).expect("one of all");
        [&[choice as u8][..], &variant.bytes].concat()
    };
    variants.map(seed).collect()
}

/// A file of hard cases or of continuous queries.
pub fn suite(bytes: &[u8]) -> bool {
    let finite = |numbers: &[f64]| assert!(numbers.iter().all(|c| c.is_finite()));
    if let Ok(suite) = QuerySuite::parse(bytes, "queries") {
        assert!(!suite.queries.is_empty());
        suite.queries.iter().for_each(|query| {
            finite(query.start.as_flattened());
            finite(query.end.as_flattened());
            // Any finite numbers have an answer.
            query.answer(1e-9);
        });
        return true;
    }
    let Ok(suite) = Suite::parse(bytes, "suite") else { return false };
    assert!(!suite.is_empty());
    match &suite.cases {
        Cases::Pairs(cases) => cases.iter().for_each(|case| {
            finite(case.a.as_flattened());
            finite(case.b.as_flattened());
        }),
        Cases::Meshes(cases) => cases.iter().for_each(|case| {
            let sizes = [&case.fixed, &case.moving].map(|mesh| mesh.faces().len());
            assert!(case.pairs.is_sorted_by(|a, b| a < b));
            assert!(case.pairs.iter().all(|pair| (0..2).all(|s| (pair[s] as usize) < sizes[s])));
            finite(&case.pose.rotation);
        }),
        Cases::Transforms(cases) => cases.iter().for_each(|case| {
            finite(&case.rotation);
            finite(&case.placed);
        }),
    }
    true
}

fn suite_seeds() -> Vec<Vec<u8>> {
    let numbers = |count: usize| {
        let bits = (0..count).map(|i| (0.5 * i as f64 - 2.0).to_bits());
        bits.map(|bits| format!(" {bits:016x}")).collect::<String>()
    };
    let mesh = format!("{}f 0 1 2\nf 2 1 0\n", format!("v{}\n", numbers(3)).repeat(3));
    let pose = format!("q{}\nR{}\nt{}\n", numbers(4), numbers(9), numbers(3));
    let texts = [
        format!("# pairs\nany 1 point{}\n\nany 0 none{}\n", numbers(18), numbers(18)),
        format!("case twins_00 3 2 3 2 2\n{pose}{mesh}{mesh}p 0 1\np 1 0\n"),
        format!("{}\n{}", numbers(22), numbers(22)),
        format!("mine vf 0{}\nmine ee 1{}", numbers(24), numbers(24)),
    ];
    texts.map(String::into_bytes).into()
}
