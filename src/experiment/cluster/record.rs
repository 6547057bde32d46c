//! Runs a scene on this thread and takes down what everything costs.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use xxhash_rust::xxh3::xxh3_64;

use super::recording::{
    CutRecording, RECORDING_VERSION, Recording, ScenarioColumns, Subject, SubtreeColumns,
};
use crate::effects::contacts::{pairs_fnv1a64, sort};
use crate::geometry::Pose;
use crate::geometry::simd::SimdLevel;
use crate::mesh::TriangleMesh;
use crate::report::{CostFit, Machine};
use crate::scheduler::indicator::{ClientIndicator, TreeIndicator};
use crate::scheduler::jobs_submitter::JobsSubmitter;
use crate::tree::descent::{Descent, DescentError, Pair};
use crate::tree::roots::{Cut, CutTree, PreAnalysis, box_tests};
use crate::tree::subtree::{PartialTree, SubtreeError, Subtrees, compressed};
use crate::tree::{TreeImage, TreeKind, TreeView};
use crate::wire::CostRecord;
use crate::workers::clock::thread_ns;

/// Each scenario is timed so often; the fastest counts: what disturbs only slows.
const ROUNDS: usize = 2;
/// Scenarios whose tests are counted, to fit the cost of one.
const COUNTED: usize = 200;

#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    #[error("scenario {scenario}: {source}")]
    Scenario { scenario: usize, source: DescentError },
    #[error(transparent)]
    Subtree(#[from] SubtreeError),
    #[error("there is no scenario to record")]
    Nothing,
    #[error("interrupted")]
    Interrupted,
}

/// What is recorded.
pub struct Scene<'a> {
    pub subject: Subject,
    pub fixed: Arc<TreeImage>,
    pub moving: Arc<TreeImage>,
    pub poses: &'a [Pose],
}

impl Subject {
    pub fn of(meshes: [&TriangleMesh; 2], poses: &[Pose], tree: TreeKind) -> Self {
        Self {
            meshes: meshes.map(|mesh| format!("{:016x}", mesh.content_hash())),
            poses: format!("{:016x}", xxh3_64(bytemuck::cast_slice(poses))),
            tree,
            simd: SimdLevel::chosen().to_string(),
            bumper: env!("CARGO_PKG_VERSION").to_owned(),
            checks_itself: cfg!(debug_assertions),
        }
    }
}

/// Runs the scene serially, then from the pairs of roots of each cut. `progress` is told of each
/// scenario, `1 + cuts.len()` times in all.
pub fn record(
    scene: &Scene<'_>,
    cuts: &[[u32; 2]],
    progress: &dyn Fn(),
    interrupt: &AtomicBool,
) -> Result<Recording, RecordError> {
    if scene.poses.is_empty() {
        return Err(RecordError::Nothing);
    }
    let recorder = Recorder { scene, progress, interrupt };
    let serial_ns = recorder.serial()?;
    let cuts: Vec<_> = cuts.iter().map(|&depths| recorder.cut(depths)).collect::<Result<_, _>>()?;
    Ok(Recording {
        schema_version: RECORDING_VERSION,
        subject: scene.subject.clone(),
        processor: Machine::this().cpu.unwrap_or_default(),
        tree_bytes: [&scene.fixed, &scene.moving].map(|i| size_of_val(i.blocks()) as u64),
        box_test_ns: recorder.box_test_ns()?,
        score_root_ns: score_root_ns(),
        serial_ns,
        cuts,
    })
}

struct Recorder<'a> {
    scene: &'a Scene<'a>,
    progress: &'a dyn Fn(),
    interrupt: &'a AtomicBool,
}

