//! Subtrees that are sent, put together and taken away again, against whole trees.

use std::collections::BTreeSet;
use std::ops::Deref;
use std::path::Path;
use std::rc::Rc;

use bumper::geometry::{Pose, Triangle};
use bumper::mesh::TriangleMesh;
use bumper::transport::shared_memory::{Growing, SharedMemory};
use bumper::transport::{Needs, WakeUp};
use bumper::tree::descent::{Descent, DescentError, Pair};
use bumper::tree::roots::{Cut, DistributedRoot, PreAnalysis, RootError, RootPair};
use bumper::tree::subtree::{
    CommonTree, PartialTree, Region, SeenTree, SubtreeError, Subtrees, compressed,
};
use bumper::tree::{BuildOptions, TreeImage, TreeKind, build};
use proptest::prelude::*;

/// A grid of triangles that share vertices, bent so that no two boxes are alike.
fn sheet(cells: u32, bend: f64) -> TriangleMesh {
    let across = cells + 1;
    let place = |i: u32| f64::from(i) / f64::from(cells) - 0.5;
    let vertices = (0..across * across).map(|v| {
        let (x, y) = (place(v % across), place(v / across));
        [x, y, bend * (x * x - y * y) + 0.1 * (7.0 * x).sin()]
    });
    let faces = (0..cells * cells).flat_map(|cell| {
        let corner = cell % cells + cell / cells * across;
        [[corner, corner + 1, corner + across], [corner + 1, corner + across + 1, corner + across]]
    });
    TriangleMesh::new(vertices.collect(), faces.collect()).unwrap()
}

fn soup(triangles: &[Triangle]) -> TriangleMesh {
    let faces = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(triangles.as_flattened().to_vec(), faces).unwrap()
}

fn tree_of(mesh: &TriangleMesh, kind: TreeKind) -> TreeImage {
    build(mesh, BuildOptions { kind })
}

fn received(subtrees: &Subtrees<'_>) -> PartialTree {
    PartialTree::new(&subtrees.outline()).unwrap()
}

fn any_mesh() -> impl Strategy<Value = TriangleMesh> {
    let point = prop::array::uniform3(-1.0..1.0_f64);
    prop_oneof![
        (1..12_u32, 0.0..1.0_f64).prop_map(|(cells, bend)| sheet(cells, bend)),
        prop::collection::vec(prop::array::uniform3(point), 1..80).prop_map(|t| soup(&t)),
    ]
}

fn any_cut() -> impl Strategy<Value = Cut> {
    prop_oneof![(0..8_u32).prop_map(Cut::Depth), (0..60_u32).prop_map(Cut::Triangles)]
}

/// Rotations, and poses that 32 bits are not made for.
fn any_pose() -> impl Strategy<Value = Pose> {
    let matrix = [0.9, 0.1, -0.2, 0.0, 1.1, 0.3, 0.2, -0.1, 0.8];
    let turn = [0.5, -0.5, 0.5, 0.5];
    (any::<bool>(), prop::array::uniform3(-0.3..0.3_f64)).prop_map(move |(skewed, translation)| {
        if skewed {
            Pose { rotation: matrix, translation }
        } else {
            Pose::from_quaternion(turn, translation)
        }
    })
}

/// Numbers of the root above each triangle of the mesh.
fn roots_of(tree: &TreeImage, roots: &[DistributedRoot]) -> Vec<u32> {
    let view = tree.view();
    let mut of = vec![0; view.triangle_count() as usize];
    for (number, root) in (0..).zip(roots) {
        for rank in root.ranks() {
            of[view.triangles()[rank as usize].id as usize] = number;
        }
    }
    of
}

