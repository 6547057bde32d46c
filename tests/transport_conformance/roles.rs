//! What the worker's side does in a promise.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bumper::transport::{GeometryInPlace, REPLY_BYTES, TransportError, WakeUp, WorkerEnd};

/// Only waits that have failed take so long.
pub const FOREVER: Duration = Duration::from_secs(60);
pub const JOB_BYTES: usize = 1000;

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Greets, then returns every message, until it gets an empty one.
    Echo,
    /// Greets, then returns a digest of every message, until it gets an empty one.
    Digest,
    /// Sends 500 numbers.
    Flood,
    /// Greets, receives nothing until the gate opens, then returns every message.
    EchoBehindGate,
    /// Greets, and receives nothing before it ends when the gate opens.
    Deaf,
    /// Sends too much at once, then as much as is possible; then receives and says how much.
    TooMuch,
    /// Says something, and then nothing more.
    LastWords,
    /// Greets, and receives until the master has gone.
    Orphan,
    /// Sends until the master has gone.
    SendingOrphan,
    /// Returns a digest of meshes 0 and 1 as soon as it has them.
    Geometry,
    /// Has mesh 0, says so, and looks at it again behind the gate.
    GeometryBehindGate,
    /// Has mesh 0, says so, and no longer has it after the next message.
    GeometryForAWhile,
    /// Waits for a mesh that never comes.
    GeometryOrphan,
}

const ROLES: [Role; 13] = [
    Role::Deaf,
    Role::Echo,
    Role::Digest,
    Role::Flood,
    Role::EchoBehindGate,
    Role::TooMuch,
    Role::LastWords,
    Role::Orphan,
    Role::SendingOrphan,
    Role::Geometry,
    Role::GeometryBehindGate,
    Role::GeometryForAWhile,
    Role::GeometryOrphan,
];

impl Role {
    pub fn named(name: &str) -> Self {
        ROLES.into_iter().find(|role| format!("{role:?}") == name).expect("a role of that name")
    }
}

/// A file that opens by being made.
#[derive(Clone, Debug)]
pub struct Gate(pub PathBuf);

impl Gate {
    pub fn at(directory: &Path) -> Self {
        Self(directory.join("gate"))
    }

    pub fn open(&self) {
        std::fs::write(&self.0, "").unwrap();
    }

    fn wait(&self) {
        let begin = Instant::now();
        while !self.0.exists() {
            assert!(begin.elapsed() < FOREVER, "the gate never opened");
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

pub fn digest(bytes: &[u8]) -> [u8; 8] {
    let mut hasher = DefaultHasher::new();
    bytes.hash(&mut hasher);
    hasher.finish().to_ne_bytes()
}

pub fn needs(wake_up: WakeUp) -> bumper::transport::Needs {
    bumper::transport::Needs { workers: 3, job_bytes: JOB_BYTES, wake_up }
}

pub fn play<W: WorkerEnd>(role: Role, gate: &Gate, mut worker: W) {
    match role {
        Role::Echo => echo(&mut worker, |message| message.to_vec()),
        Role::Digest => echo(&mut worker, |message| digest(message).to_vec()),
        Role::Flood => {
            for number in 0..500_u32 {
                worker.send(&[&number.to_ne_bytes()]).unwrap();
            }
        }
        Role::EchoBehindGate => {
            worker.send(&[b"hello"]).unwrap();
            gate.wait();
            answer(&mut worker, |message| message.to_vec());
        }
        Role::Deaf => {
            worker.send(&[b"hello"]).unwrap();
            gate.wait();
        }
        Role::TooMuch => {
            let longest = vec![7; REPLY_BYTES];
            let refused = worker.send(&[&longest, b"!"]);
            assert!(matches!(refused, Err(TransportError::TooLong { limit: REPLY_BYTES, .. })));
            worker.send(&[&longest]).unwrap();
            let length = worker.receive().unwrap().len();
            worker.send(&[&length.to_ne_bytes()]).unwrap();
        }
        Role::LastWords => {
            for word in [&b"last"[..], b"words"] {
                worker.send(&[word]).unwrap();
            }
            gate.open();
            // As after a kill, nothing of the worker's end is taken down.
            std::mem::forget(worker);
        }
        Role::Orphan => {
            worker.send(&[b"hello"]).unwrap();
            assert!(matches!(worker.receive(), Err(TransportError::MasterGone)));
        }
        Role::SendingOrphan => {
            let refused = loop {
                if let Err(refused) = worker.send(&[&[1; REPLY_BYTES]]) {
                    break refused;
                }
            };
            assert!(matches!(refused, TransportError::MasterGone), "{refused}");
        }
        _ => unreachable!("{role:?} has geometry in place"),
    }
}

fn echo<W: WorkerEnd>(worker: &mut W, to: impl Fn(&[u8]) -> Vec<u8>) {
    worker.send(&[b"hello"]).unwrap();
    answer(worker, to);
}

fn answer<W: WorkerEnd>(worker: &mut W, to: impl Fn(&[u8]) -> Vec<u8>) {
    loop {
        let message = worker.receive().unwrap();
        assert_eq!(message.as_ptr().addr() % 8, 0);
        if message.is_empty() {
            return;
        }
        worker.send(&[&to(&message)]).unwrap();
    }
}

pub fn play_in_place<W: GeometryInPlace>(role: Role, gate: &Gate, mut worker: W) {
    match role {
        Role::Geometry => {
            for mesh in 0..2 {
                let seen = worker.geometry(mesh).unwrap();
                assert_eq!(seen.as_ptr().addr() % 64, 0);
                worker.send(&[&digest(&seen)]).unwrap();
            }
        }
        Role::GeometryBehindGate => {
            let seen = worker.geometry(0).unwrap();
            let before = digest(&seen);
            worker.send(&[&before]).unwrap();
            gate.wait();
            assert_eq!(digest(&seen), before);
        }
        Role::GeometryForAWhile => {
            let seen = worker.geometry(0).unwrap();
            worker.send(&[b"have it"]).unwrap();
            worker.receive().unwrap();
            worker.send(&[&digest(&seen)]).unwrap();
            drop(seen);
            worker.send(&[b"had it"]).unwrap();
            worker.receive().unwrap();
        }
        Role::GeometryOrphan => {
            worker.send(&[b"hello"]).unwrap();
            assert!(matches!(worker.geometry(0), Err(TransportError::MasterGone)));
        }
        _ => play(role, gate, worker),
    }
}
