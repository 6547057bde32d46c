//! What the suite has to know of each transport.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use bumper::transport::shared_memory::SharedMemory;
use bumper::transport::stream::{Pipes, Sockets};
use bumper::transport::threads::{ThreadWorker, Threads};
use bumper::transport::{Attach, Attached, MasterEnd, Needs, QUEUED_JOBS, TransportError, attach};

pub use crate::over_ranks::OverRanks;
use crate::roles::{Gate, Role, play, play_in_place};

pub trait Transport {
    type Master: MasterEnd;
    /// Messages that can be ahead of a worker, if that is limited.
    const AHEAD: Option<usize>;

    fn master(base: &Path, needs: &Needs) -> Result<Self::Master, TransportError>;

    fn start(role: Role, gate: &Gate, end: <Self::Master as MasterEnd>::Attach) -> Running;
}

pub struct OverThreads;
pub struct OverSharedMemory;
pub struct OverPipes;
pub struct OverSockets;

impl Transport for OverThreads {
    type Master = Threads;
    const AHEAD: Option<usize> = None;

    fn master(_: &Path, needs: &Needs) -> Result<Threads, TransportError> {
        Threads::create(needs)
    }

    fn start(role: Role, gate: &Gate, end: ThreadWorker) -> Running {
        let gate = gate.clone();
        Running::Thread(Some(std::thread::spawn(move || play_in_place(role, &gate, end))))
    }
}

impl Transport for OverSharedMemory {
    type Master = SharedMemory;
    const AHEAD: Option<usize> = Some(QUEUED_JOBS);

    fn master(base: &Path, needs: &Needs) -> Result<SharedMemory, TransportError> {
        SharedMemory::create(base, needs)
    }

    fn start(role: Role, gate: &Gate, end: Attach) -> Running {
        Running::process(role, gate, end)
    }
}

impl Transport for OverPipes {
    type Master = Pipes;
    const AHEAD: Option<usize> = None;

    fn master(_: &Path, needs: &Needs) -> Result<Pipes, TransportError> {
        Pipes::create(needs)
    }

    fn start(role: Role, gate: &Gate, end: Attach) -> Running {
        Running::process(role, gate, end)
    }
}

impl Transport for OverSockets {
    type Master = Sockets;
    const AHEAD: Option<usize> = None;

    fn master(_: &Path, needs: &Needs) -> Result<Sockets, TransportError> {
        Sockets::create(needs)
    }

    fn start(role: Role, gate: &Gate, end: Attach) -> Running {
        Running::process(role, gate, end)
    }
}

/// A worker at work.
pub enum Running {
    Process(Child),
    /// The leader of its node has it too.
    Shared(Arc<Mutex<Child>>),
    Thread(Option<JoinHandle<()>>),
}

const ROLE: &str = "BUMPER_TEST_ROLE";
const GATE: &str = "BUMPER_TEST_GATE";
const ATTACH: &str = "BUMPER_TEST_ATTACH";
const SEPARATOR: &str = "\u{1f}";

impl Running {
    fn process(role: Role, gate: &Gate, end: Attach) -> Self {
        Self::Process(Self::child(role, gate, end))
    }

    /// This test program once more, in which only `worker_process` runs.
    pub fn child(role: Role, gate: &Gate, end: Attach) -> Child {
        let child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "worker_process", "--nocapture", "--test-threads=1"])
            .env(ROLE, format!("{role:?}"))
            .env(GATE, &gate.0)
            .env(ATTACH, end.arguments.join(SEPARATOR.as_ref()))
            .stdout(std::process::Stdio::null())
            .spawn();
        drop(end.inherited);
        child.unwrap()
    }

    /// Waits until it has done all of its role, without a failure.
    pub fn finish(mut self) {
        match &mut self {
            Self::Process(child) => assert!(child.wait().unwrap().success(), "the worker failed"),
            Self::Shared(child) => assert!(ended(child).success(), "the worker failed"),
            Self::Thread(thread) => thread.take().expect("finished once").join().unwrap(),
        }
    }

    /// With SIGKILL. A thread cannot be killed; its role ends as if it had been.
    pub fn kill(mut self) {
        match &mut self {
            Self::Process(child) => {
                child.kill().unwrap();
                child.wait().unwrap();
            }
            Self::Shared(child) => {
                child.lock().unwrap().kill().unwrap();
                ended(child);
            }
            Self::Thread(_) => self.finish(),
        }
    }

    pub fn pid(&self) -> Option<u32> {
        match self {
            Self::Process(child) => Some(child.id()),
            Self::Shared(child) => Some(child.lock().unwrap().id()),
            Self::Thread(_) => None,
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // They fail for one that was waited for.
        match self {
            Self::Process(child) => {
                let _ = child.kill();
                let _ = child.wait();
            }
            Self::Shared(child) => {
                let _ = child.lock().unwrap().kill();
            }
            Self::Thread(_) => {}
        }
    }
}

/// Lets its leader look in between.
fn ended(child: &Mutex<Child>) -> ExitStatus {
    let begin = Instant::now();
    loop {
        if let Some(status) = child.lock().unwrap().try_wait().unwrap() {
            return status;
        }
        assert!(begin.elapsed() < crate::roles::FOREVER, "the worker goes on");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// What a started copy of this test program does.
pub fn play_as_process() {
    let Ok(role) = std::env::var(ROLE) else { return };
    let role = Role::named(&role);
    let gate = Gate(std::env::var(GATE).unwrap().into());
    let arguments = std::env::var(ATTACH).unwrap();
    let arguments: Vec<_> = arguments.split(SEPARATOR).map(OsString::from).collect();
    match attach(&arguments).unwrap() {
        Attached::SharedMemory(end) | Attached::Node(end) => play_in_place(role, &gate, end),
        Attached::Stream(end) => play(role, &gate, end),
    }
    if role == Role::LastWords {
        std::thread::sleep(crate::roles::FOREVER);
        panic!("nobody has killed this worker");
    }
}