fn sorted(mut pairs: Vec<Pair>) -> Vec<Pair> {
    pairs.sort_unstable();
    pairs
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn subtrees_added_and_removed_in_any_order_answer_as_the_whole_tree(
        meshes in (any_mesh(), any_mesh()),
        cuts in (any_cut(), any_cut()),
        pose in any_pose(),
        steps in prop::collection::vec(any::<(bool, prop::sample::Index)>(), 1..40),
    ) {
        for kind in TreeKind::ALL {
            let whole = [tree_of(&meshes.0, kind), tree_of(&meshes.1, kind)];
            let [a, b] = [whole[0].view(), whole[1].view()];
            let sent = [Subtrees::new(a, cuts.0), Subtrees::new(b, cuts.1)];
            let mut here = [received(&sent[0]), received(&sent[1])];
            let mut held = [BTreeSet::new(), BTreeSet::new()];
            for &(moving, which) in &steps {
                let side = usize::from(moving);
                let root = which.index(sent[side].count() as usize) as u32;
                if held[side].remove(&root) {
                    here[side].remove(root).unwrap();
                } else {
                    let message = sent[side].message(root).unwrap();
                    prop_assert_eq!(message.len(), sent[side].message_length(root).unwrap());
                    // Every other one compressed, if that makes it smaller.
                    let packed = compressed(&message).filter(|_| root.is_multiple_of(2));
                    let message = packed.unwrap_or(message);
                    prop_assert_eq!(here[side].add(&message).unwrap(), root);
                    held[side].insert(root);
                }
            }
            let analysis = PreAnalysis::new(a, cuts.0, b, cuts.1);
            let roots: Vec<RootPair> =
                held[0].iter().flat_map(|&i| held[1].iter().map(move |&j| [i, j])).collect();
            let (mut found, mut all) = (Vec::new(), Vec::new());
            let mut descent = Descent::default();
            let [fixed, moving] = [here[0].cut_tree(), here[1].cut_tree()];
            descent.all_pairs_below(&fixed, &moving, &pose, &roots, &mut found).unwrap();
            descent.all_pairs(&a, &b, &pose, &mut all).unwrap();
            let of_a = roots_of(&whole[0], analysis.fixed_roots());
            let of_b = roots_of(&whole[1], analysis.moving_roots());
            all.retain(|&[i, j]| {
                held[0].contains(&of_a[i as usize]) && held[1].contains(&of_b[j as usize])
            });
            prop_assert_eq!(sorted(found), sorted(all));
            for root in 0..sent[0].count() {
                prop_assert_eq!(here[0].holds(root), held[0].contains(&root));
            }
        }
    }

    #[test]
    fn damaged_messages_are_refused_and_change_nothing(
        mesh in any_mesh(), cut in any_cut(), which in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(), flip in 1..=255_u8,
    ) {
        for kind in TreeKind::ALL {
            let tree = tree_of(&mesh, kind);
            let subtrees = Subtrees::new(tree.view(), cut);
            let root = which.index(subtrees.count() as usize) as u32;
            let plain = subtrees.message(root).unwrap();
            for mut message in compressed(&plain).into_iter().chain([plain]) {
                let mut here = received(&subtrees);
                let at = at.index(message.len());
                message[at] ^= flip;
                prop_assert!(here.add(&message).is_err());
                prop_assert!(here.add(&message[..at]).is_err());
                prop_assert!(!here.holds(root));
                message[at] ^= flip;
                prop_assert!(here.add(&message[..at]).is_err());
                prop_assert_eq!(here.add(&message).unwrap(), root);
            }
        }
    }

    /// As an attacker would: the hash is right.
    #[test]
    fn hostile_messages_are_refused_or_harmless(
        mesh in any_mesh(), cut in any_cut(), which in any::<prop::sample::Index>(),
        at in any::<prop::sample::Index>(), value: u32, in_outline: bool, is_compressed: bool,
    ) {
        for kind in TreeKind::ALL {
            let tree = tree_of(&mesh, kind);
            let subtrees = Subtrees::new(tree.view(), cut);
            let mut outline = subtrees.outline();
            if in_outline {
                hostile(&mut outline, at, value);
            }
            let Ok(mut here) = PartialTree::new(&outline) else { continue };
            let chosen = which.index(subtrees.count() as usize) as u32;
            for root in 0..subtrees.count() {
                let plain = subtrees.message(root).unwrap();
                let packed = compressed(&plain).filter(|_| is_compressed);
                let mut message = packed.unwrap_or(plain);
                if !in_outline && root == chosen {
                    hostile(&mut message, at, value);
                }
                let _ = here.add(&message);
            }
            let held: Vec<u32> = (0..subtrees.count()).filter(|&root| here.holds(root)).collect();
            let roots: Vec<RootPair> =
                held.iter().flat_map(|&i| held.iter().map(move |&j| [i, j])).collect();
            let mut pairs = Vec::new();
            let cut = here.cut_tree();
            // Any answer will do, as long as there is one.
            let _ =
                Descent::default().all_pairs_below(&cut, &cut, &Pose::IDENTITY, &roots, &mut pairs);
            for root in held {
                here.remove(root).unwrap();
            }
        }
    }
}

