//! `summary.json`: what was asked, what came out, and what it cost.

use serde::Serialize;

use super::{ComputeTimes, Machine, Tally};
use crate::geometry::simd::SimdLevel;
use crate::mesh::TriangleMesh;
use crate::scene::{Body, Scenarios, Scene};
use crate::scheduler::client_manager::{EngineReport, WorkerReport};
use crate::tree::cache::CacheOutcome;
use crate::tree::{FORMAT_VERSION, TreeImage, TreeKind};

#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub schema_version: u32,
    pub versions: Versions,
    /// Whether Ctrl-C ended the run before all scenarios were answered.
    pub interrupted: bool,
    /// Answered scenarios.
    pub scenarios: u32,
    pub scenarios_asked: usize,
    /// Scenarios with at least one pair.
    pub colliding: u32,
    /// Pairs of triangles that touch, over all scenarios.
    pub pairs: u64,
    pub workers: usize,
    pub transport: &'static str,
    /// Instruction set of the kernel.
    pub simd: SimdLevel,
    /// Bytes of geometry copied once, for all workers together.
    pub bytes_published: u64,
    /// Bytes of geometry copied into or for single workers, over all of them.
    pub bytes_copied: u64,
    /// Over `time.scenarios_s`.
    pub scenarios_per_s: f64,
    pub time: Times,
    pub compute_us: ComputeTimes,
    pub worker_reports: Vec<WorkerReport>,
    pub scene: SceneSummary,
    pub fixed: MeshSummary,
    pub moving: MeshSummary,
    pub machine: Machine,
}

/// What the figures and files were made by.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Versions {
    pub bumper: &'static str,
    /// Format of the trees that are cached and published.
    pub tree_image: u32,
}

/// Wall-clock times in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Times {
    /// Reading or making both meshes.
    pub load_s: f64,
    /// Building both trees, or reading them from the cache.
    pub build_s: f64,
    /// Reading or making the poses.
    pub poses_s: f64,
    pub publish_s: f64,
    pub start_workers_s: f64,
    /// First batch sent to last result received.
    pub scenarios_s: f64,
    /// Within `scenarios_s`: finding the pairs of subtrees that meet.
    pub pre_analysis_s: f64,
    /// The whole command.
    pub wall_s: f64,
}

/// The validated scene, flags included.
#[derive(Clone, Debug, Serialize)]
pub struct SceneSummary {
    pub fixed: BodySummary,
    pub moving: BodySummary,
    pub tree: TreeKind,
    pub scenarios: ScenariosSummary,
    pub buffer_scenarios: u32,
}

#[derive(Clone, Debug, Serialize)]
pub struct BodySummary {
    pub mesh: String,
    pub depth: u32,
}

#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ScenariosSummary {
    Random { count: u32, seed: u64, penetration: [f64; 2] },
    Poses { file: String, first: Option<u32> },
}

/// One of the two meshes and its tree.
#[derive(Clone, Debug, Serialize)]
pub struct MeshSummary {
    pub vertices: usize,
    pub triangles: usize,
    pub tree_bytes: usize,
    pub cache: CacheOutcome,
}

impl Summary {
    /// Raised when a field goes or changes its meaning; a new field does not raise it.
    const SCHEMA_VERSION: u32 = 1;

    pub fn new(
        scene: &Scene,
        [fixed, moving]: [MeshSummary; 2],
        scenarios_asked: usize,
        engine: EngineReport,
        tally: &Tally,
        prepared: Times,
    ) -> Self {
        Self {
            schema_version: Self::SCHEMA_VERSION,
            versions: Versions { bumper: env!("CARGO_PKG_VERSION"), tree_image: FORMAT_VERSION },
            interrupted: engine.interrupted,
            scenarios: engine.completed,
            scenarios_asked,
            colliding: tally.colliding,
            pairs: tally.pairs,
            workers: engine.workers.len(),
            transport: engine.transport,
            simd: SimdLevel::chosen(),
            bytes_published: engine.bytes_published,
            bytes_copied: engine.workers.iter().map(|w| w.geometry_bytes_copied).sum(),
            scenarios_per_s: rate(engine.completed, engine.scenarios_s),
            time: Times {
                publish_s: engine.publish_s,
                start_workers_s: engine.start_workers_s,
                scenarios_s: engine.scenarios_s,
                pre_analysis_s: engine.pre_analysis_s,
                ..prepared
            },
            compute_us: tally.compute_times(),
            worker_reports: engine.workers,
            scene: scene.into(),
            fixed,
            moving,
            machine: Machine::this(),
        }
    }

    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("string keys and plain values")
    }
}

impl MeshSummary {
    pub fn new(mesh: &TriangleMesh, tree: &TreeImage, cache: CacheOutcome) -> Self {
        Self {
            vertices: mesh.vertices().len(),
            triangles: mesh.faces().len(),
            tree_bytes: size_of_val(tree.blocks()),
            cache,
        }
    }
}

impl From<&Scene> for SceneSummary {
    fn from(scene: &Scene) -> Self {
        Self {
            fixed: (&scene.fixed).into(),
            moving: (&scene.moving).into(),
            tree: scene.tree,
            scenarios: (&scene.scenarios).into(),
            buffer_scenarios: scene.engine.buffer_scenarios.get(),
        }
    }
}

impl From<&Body> for BodySummary {
    fn from(body: &Body) -> Self {
        Self { mesh: body.mesh.to_string(), depth: body.depth.get() }
    }
}

impl From<&Scenarios> for ScenariosSummary {
    fn from(scenarios: &Scenarios) -> Self {
        match scenarios {
            Scenarios::Random(random) => Self::Random {
                count: random.count.get(),
                seed: random.seed,
                penetration: [random.penetration.min(), random.penetration.max()],
            },
            Scenarios::Poses { file, first } => {
                Self::Poses { file: file.display().to_string(), first: first.map(|n| n.get()) }
            }
        }
    }
}

fn rate(count: u32, seconds: f64) -> f64 {
    if seconds > 0.0 { f64::from(count) / seconds } else { 0.0 }
}
