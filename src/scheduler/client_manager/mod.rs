//! Publishes the geometry, starts the workers, spreads the scenarios, collects the results
//! (section 6.4.1 of the paper).

mod mortality;
mod session;

use std::io;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use super::collection::BadReply;
pub use super::engine_report::{EngineReport, WorkerReport};
use crate::geometry::Pose;
use crate::transport::shared_memory::{SharedMemory, default_base};
use crate::transport::{MasterEnd, Needs, TransportError, WorkerId};
use crate::tree::descent::Pair;
use crate::tree::{TreeKind, TreeView};
use crate::wire::Job;
use session::Session;

#[derive(Clone, Debug)]
pub struct EngineOptions {
    /// At most: no more are started than there are scenarios.
    pub workers: NonZeroU32,
    /// q: a local client's buffer is full with this many scenarios.
    pub buffer_scenarios: NonZeroU32,
    /// d: depth of the distributed roots of each mesh.
    pub fixed_depth: u32,
    pub moving_depth: u32,
    /// Whether results carry the pairs themselves, or only their count and hash.
    pub send_pairs: bool,
    /// The executable to start as `PROGRAM worker …`.
    pub worker_program: PathBuf,
}

impl EngineOptions {
    fn workers_for(&self, scenarios: usize) -> u32 {
        u32::try_from(scenarios).map_or(self.workers.get(), |most| self.workers.get().min(most))
    }
}

/// One answered scenario.
#[derive(Clone, Copy, Debug)]
pub struct ScenarioResult<'a> {
    pub scenario: u32,
    pub pair_count: u32,
    pub pairs_fnv1a64: u64,
    /// Time the worker computed, in nanoseconds.
    pub compute_ns: u64,
    pub worker: u32,
    /// Sorted; empty unless [`EngineOptions::send_pairs`].
    pub pairs: &'a [Pair],
}

/// Where results go, in scenario order, as they come.
pub trait ResultSink {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()>;
}

#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    #[error("the trees are of different kinds ({fixed} and {moving}): build both alike")]
    Kinds { fixed: TreeKind, moving: TreeKind },
    #[error("{0} scenarios are too many: at most {max}", max = u32::MAX)]
    TooManyScenarios(usize),
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error("cannot start a worker as {program}: {source}", program = program.display())]
    StartWorker { program: PathBuf, source: io::Error },
    #[error("cannot watch worker {worker}: {source}")]
    WatchWorker { worker: WorkerId, source: io::Error },
    #[error(
        "scenario {scenario}: triangle {triangle} of the moving mesh leaves the range of 64-bit \
         numbers in this pose; all scenarios before it are answered"
    )]
    Overflow { scenario: u32, triangle: u32 },
    #[error("worker {worker} sent a reply that cannot be right: {source}")]
    BadReply { worker: WorkerId, source: BadReply },
    #[error("no worker is left, {completed} scenarios are answered; the last to go, {last}")]
    AllWorkersDied { completed: u32, last: String },
    #[error("cannot write a result: {0}")]
    Sink(#[source] io::Error),
}

/// What is to be answered.
#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    pub fixed: TreeView<'a>,
    pub moving: TreeView<'a>,
    pub poses: &'a [Pose],
}

/// Answers every pose, or says why not, over shared memory. When `interrupt` becomes true, stops
/// the workers, delivers what is already answered without a gap, and reports `interrupted`.
pub fn run(
    fixed: TreeView<'_>,
    moving: TreeView<'_>,
    poses: &[Pose],
    options: &EngineOptions,
    sink: &mut dyn ResultSink,
    interrupt: &AtomicBool,
) -> Result<EngineReport, EngineError> {
    let work = Work { fixed, moving, poses };
    let transport = SharedMemory::create(&default_base(), &needs(&work, options))?;
    run_over(transport, work, options, sink, interrupt)
}

/// What a transport for this run has to provide.
pub fn needs(work: &Work<'_>, options: &EngineOptions) -> Needs {
    let images = [work.fixed, work.moving].map(|tree| size_of_val(tree.blocks())).to_vec();
    let job_bytes = Job::batch_bytes(options.buffer_scenarios.get());
    Needs { images, workers: options.workers_for(work.poses.len()), job_bytes }
}

/// As [`run`], over any transport made for these [`needs`].
pub fn run_over<T: MasterEnd>(
    transport: T,
    work: Work<'_>,
    options: &EngineOptions,
    sink: &mut dyn ResultSink,
    interrupt: &AtomicBool,
) -> Result<EngineReport, EngineError> {
    let (fixed, moving) = (work.fixed.kind(), work.moving.kind());
    if fixed != moving {
        return Err(EngineError::Kinds { fixed, moving });
    }
    let mut session = Session::new(transport, work, options)?;
    if work.poses.is_empty() {
        return Ok(session.into_report(false));
    }
    session.start_workers()?;
    session.publish()?;
    let interrupted = session.serve(sink, interrupt)?;
    session.end_workers(sink)?;
    Ok(session.into_report(interrupted))
}