/// Where the hashed part of a message begins.
const HASHED_FROM: usize = 32;

fn hostile(message: &mut [u8], at: prop::sample::Index, value: u32) {
    let word = HASHED_FROM / 4 + at.index((message.len() - HASHED_FROM) / 4);
    message[4 * word..4 * word + 4].copy_from_slice(&value.to_le_bytes());
    set_hash(message);
}

/// The length too, which is the 8 bytes before it.
fn set_hash(message: &mut [u8]) {
    let length = message.len() as u64;
    message[HASHED_FROM - 16..HASHED_FROM - 8].copy_from_slice(&length.to_ne_bytes());
    let hash = xxhash_rust::xxh3::xxh3_64(&message[HASHED_FROM..]);
    message[HASHED_FROM - 8..HASHED_FROM].copy_from_slice(&hash.to_le_bytes());
}

#[test]
fn every_flipped_byte_and_every_truncation_is_refused() {
    let mesh = sheet(6, 0.3);
    for kind in TreeKind::ALL {
        let tree = tree_of(&mesh, kind);
        let subtrees = Subtrees::new(tree.view(), Cut::Depth(2));
        let outline = subtrees.outline();
        let message = subtrees.message(1).unwrap();
        let mut here = received(&subtrees);
        for at in 0..outline.len() {
            let mut damaged = outline.clone();
            damaged[at] ^= 1;
            assert!(PartialTree::new(&damaged).is_err(), "byte {at} of the outline ({kind})");
            assert!(PartialTree::new(&outline[..at]).is_err());
        }
        for at in 0..message.len() {
            let mut damaged = message.clone();
            damaged[at] ^= 1;
            assert!(here.add(&damaged).is_err(), "byte {at} ({kind})");
            assert!(here.add(&message[..at]).is_err());
        }
        let longer = [&message[..], &[0; 4]].concat();
        assert!(matches!(here.add(&longer), Err(SubtreeError::Length { .. })));
        here.add(&message).unwrap();
    }
}

