use std::collections::VecDeque;

use super::*;
use crate::mesh::TriangleMesh;
use crate::transport::TransportError;
use crate::transport::peer::PeerName;
use crate::tree::roots::CutTree;
use crate::tree::{BuildOptions, TreeImage, TreeKind, TreeView, build};
use crate::wire::{AnswerStatus, Fetch, JobHeader, Reply, ScenarioRecord};

/// Delivers what is in it, keeps what is sent.
#[derive(Default)]
struct Loopback {
    jobs: VecDeque<Vec<u8>>,
    replies: Vec<Vec<u8>>,
}

impl WorkerEnd for Loopback {
    type Message = Vec<u8>;

    fn receive(&mut self) -> Result<Vec<u8>, TransportError> {
        self.jobs.pop_front().ok_or(TransportError::MasterGone)
    }

    fn send(&mut self, parts: &[&[u8]]) -> Result<(), TransportError> {
        self.replies.push(parts.concat());
        Ok(())
    }
}

/// Every tree is this one, and a shorter one when one was removed; or none, while it lacks a subtree
/// that it was to fetch, which nobody has.
struct OneTree(TreeImage, Option<u32>);

impl TreeStore<Loopback> for OneTree {
    fn add(&mut self, _: &mut Loopback, _: u32, _: &[u8]) -> Result<u64, WorkerError> {
        Ok(self.0.view().hash())
    }

    fn add_subtree(&mut self, _: u32, body: &[u8]) -> Result<u32, WorkerError> {
        let root = u32::from_ne_bytes(body.try_into().unwrap());
        self.1.take_if(|lacking| *lacking == root);
        Ok(root)
    }

    fn fetch_subtree(&mut self, _: u32, fetch: &Fetch) -> Result<bool, WorkerError> {
        self.1 = Some(fetch.root);
        Ok(false)
    }

    fn remove(&mut self, _: u32) -> Result<(), WorkerError> {
        *self = ruler(2);
        Ok(())
    }

    fn plan(&mut self, _: &mut Loopback, body: &[u8]) -> Result<Vec<u8>, WorkerError> {
        Ok(body.to_vec())
    }

    fn whole(&self, tree: u32) -> Result<TreeView<'_>, WorkerError> {
        match self.1 {
            None => Ok(self.0.view()),
            Some(_) => Err(WorkerError::Tree(tree)),
        }
    }

    fn cut(&self, tree: u32) -> Result<CutTree<'_>, WorkerError> {
        Err(WorkerError::Tree(tree))
    }
}

/// Triangles, a metre apart along x: four of them moved by n metres, 4 - n are where others are.
fn ruler(count: u32) -> OneTree {
    let corners = |n: u32| {
        let x = f64::from(n);
        [[x, 0.0, 0.0], [x + 0.5, 0.0, 0.0], [x, 0.5, 0.0]]
    };
    let vertices = (0..count).flat_map(corners).collect();
    let faces = (0..count).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
    let mesh = TriangleMesh::new(vertices, faces).unwrap();
    OneTree(build(&mesh, BuildOptions { kind: TreeKind::Obb }), None)
}

fn moved(x: f64) -> Pose {
    Pose { translation: [x, 0.0, 0.0], ..Pose::IDENTITY }
}

fn batch(scenarios: &[(u32, Pose)], pairs: bool) -> Vec<u8> {
    let pairs = if pairs { Wanted::ALL_PAIRS } else { 0 };
    batch_wanting(scenarios, Wanted { pairs, ..Wanted::default() })
}

fn batch_wanting(scenarios: &[(u32, Pose)], wanted: Wanted) -> Vec<u8> {
    let record = |&(n, pose)| ScenarioRecord::new(n, pose, 0);
    let records: Vec<_> = scenarios.iter().map(record).collect();
    let header = JobHeader::scenarios(9, [0, 1], records.len() as u32, false, wanted);
    [bytemuck::bytes_of(&header), bytemuck::cast_slice(&records)].concat()
}

