//! Starts the workers, gets the geometry to them, spreads the scenarios, collects the results
//! (section 6.4.1 of the paper).

mod crew;
mod engine;
mod planned;
mod session;
mod start;
mod supply;

use std::io;

use super::collection::BadReply;
pub use super::engine_report::{EngineReport, NodeReport, TransferReport, WorkerReport};
use crate::effects::Plan;
use crate::effects::layout::Sayings;
use crate::geometry::Pose;
use crate::scene::{NothingSent, OutOfRange};
use crate::transport::{TransportError, WorkerId};
use crate::tree::descent::Pair;
use crate::tree::roots::Cut;
use crate::tree::{Accuracy, TreeKind};
use crate::wire::{CostRecord, Wanted};
pub use engine::{Engine, MeshId};
pub use start::{AnyEngine, needs, start, start_on_ranks};

/// What is to be answered.
#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    pub fixed: (MeshId, Cut),
    pub moving: (MeshId, Cut),
    pub poses: &'a [Pose],
    pub wanted: Wanted,
    /// Absent: pairs are all that is asked for.
    pub effects: Option<EffectsWork<'a>>,
}

/// Effects that are asked for, and meshes that they need beside the fixed and the moving one.
#[derive(Clone, Copy, Debug)]
pub struct EffectsWork<'a> {
    pub plan: &'a Plan,
    pub parts: &'a [MeshId],
}

/// One answered scenario.
#[derive(Clone, Copy, Debug)]
pub struct ScenarioResult<'a> {
    pub scenario: u32,
    pub pair_count: u32,
    pub pairs_fnv1a64: u64,
    /// Time the worker computed, in nanoseconds.
    pub compute_ns: u64,
    /// With [`Wanted::costs`].
    pub cost: Option<CostRecord>,
    pub worker: u32,
    /// Sorted, as many as [`Wanted::pairs`].
    pub pairs: &'a [Pair],
    /// What the effects of the plan say.
    pub effects: Sayings<'a>,
}

/// Where results go, in scenario order, as they come.
pub trait ResultSink {
    fn accept(&mut self, result: ScenarioResult<'_>) -> io::Result<()>;

    /// Every worker that was at this scenario has died: there will be no result.
    fn set_aside(&mut self, scenario: u32) -> io::Result<()>;
}

#[derive(Debug, thiserror::Error)]
pub enum EngineError {
    #[error("the trees are of different kinds ({fixed} and {moving}): build both alike")]
    Kinds { fixed: TreeKind, moving: TreeKind },
    #[error("there is no mesh {0} in this engine")]
    NoMesh(MeshId),
    #[error("accuracy {accuracy} is of boxes at a depth at which the trees are not cut")]
    BoxesElsewhere { accuracy: Accuracy },
    #[error("{0} scenarios are too many: at most {max}", max = u32::MAX)]
    TooManyScenarios(usize),
    #[error("workers see the trees from the top only where they share memory with the master")]
    TopNotShared,
    #[error(
        "transport threads is of one process: over several ranks take iceoryx2 (a copy of the trees a \
         machine), or pipe or socket (one a rank)"
    )]
    ThreadsOnRanks,
    #[error("a worker for each rank: {0}")]
    Ranks(OutOfRange),
    #[error(transparent)]
    NothingSent(#[from] NothingSent),
    #[error("the engine has stopped in the middle of a run: start another")]
    Stopped,
    #[error(transparent)]
    Transport(#[from] TransportError),
    #[error(transparent)]
    StartWorker(io::Error),
    #[error("cannot watch worker {worker}: {source}")]
    WatchWorker { worker: WorkerId, source: io::Error },
    #[error(
        "scenario {scenario}: corner {corner} of triangle {triangle} of the moving mesh leaves the \
         range of 64-bit numbers in this pose; all scenarios before it are answered"
    )]
    Overflow { scenario: u32, triangle: u32, corner: u32 },
    #[error("worker {worker} sent a reply that cannot be right: {source}")]
    BadReply { worker: WorkerId, source: BadReply },
    #[error("no worker is left, {completed} scenarios are answered; the last to go, {last}")]
    AllWorkersDied { completed: u32, last: String },
    #[error("cannot write a result: {0}")]
    Sink(#[source] io::Error),
}
