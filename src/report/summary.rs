//! `summary.json`: what was asked, what came out, and what it cost.

use serde::Serialize;

use super::{ComputeTimes, EffectSummary, Machine, Tally, TreeCosts};
use crate::effects::Plan;
use crate::geometry::Point;
use crate::geometry::simd::SimdLevel;
use crate::mesh::TriangleMesh;
use crate::scene::{Body, MatchRule, Scenarios, Scene, Slowdown, StartFrom};
use crate::scheduler::client_manager::{EngineReport, NodeReport, TransferReport, WorkerReport};
use crate::tree::cache::CacheOutcome;
use crate::tree::roots::Cut;
use crate::tree::{Accuracy, FORMAT_VERSION, TreeImage, TreeKind};

#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    pub schema_version: u32,
    pub versions: Versions,
    /// Whether Ctrl-C ended the run before all scenarios were answered.
    pub interrupted: bool,
    /// What is a pair: all counts below are of such.
    pub accuracy: Accuracy,
    /// Answered scenarios.
    pub scenarios: u32,
    pub scenarios_asked: usize,
    /// Those of them that an earlier run had answered, of which there are no times here.
    #[serde(skip_serializing_if = "is_zero")]
    pub answered_before: u32,
    /// Scenarios with at least one pair.
    pub colliding: u32,
    /// Pairs of triangles that touch, over all scenarios; with `boxes(D)`, pairs of boxes.
    pub pairs: u64,
    /// Scenarios that have no answer, because every worker that was at them died.
    pub set_aside: Vec<u32>,
    pub workers: usize,
    pub transport: &'static str,
    pub matchmaker: MatchRule,
    /// Where workers started each scenario.
    pub start_from: StartFrom,
    /// Instruction set of the kernel.
    pub simd: SimdLevel,
    /// Bytes of geometry copied once, for all workers together.
    pub bytes_published: u64,
    /// Bytes of geometry that the master copied into or for single workers, over all of them.
    pub bytes_copied: u64,
    /// `bytes_copied` over the bytes of both trees (section 7.2 of the paper).
    pub relative_data_transfer: f64,
    /// All zero where nothing is sent.
    pub transfer: TransferReport,
    /// Over `time.scenarios_s`.
    pub scenarios_per_s: f64,
    pub time: Times,
    pub compute_us: ComputeTimes,
    /// What was asked beside the pairs, as it went to the workers.
    #[serde(skip_serializing_if = "Plan::is_empty")]
    pub plan: Plan,
    /// The steps of the plan, in their order.
    pub effects: Vec<EffectSummary>,
    /// With `--stats`: the tree kind of the scene, then the others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tree_costs: Vec<TreeCosts>,
    pub worker_reports: Vec<WorkerReport>,
    /// Of a run on several machines; the first is the master's.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<NodeReport>,
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

impl Versions {
    pub fn this() -> Self {
        Self { bumper: env!("CARGO_PKG_VERSION"), tree_image: FORMAT_VERSION }
    }
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
    /// From when trees and poses are there to the first result.
    pub first_result_s: f64,
    /// First batch sent to last result received.
    pub scenarios_s: f64,
    /// Within `scenarios_s`, in the master: finding the pairs of subtrees that meet.
    pub pre_analysis_s: f64,
    /// Within `scenarios_s`, in the master: choosing a worker for each scenario.
    pub matching_s: f64,
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
    pub buffer_kilobytes: Option<u64>,
    /// Of the workers, from the first.
    pub slowdowns: Vec<Slowdown>,
}

#[derive(Clone, Debug, Serialize)]
pub struct BodySummary {
    pub mesh: String,
    #[serde(skip_serializing_if = "is_origin")]
    pub offset_m: Point,
    /// Of [`Cut::Depth`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<u32>,
    /// Of [`Cut::Triangles`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub subtree_triangles: Option<u32>,
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
            versions: Versions::this(),
            interrupted: engine.interrupted,
            accuracy: scene.accuracy,
            scenarios: tally.earlier() + engine.completed,
            scenarios_asked,
            answered_before: tally.earlier(),
            colliding: tally.colliding,
            pairs: tally.pairs,
            set_aside: engine.set_aside,
            workers: engine.workers.len(),
            transport: engine.transport,
            matchmaker: engine.matchmaker,
            start_from: engine.start_from,
            simd: SimdLevel::chosen(),
            bytes_published: engine.bytes_published,
            bytes_copied: engine.bytes_sent,
            relative_data_transfer: engine.relative_data_transfer,
            transfer: engine.transfer,
            scenarios_per_s: rate(engine.completed, engine.scenarios_s),
            time: Times {
                publish_s: engine.publish_s,
                start_workers_s: engine.start_workers_s,
                first_result_s: engine.first_result_s,
                scenarios_s: engine.scenarios_s,
                pre_analysis_s: engine.pre_analysis_s,
                matching_s: engine.matching_s,
                ..prepared
            },
            compute_us: tally.compute_times(),
            plan: Plan::default(),
            effects: tally.effects(scene.effects.pairs.name()),
            tree_costs: Vec::new(),
            worker_reports: engine.workers,
            nodes: engine.nodes,
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
            buffer_kilobytes: scene.engine.buffer_kilobytes.map(|v| v.get()),
            slowdowns: scene.engine.slowdowns.clone(),
        }
    }
}

impl From<&Body> for BodySummary {
    fn from(body: &Body) -> Self {
        let (depth, subtree_triangles) = match body.distribution.cut() {
            Cut::Depth(depth) => (Some(depth), None),
            Cut::Triangles(most) => (None, Some(most)),
        };
        Self { mesh: body.mesh.to_string(), offset_m: body.offset, depth, subtree_triangles }
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

fn is_zero(count: &u32) -> bool {
    *count == 0
}

fn is_origin(offset: &Point) -> bool {
    *offset == [0.0; 3]
}

fn rate(count: u32, seconds: f64) -> f64 {
    if seconds > 0.0 { f64::from(count) / seconds } else { 0.0 }
}
