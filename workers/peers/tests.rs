//! Workers that are what they should be, and others.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use crate::geometry::Pose;
use crate::mesh::MeshSource;
use crate::transport::peer::{PeerListener, PeerName, PeerStream};
use crate::transport::{Message, TransportError, WorkerEnd};
use crate::tree::descent::Descent;
use crate::tree::roots::Cut;
use crate::tree::subtree::{Subtrees, compressed};
use crate::tree::{BuildOptions, TreeImage, TreeKind, build};
use crate::wire::{Fetch, SubtreeRequest, SubtreeResponse};
use crate::workers::tree_store::{Received, TreeStore};

const LONG: Duration = Duration::from_secs(60);
const SHORT: Duration = Duration::from_millis(30);
const TREE: u32 = 7;

fn tree() -> TreeImage {
    let mesh = "builtin:car?triangles=1000".parse::<MeshSource>().unwrap().load().unwrap();
    build(&mesh, BuildOptions { kind: TreeKind::Wide })
}

/// There is no master here.
struct Nobody;

impl WorkerEnd for Nobody {
    type Message = Message;

    fn receive(&mut self) -> Result<Message, TransportError> {
        Err(TransportError::MasterGone)
    }

    fn send(&mut self, _: &[&[u8]]) -> Result<(), TransportError> {
        Err(TransportError::MasterGone)
    }
}

/// A worker that was told of the tree.
struct Worker(Received);

impl Worker {
    fn new(subtrees: &Subtrees<'_>) -> Self {
        let mut received = Received::default();
        received.add(&mut Nobody, TREE, &subtrees.outline()).unwrap();
        Self(received)
    }

    fn serve(&mut self) -> PeerName {
        TreeStore::<Nobody>::serve(&mut self.0).unwrap()
    }

    fn add(&mut self, message: &[u8]) -> u32 {
        TreeStore::<Nobody>::add_subtree(&mut self.0, TREE, message).unwrap()
    }

    fn fetch(&mut self, root: u32, peer: PeerName, patience: Duration) -> bool {
        let fetch = Fetch { root, peer, patience };
        TreeStore::<Nobody>::fetch_subtree(&mut self.0, TREE, &fetch).unwrap()
    }

    fn holds(&self, root: u32) -> bool {
        let cut = TreeStore::<Nobody>::cut(&self.0, TREE).unwrap();
        let pair = [[root, root]];
        Descent::default().any_pair_below(&cut, &cut, &Pose::IDENTITY, &pair).is_ok()
    }
}

#[test]
fn a_subtree_goes_from_worker_to_worker_to_worker() {
    let tree = tree();
    let subtrees = Subtrees::new(tree.view(), Cut::Depth(4));
    let mut workers = [0; 3].map(|_| Worker::new(&subtrees));
    let names = workers.each_mut().map(Worker::serve);
    for root in 0..subtrees.count() {
        let plain = subtrees.message(root).unwrap();
        let message = compressed(&plain).filter(|_| root.is_multiple_of(2)).unwrap_or(plain);
        assert_eq!(workers[0].add(&message), root);
        assert!(workers[1].fetch(root, names[0], LONG));
        assert!(workers[2].fetch(root, names[1], LONG), "from one that has fetched it itself");
        assert!(workers[2].holds(root));
    }
}

#[test]
fn two_workers_fetch_from_each_other_at_the_same_time() {
    let tree = tree();
    let subtrees = Subtrees::new(tree.view(), Cut::Depth(5));
    let mut workers = [0; 2].map(|_| Worker::new(&subtrees));
    let names = workers.each_mut().map(Worker::serve);
    let count = subtrees.count();
    for root in 0..count {
        workers[root as usize % 2].add(&subtrees.message(root).unwrap());
    }
    std::thread::scope(|scope| {
        for (number, worker) in (0..).zip(&mut workers) {
            let missing = (0..count).filter(move |root| root % 2 != number);
            let peer = names[1 - number as usize];
            scope.spawn(move || {
                missing.for_each(|root| assert!(worker.fetch(root, peer, LONG), "{root}"));
            });
        }
    });
    assert!(workers.iter().all(|worker| (0..count).all(|root| worker.holds(root))));
}