/// Whole by their headers: as an attacker would, or a program that has gone wrong.
#[test]
fn compressed_bytes_that_are_not_those_of_the_subtree_are_refused_and_take_no_memory() {
    const HEADER: usize = 48;
    let mesh = sheet(12, 0.3);
    for kind in TreeKind::ALL {
        let tree = tree_of(&mesh, kind);
        let subtrees = Subtrees::new(tree.view(), Cut::Depth(2));
        let plain = subtrees.message(1).unwrap();
        let packed = compressed(&plain).unwrap();
        assert!(packed.len() < plain.len());
        let mut here = received(&subtrees);
        let mut refused = |block: &[u8]| {
            let mut message = [&packed[..HEADER], block].concat();
            set_hash(&mut message);
            assert!(matches!(here.add(&message), Err(SubtreeError::Malformed(_))), "{kind}");
        };
        let block = &packed[HEADER..];
        for end in 0..block.len() {
            refused(&block[..end]);
        }
        refused(&[block, &[0]].concat());
        refused(&plain[HEADER..]);
        let other = compressed(&subtrees.message(0).unwrap()).unwrap();
        refused(&other[HEADER..]);
        // A run of a byte as long as a block can tell of: 255 times its own length.
        let bomb = [&[0x1f, 7, 1, 0][..], &[255; 1 << 20], &[0]].concat();
        refused(&bomb);
        // What the header says of shared vertices is part of the length.
        let mut hungry = packed.clone();
        hungry[HEADER - 4..HEADER].copy_from_slice(&u32::MAX.to_ne_bytes());
        set_hash(&mut hungry);
        assert!(matches!(here.add(&hungry), Err(SubtreeError::Malformed(_))), "{kind}");
        assert_eq!(here.add(&packed).unwrap(), 1);
    }
}

#[test]
fn what_is_not_here_or_is_here_twice_is_refused_by_its_number() {
    let (mesh, other) = (sheet(6, 0.3), sheet(6, 0.4));
    for kind in TreeKind::ALL {
        let trees = [tree_of(&mesh, kind), tree_of(&other, kind)];
        let cut = Cut::Depth(2);
        let [subtrees, foreign] = [0, 1].map(|i: usize| Subtrees::new(trees[i].view(), cut));
        let mut here = received(&subtrees);
        let not_held = RootError::NotHeld { root: 2 };
        assert_eq!(here.remove(2), Err(not_held.clone()));
        assert_eq!(here.remove(9), Err(RootError::Unknown { root: 9, roots: 4 }));
        here.add(&subtrees.message(1).unwrap()).unwrap();
        let twice = here.add(&subtrees.message(1).unwrap());
        assert!(matches!(twice, Err(SubtreeError::Held { root: 1 })));
        let other = here.add(&foreign.message(0).unwrap());
        assert!(matches!(other, Err(SubtreeError::OtherImage { .. })));
        let mut pairs = Vec::new();
        let cut = here.cut_tree();
        let asked =
            Descent::default().all_pairs_below(&cut, &cut, &Pose::IDENTITY, &[[1, 2]], &mut pairs);
        assert_eq!(asked, Err(DescentError::Root { tree: "moving", source: not_held }));
        assert!(pairs.is_empty());
    }
}

#[test]
fn a_subtree_costs_its_own_memory_and_gives_it_back() {
    let mesh = sheet(150, 0.3);
    for kind in TreeKind::ALL {
        let tree = tree_of(&mesh, kind);
        let subtrees = Subtrees::new(tree.view(), Cut::Depth(3));
        let mut here = received(&subtrees);
        let bytes = tree.view().header().byte_length as usize;
        let before = here.memory();
        assert!(before < bytes / 20, "{before} of {bytes} ({kind})");
        for root in 0..subtrees.count() {
            let message = subtrees.message(root).unwrap();
            here.add(&message).unwrap();
            // Pages at both ends of five sections are cut, and shared vertices lie scattered.
            let most = before + message.len() * 5 / 4 + 12 * 4096;
            assert!(here.memory() <= most, "{} {most} ({kind})", here.memory());
            here.remove(root).unwrap();
            assert_eq!(here.memory(), before);
        }
    }
}

/// A region that both sides of a test have.
#[derive(Clone)]
struct Common(Rc<Growing>);

impl Deref for Common {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}

impl Region for Common {
    fn write(&self, at: usize, bytes: &[u8]) -> std::io::Result<()> {
        self.0.write(at, bytes)
    }
}

fn memory(base: &Path) -> SharedMemory {
    SharedMemory::create(base, &Needs { workers: 1, job_bytes: 64, wake_up: WakeUp::Block })
        .unwrap()
}