impl Recorder<'_> {
    fn trees(&self) -> [TreeView<'_>; 2] {
        [self.scene.fixed.view(), self.scene.moving.view()]
    }

    /// Does something for each pose, in order.
    fn each(
        &self,
        mut one: impl FnMut(&Pose) -> Result<(), DescentError>,
    ) -> Result<(), RecordError> {
        for (scenario, pose) in self.scene.poses.iter().enumerate() {
            if self.interrupt.load(Ordering::Relaxed) {
                return Err(RecordError::Interrupted);
            }
            one(pose).map_err(|source| RecordError::Scenario { scenario, source })?;
            (self.progress)();
        }
        Ok(())
    }

    fn serial(&self) -> Result<Vec<u64>, RecordError> {
        let [fixed, moving] = self.trees();
        let (mut descent, mut pairs, mut times) = (Descent::default(), Vec::new(), Vec::new());
        self.each(|pose| {
            times.push(fastest(&mut pairs, |pairs| {
                descent.all_pairs(&fixed, &moving, pose, pairs)
            })?);
            Ok(())
        })?;
        Ok(times)
    }

    fn cut(&self, depths: [u32; 2]) -> Result<CutRecording, RecordError> {
        let trees = self.trees();
        let cuts = depths.map(Cut::Depth);
        let analysis = PreAnalysis::new(trees[0], cuts[0], trees[1], cuts[1]);
        let mut submitter = JobsSubmitter::new(analysis);
        let cut_trees = [0, 1].map(|tree: usize| CutTree::new(trees[tree], cuts[tree]));
        let (mut descent, mut pairs) = (Descent::default(), Vec::new());
        let mut columns = ScenarioColumns::default();
        self.each(|pose| {
            submitter.analyse(pose, true)?;
            let begin = thread_ns();
            let found = submitter.analyse(pose, true)?;
            columns.analysis_ns.push(thread_ns() - begin);
            let [fixed, moving] = &cut_trees;
            columns.box_tests.push(box_tests(fixed, moving, pose).unwrap_or(0));
            columns.root_pairs.push(found.root_pairs.len() as u32);
            for (lists, indicator) in columns.roots.iter_mut().zip(&found.indicators) {
                lists.push(&indicator.numbers().collect::<Vec<_>>());
            }
            columns.below_ns.push(fastest(&mut pairs, |pairs| {
                descent.all_pairs_below(fixed, moving, pose, &found.root_pairs, pairs)
            })?);
            Ok(())
        })?;
        let trees = [self.subtrees(0, cuts[0])?, self.subtrees(1, cuts[1])?];
        let outline_bytes = [trees[0].0, trees[1].0];
        Ok(CutRecording {
            depths,
            outline_bytes,
            subtrees: trees.map(|(_, columns)| columns),
            scenarios: columns,
        })
    }

    /// Bytes of the outline, and what each subtree costs.
    fn subtrees(&self, tree: usize, cut: Cut) -> Result<(u64, SubtreeColumns), RecordError> {
        let view = self.trees()[tree];
        let subtrees = Subtrees::new(view, cut);
        let roots = CutTree::new(view, cut);
        let outline = subtrees.outline();
        let mut receivers = [PartialTree::new(&outline)?, PartialTree::new(&outline)?];
        let mut columns = SubtreeColumns::default();
        for (root, triangles) in (0..).zip(roots.roots().iter().map(|root| root.triangles)) {
            let begin = thread_ns();
            let message = subtrees.message(root).map_err(SubtreeError::from)?;
            columns.make_ns.push(thread_ns() - begin);
            let begin = thread_ns();
            let packed = compressed(&message);
            columns.pack_ns.push(thread_ns() - begin);
            let packed = packed.as_ref().unwrap_or(&message);
            columns.packed_bytes.push(packed.len() as u64);
            let [plain, unpacking] = &mut receivers;
            columns.place_ns.push(placing_ns(plain, &message)?);
            columns.place_packed_ns.push(placing_ns(unpacking, packed)?);
            columns.bytes.push(message.len() as u64);
            columns.triangles.push(triangles);
        }
        Ok((outline.len() as u64, columns))
    }

    /// C_b; 0 if the scenarios do not tell it from C_p.
    fn box_test_ns(&self) -> Result<f64, RecordError> {
        let [fixed, moving] = self.trees();
        let (mut descent, mut pairs) = (Descent::default(), Vec::new());
        let mut costs = Vec::new();
        let step = self.scene.poses.len().div_ceil(COUNTED);
        for (scenario, pose) in self.scene.poses.iter().enumerate().step_by(step) {
            pairs.clear();
            let begin = thread_ns();
            let counts = descent.counted_pairs(&fixed, &moving, pose, &mut pairs);
            let descent_ns = thread_ns() - begin;
            let counts = counts.map_err(|source| RecordError::Scenario { scenario, source })?;
            costs.push(CostRecord { counts, descent_ns });
        }
        Ok(CostFit::of(&costs).map_or(0.0, |fit| fit.c_b_ns))
    }
}

fn placing_ns(receiver: &mut PartialTree, message: &[u8]) -> Result<u64, SubtreeError> {
    let begin = thread_ns();
    receiver.add(message)?;
    Ok(thread_ns() - begin)
}

/// What a worker does for a scenario, in nanoseconds.
fn fastest(
    pairs: &mut Vec<Pair>,
    mut descend: impl FnMut(&mut Vec<Pair>) -> Result<(), DescentError>,
) -> Result<u64, DescentError> {
    let mut fastest = u64::MAX;
    for _ in 0..ROUNDS {
        let begin = thread_ns();
        pairs.clear();
        descend(pairs)?;
        sort(pairs);
        std::hint::black_box(pairs_fnv1a64(pairs));
        fastest = fastest.min(thread_ns() - begin);
    }
    Ok(fastest)
}

/// Nanoseconds of looking one distributed root up in a client's indicator: a node's score is a sum
/// of these.
fn score_root_ns() -> f64 {
    const ROOTS: u32 = 4096;
    const TIMES: u32 = 256;
    let indicator = TreeIndicator::of((0..ROOTS).map(|root| (root, 1 + root % 7)));
    let mut client = ClientIndicator::default();
    client.give(&indicator, |_| {});
    let begin = thread_ns();
    for _ in 0..TIMES {
        std::hint::black_box(client.score(std::hint::black_box(&indicator)));
    }
    (thread_ns() - begin) as f64 / f64::from(ROOTS * TIMES)
}