#[test]
fn what_is_not_there_or_not_any_more_does_not_come_and_nobody_waits() {
    let tree = tree();
    let subtrees = Subtrees::new(tree.view(), Cut::Depth(3));
    let [mut one, mut other] = [0; 2].map(|_| Worker::new(&subtrees));
    let name = one.serve();
    assert!(!other.fetch(1, name, LONG), "it does not have it");
    one.add(&subtrees.message(1).unwrap());
    assert!(!other.fetch(1, name, LONG), "it has failed before");
    let mut third = Worker::new(&subtrees);
    assert!(third.fetch(1, name, LONG));
    TreeStore::<Nobody>::remove(&mut one.0, TREE).unwrap();
    assert!(!Worker::new(&subtrees).fetch(1, name, LONG), "the tree was removed");
    drop(one);
    assert!(!Worker::new(&subtrees).fetch(1, name, LONG), "nobody is there");
    assert!(!third.holds(2));
}

/// Something else than a worker, that does this with whom it is asked by.
fn stranger(act: impl Fn(UnixStream) + Send + 'static) -> PeerName {
    let listener = PeerListener::open().unwrap();
    let name = listener.name();
    std::thread::spawn(move || {
        loop {
            if let Some(mut stream) = listener.accept().unwrap() {
                stream.set_nonblocking(false).unwrap();
                stream.read_exact(&mut [0; SubtreeRequest::BYTES]).unwrap();
                return act(stream);
            }
            std::thread::yield_now();
        }
    });
    name
}

#[test]
fn what_a_hostile_worker_answers_is_refused_and_changes_nothing() {
    let tree = tree();
    let subtrees = Subtrees::new(tree.view(), Cut::Depth(3));
    let message = subtrees.message(1).unwrap();
    let header = |bytes: u64| SubtreeResponse { bytes }.to_bytes().to_vec();
    let with_header = |message: &[u8]| [header(message.len() as u64), message.to_vec()].concat();
    let mut damaged = message.clone();
    *damaged.last_mut().unwrap() ^= 1;
    let answers = [
        vec![0; 40],
        header(u64::MAX),
        header(1 << 40),
        header(0),
        header(message.len() as u64),
        with_header(&message)[..message.len()].to_vec(),
        with_header(&damaged),
        with_header(&message[..100]),
        with_header(&subtrees.message(2).unwrap()),
        with_header(&subtrees.outline()),
    ];
    for (number, answer) in answers.into_iter().enumerate() {
        let mut worker = Worker::new(&subtrees);
        let name = stranger(move |mut stream| stream.write_all(&answer).unwrap());
        assert!(!worker.fetch(1, name, LONG), "answer {number}");
        assert!(!worker.holds(1) && !worker.holds(2), "answer {number}");
        assert_eq!(worker.add(&message), 1, "then the master sends it");
    }
}

#[test]
fn a_worker_that_says_nothing_is_waited_for_once_and_no_longer_than_the_deadline() {
    let tree = tree();
    let subtrees = Subtrees::new(tree.view(), Cut::Depth(3));
    // As one that is stopped: with nobody who takes the connection, or in the middle of a message.
    let silent = PeerListener::open().unwrap();
    let bytes = subtrees.message(1).unwrap().len() as u64;
    let halting = stranger(move |mut stream| {
        stream.write_all(&SubtreeResponse { bytes }.to_bytes()).unwrap();
        std::thread::sleep(LONG);
    });
    for name in [silent.name(), halting] {
        let mut worker = Worker::new(&subtrees);
        assert!(!worker.fetch(1, name, SHORT));
        // For as long as the test may take, if it were tried again.
        assert!(!worker.fetch(1, name, LONG));
    }
}

#[test]
fn who_asks_wrongly_or_reads_nothing_keeps_nobody_else_waiting() {
    let tree = tree();
    let subtrees = Subtrees::new(tree.view(), Cut::Depth(0));
    let mut one = Worker::new(&subtrees);
    let name = one.serve();
    one.add(&subtrees.message(0).unwrap());
    let soon = || std::time::Instant::now() + LONG;
    let request = SubtreeRequest { tree: TREE, root: 0 }.to_bytes();
    let mut wrong = PeerStream::connect(name).unwrap();
    wrong.write_all(&[0xff; 64], soon()).unwrap();
    assert!(wrong.read_exact(&mut [0], soon()).is_err(), "it is sent away");
    // They have asked, more than a socket holds of answers, and read nothing.
    let mut greedy: Vec<_> = (0..20).map(|_| PeerStream::connect(name).unwrap()).collect();
    greedy.iter_mut().for_each(|one| one.write_all(&request.repeat(50), soon()).unwrap());
    let mut half = PeerStream::connect(name).unwrap();
    half.write_all(&request[..5], soon()).unwrap();
    assert!(Worker::new(&subtrees).fetch(0, name, LONG));
    drop((greedy, half));
    assert!(Worker::new(&subtrees).fetch(0, name, LONG));
}