/// What a node's leader puts into memory that grows, a worker sees there, and nothing else.
#[test]
fn a_worker_sees_what_its_leader_was_sent_as_soon_as_it_looks() {
    let base = tempfile::tempdir().unwrap();
    let memory = memory(base.path());
    let mesh = sheet(20, 0.7);
    let (cut, pose) = (Cut::Triangles(60), Pose::from_quaternion([0.5, 0.5, 0.5, 0.5], [0.0; 3]));
    for (number, kind) in (0..).zip(TreeKind::ALL) {
        let whole = tree_of(&mesh, kind);
        let sent = Subtrees::new(whole.view(), cut);
        let mut region = None;
        let make = |bytes| {
            let common = Common(Rc::new(memory.grow(number, bytes).unwrap()));
            Ok(region.insert(common).clone())
        };
        let mut leaders = CommonTree::new(&sent.outline(), make).unwrap();
        let mut workers = SeenTree::new(region.unwrap()).unwrap();
        assert_eq!((workers.hash(), sent.count() > 4), (whole.view().hash(), true), "{kind:?}");

        let half: Vec<_> = (0..sent.count()).step_by(2).collect();
        for &root in &half {
            let message = sent.message(root).unwrap();
            let message = compressed(&message).filter(|_| root % 4 == 0).unwrap_or(message);
            assert_eq!(leaders.add(&message).unwrap(), root);
            assert!(matches!(leaders.add(&message), Err(SubtreeError::Held { .. })));
        }
        let pairs: Vec<RootPair> =
            half.iter().flat_map(|&i| half.iter().map(move |&j| [i, j])).collect();
        let below = |tree: &SeenTree<Common>, pairs: &[RootPair]| {
            let (mut descent, mut found) = (Descent::default(), Vec::new());
            let tree = tree.cut_tree();
            let outcome = descent.all_pairs_below(&tree, &tree, &pose, pairs, &mut found);
            outcome.map(|_| sorted(found))
        };
        let unseen = below(&workers, &pairs);
        let not_held = RootError::NotHeld { root: half[0] };
        assert!(matches!(unseen, Err(DescentError::Root { source, .. }) if source == not_held));
        workers.look();
        let mut received = received(&sent);
        half.iter().for_each(|&root| drop(received.add(&sent.message(root).unwrap())));
        let (mut descent, mut expected) = (Descent::default(), Vec::new());
        let tree = received.cut_tree();
        descent.all_pairs_below(&tree, &tree, &pose, &pairs, &mut expected).unwrap();
        assert!(!expected.is_empty());
        assert_eq!(below(&workers, &pairs), Ok(sorted(expected)), "{kind:?}");
        assert!(below(&workers, &[[1, half[0]]]).is_err() && workers.whole().is_none());
    }
}

#[test]
fn memory_that_no_leader_has_made_is_refused() {
    let base = tempfile::tempdir().unwrap();
    let memory = memory(base.path());
    let whole = tree_of(&sheet(6, 0.3), TreeKind::Wide);
    let sent = Subtrees::new(whole.view(), Cut::Depth(2));
    let mut region = None;
    let make = |bytes| Ok(region.insert(Common(Rc::new(memory.grow(0, bytes).unwrap()))).clone());
    CommonTree::new(&sent.outline(), make).unwrap();
    let good = region.unwrap();
    assert!(SeenTree::new(&*good).is_ok());
    for length in [0, 7, 64, good.len() - 64] {
        assert!(SeenTree::new(&good[..length]).is_err(), "{length} of {} bytes", good.len());
    }
    let written = |at: usize, bytes: &[u8]| {
        let before = good[at..at + bytes.len()].to_vec();
        good.write(at, bytes).unwrap();
        let refused = SeenTree::new(&*good).is_err();
        good.write(at, &before).unwrap();
        refused
    };
    assert!(written(0, &u64::MAX.to_ne_bytes()) && written(0, &[0; 8]) && written(64, b"x"));
    assert!(SeenTree::new(&*good).is_ok());
}