/// What the worker sends before it ends, told to do so after the last of the jobs.
fn replies(jobs: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, WorkerError> {
    let terminate = bytemuck::bytes_of(&JobHeader::terminate()).to_vec();
    let jobs = jobs.into_iter().chain([terminate]).collect();
    let mut transport = Loopback { jobs, ..Default::default() };
    let (bookmark, _) = Bookmark::new().unwrap();
    serve(&mut transport, &mut ruler(4), Slowdown::NONE, &bookmark)?;
    assert_eq!(bookmark.scenario(), None);
    Ok(transport.replies)
}

#[test]
fn a_batch_is_answered_and_an_overflow_reported_with_its_vertex() {
    let mut far = moved(0.0);
    far.rotation[0] = 0.7 * f64::MAX;
    let jobs = vec![batch(&[(3, moved(2.0)), (4, far), (8, moved(5.0))], true)];
    let replies = replies(jobs).unwrap();
    let [ready, first, others] = &replies[..] else { panic!("{} messages", replies.len()) };
    assert_eq!(Reply::parse(ready), Ok(Reply::Ready));
    let Ok(Reply::Answers { task: 9, last: false, answers, words, .. }) = Reply::parse(first)
    else {
        panic!("not the first answer");
    };
    assert_eq!(words, [[2_u32, 0], [3, 1]].map(bytemuck::cast::<Pair, u64>));
    assert_eq!((answers.len(), answers[0].scenario), (1, 3));
    assert_eq!(answers[0].pairs_fnv1a64, pairs_fnv1a64(&[[2, 0], [3, 1]]));
    let Ok(Reply::Answers { task: 9, last: true, answers, .. }) = Reply::parse(others) else {
        panic!("not answers");
    };
    assert_eq!(answers.iter().map(|a| a.scenario).collect::<Vec<_>>(), [4, 8]);
    assert_eq!(answers[0].status(), AnswerStatus::Overflow { triangle: 1, corner: 1 });
    assert_eq!((answers[1].status(), answers[1].pair_count), (AnswerStatus::Answered, 0));
}

#[test]
fn pairs_are_counted_and_hashed_but_not_sent_unless_asked_for() {
    let replies = replies(vec![batch(&[(0, moved(1.0))], false)]).unwrap();
    let Ok(Reply::Answers { answers, words, .. }) = Reply::parse(&replies[1]) else {
        panic!("not answers");
    };
    assert_eq!((answers[0].pair_count, words.len()), (3, 0));
    assert_eq!(answers[0].pairs_fnv1a64, pairs_fnv1a64(&[[1, 0], [2, 1], [3, 2]]));
}

#[test]
fn boxes_are_kept_from_batch_to_batch_until_a_tree_of_theirs_is_removed() {
    let at = |depth| {
        let accuracy = Accuracy::BoxesAt(BoxDepth::new(depth).unwrap());
        let wanted = Wanted { accuracy, ..Wanted::default() };
        batch_wanting(&[(0, moved(0.0)), (1, moved(1.0))], wanted)
    };
    let remove = bytemuck::bytes_of(&JobHeader::remove_tree(1)).to_vec();
    let jobs = vec![at(2), at(2), at(0), at(2), remove, at(2)];
    let counts = replies(jobs).unwrap().iter().fold(Vec::new(), |mut counts, reply| {
        if let Ok(Reply::Answers { answers, .. }) = Reply::parse(reply) {
            counts.extend(answers.iter().map(|answer| answer.pair_count));
        }
        counts
    });
    // Four boxes of one triangle, one of all, and two.
    assert_eq!(counts, [4, 3, 4, 3, 1, 1, 4, 3, 2, 1]);
}

/// Two tasks, of which each lacks a subtree; the master sends them last, and others before.
#[test]
fn what_cannot_be_fetched_is_told_and_awaited_and_nothing_overtakes_it() {
    let peer = PeerName::from_bytes([1; PeerName::BYTES]);
    let with_body = |header: JobHeader, body: &[u8]| [bytemuck::bytes_of(&header), body].concat();
    let fetch = |root| {
        let fetch = Fetch { root, peer, patience: Duration::ZERO };
        with_body(JobHeader::fetch_subtree(0), &fetch.to_bytes())
    };
    let send = |root: u32| with_body(JobHeader::add_subtree(0), &root.to_ne_bytes());
    let task = |scenario| batch(&[(scenario, moved(1.0))], false);
    let jobs = vec![fetch(5), task(0), fetch(6), task(1), send(4), send(5), send(7), send(6)];
    let replies = replies(jobs).unwrap();
    let replies: Vec<_> = replies.iter().map(|reply| Reply::parse(reply).unwrap()).collect();
    let lacks = |root| Reply::NotFetched(SubtreeRecord { tree: 0, root });
    let Reply::Answers { answers: [first], .. } = replies[2] else { panic!("{replies:?}") };
    assert_eq!((first.scenario, first.pair_count), (0, 3));
    assert_eq!((replies[0], replies[1]), (Reply::Ready, lacks(5)));
    let rest = &replies[replies.len() - 2..];
    assert_eq!(rest[0], lacks(6));
    let Reply::Answers { answers: [second], last: true, .. } = rest[1] else { panic!("{rest:?}") };
    assert_eq!(second.scenario, 1);
}

#[test]
fn a_worker_that_is_told_to_end_while_it_waits_for_a_subtree_ends() {
    let fetch = Fetch {
        root: 5,
        peer: PeerName::from_bytes([1; PeerName::BYTES]),
        patience: Duration::ZERO,
    };
    let header = JobHeader::fetch_subtree(0);
    let job = [bytemuck::bytes_of(&header), &fetch.to_bytes()].concat();
    assert_eq!(replies(vec![job, batch(&[(0, moved(1.0))], false)]).unwrap().len(), 2);
}

#[test]
fn a_damaged_batch_ends_the_worker_with_an_error() {
    assert!(matches!(replies(vec![vec![0; 32]]), Err(WorkerError::Wire(_))));
}

#[test]
fn a_worker_that_fails_at_a_scenario_has_left_its_bookmark_there() {
    let mut record = batch(&[(6, moved(1.0))], false);
    // From root pairs, of which this store has none.
    let from_roots = JobHeader::scenarios(9, [0, 1], 1, true, Wanted::default());
    record[..size_of::<JobHeader>()].copy_from_slice(bytemuck::bytes_of(&from_roots));
    let mut transport = Loopback { jobs: [record].into(), ..Default::default() };
    let (bookmark, _) = Bookmark::new().unwrap();
    let ended = serve(&mut transport, &mut ruler(4), Slowdown::NONE, &bookmark);
    assert!(matches!(ended, Err(WorkerError::Tree(0))));
    assert_eq!(bookmark.scenario(), Some(6));
}
