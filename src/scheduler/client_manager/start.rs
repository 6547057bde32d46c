//! An engine over any of the transports.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::{Engine, EngineError, EngineReport, MeshId, ResultSink, Work};
use crate::scene::{EngineOptions, StartFrom, Transport, WorkerCount};
use crate::scheduler::launch::{InThreads, Launch, Processes};
use crate::scheduler::ranks::{Command, Hybrid, NodeIs, OnNodes};
use crate::transport::shared_memory::{SharedMemory, default_base};
use crate::transport::stream::{Pipes, Sockets};
use crate::transport::threads::Threads;
use crate::transport::{MasterEnd, Needs, WakeUp};
use crate::tree::TreeImage;
use crate::wire::Job;

/// An [`Engine`] whose transport does not show.
pub trait AnyEngine {
    fn add_mesh(&mut self, image: Arc<TreeImage>) -> Result<MeshId, EngineError>;

    fn remove_mesh(&mut self, mesh: MeshId) -> Result<(), EngineError>;

    fn run(
        &mut self,
        work: &Work<'_>,
        sink: &mut dyn ResultSink,
        interrupt: &AtomicBool,
    ) -> Result<EngineReport, EngineError>;
}

impl<T: MasterEnd, L: Launch<T::Attach>> AnyEngine for Engine<T, L> {
    fn add_mesh(&mut self, image: Arc<TreeImage>) -> Result<MeshId, EngineError> {
        self.add_mesh(image)
    }

    fn remove_mesh(&mut self, mesh: MeshId) -> Result<(), EngineError> {
        self.remove_mesh(mesh)
    }

    fn run(
        &mut self,
        work: &Work<'_>,
        sink: &mut dyn ResultSink,
        interrupt: &AtomicBool,
    ) -> Result<EngineReport, EngineError> {
        self.run(work, sink, interrupt)
    }
}

/// Starts an engine whose worker processes, if workers are processes, are this `program`.
pub fn start(options: EngineOptions, program: PathBuf) -> Result<Box<dyn AnyEngine>, EngineError> {
    options.check()?;
    let needs = needs(&options);
    let processes = Processes { program };
    Ok(match options.transport {
        Transport::Iceoryx2 => {
            let end = SharedMemory::create(&default_base(), &needs)?;
            Box::new(Engine::start(end, processes, options)?)
        }
        Transport::Threads => {
            Box::new(Engine::start(Threads::create(&needs)?, InThreads, options)?)
        }
        Transport::Pipe => Box::new(Engine::start(Pipes::create(&needs)?, processes, options)?),
        Transport::Socket => Box::new(Engine::start(Sockets::create(&needs)?, processes, options)?),
    })
}

/// Starts an engine with a worker for each rank: where memory is to be in common, as children of the
/// leader of each machine, otherwise of each rank.
pub fn start_on_ranks(
    options: EngineOptions,
    program: PathBuf,
    command: Command,
) -> Result<Box<dyn AnyEngine>, EngineError> {
    let node = match options.transport {
        Transport::Iceoryx2 => NodeIs::Machine,
        Transport::Pipe | Transport::Socket => NodeIs::Rank,
        Transport::Threads => return Err(EngineError::ThreadsOnRanks),
    };
    let workers = Some(WorkerCount::new(command.ranks().into()).map_err(EngineError::Ranks)?);
    let start_from = match command.nodes_of(node) {
        1 => options.start_from,
        _ if options.start_from == Some(StartFrom::Top) => return Err(EngineError::TopNotShared),
        _ => Some(StartFrom::RootPairs),
    };
    let transport = Transport::Iceoryx2;
    let options = EngineOptions { workers, start_from, transport, ..options };
    let needs = Needs { wake_up: WakeUp::Block, ..needs(&options) };
    let end = Hybrid::create(&default_base(), command, node, &needs)?;
    let launcher = OnNodes { here: Processes { program } };
    Ok(Box::new(Engine::start(end, launcher, options)?))
}

/// What an engine with these options needs of a transport.
pub fn needs(options: &EngineOptions) -> Needs {
    let workers = options.worker_count().get();
    let job_bytes = match options.transport {
        Transport::Iceoryx2 | Transport::Threads => longest_batch(options),
        // Of a subtree, which may be the whole tree of any mesh.
        Transport::Pipe | Transport::Socket => usize::MAX / 2,
    };
    Needs { workers, job_bytes, wake_up: wake_up(workers) }
}

/// Longest message to a worker that sees the geometry in place. A batch with more root pairs is
/// sent without them.
pub(super) fn longest_batch(options: &EngineOptions) -> usize {
    const ROOT_PAIRS: usize = 2048;
    let scenarios = options.buffer_scenarios.get() as usize;
    let root_pairs = match options.start_from {
        Some(StartFrom::RootPairs) => ROOT_PAIRS * scenarios,
        None | Some(StartFrom::Top) => 0,
    };
    Job::batch_bytes(scenarios, root_pairs)
}

/// Looking for messages before going to sleep takes a core, which nobody else may want.
fn wake_up(workers: u32) -> WakeUp {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    if (workers as usize) < cores { WakeUp::SpinThenBlock } else { WakeUp::Block }
}
